#include "link.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "protocol/reports.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

// The user is promised to be asked every 20 ms.
constexpr auto kAskUserEvery = 10ms;
// How long a waiting thread in virtual time stands aside for others when it asks.
constexpr auto kStandAside = 20us;
// A virtual clock stands still if so many frames and so long a time of the wall's do not move it.
constexpr int kStillFrames = 100;
constexpr auto kStill = 1s;
// Of one look: more than any device has ready, and a transport that never ends.
constexpr int kMostReports = 256;
// For a read that promises to come back within 20 ms. Pieces, so that a stopped process counts
// once.
constexpr int kWaitsForRead = 250;
constexpr auto kWaitForRead = 20ms;

}  // namespace

void throw_late(const std::string& what, std::int64_t timeout_ns) {
  throw Timeout(what + " within " + std::to_string(timeout_ns / 1'000'000) +
                " ms; unplug it and plug it in again if that goes on");
}

Link::Link(std::unique_ptr<Transport> transport, std::function<bool()> interrupted,
           Receiver& receiver)
    : transport_(std::move(transport)), interrupted_(std::move(interrupted)), receiver_(receiver) {}

void Link::start() {
  if (time_is_virtual()) return;
  const Locked start = lock();
  reader_ = std::thread([this] {
    read_loop();
    bool lets_go = false;
    {
      const Locked locked = lock();
      reads_ = false;
      lets_go = let_go_;
      news_.notify_all();
    }
    if (lets_go) transport_->close();
  });
  reads_ = true;
}

Link::~Link() {
  if (reader_.joinable()) reader_.join();
}

void Link::stop() noexcept {
  Locked locked = lock();
  stopped_ = true;
  news_.notify_all();
  for (int waits = 0; reads_ && waits < kWaitsForRead; ++waits) {
    news_.wait_for(locked.lock_, kWaitForRead, [&] { return !reads_; });
  }
}

void Link::let_go() noexcept {
  Locked locked = lock();
  if (!reads_) {
    locked.lock_.unlock();
    transport_->close();
    locked.lock_.lock();
  }
  let_go_ = true;
  news_.notify_all();
}

bool Link::is_held() const noexcept {
  const Locked locked = lock();
  return reads_;
}

void Link::wait_until_let_go() noexcept {
  Locked locked = lock();
  news_.wait(locked.lock_, [&] { return let_go_; });
}

void Link::throw_unless_here() const {
  if (is_here()) return;
  throw Closed("the knob belongs to the process that this one was forked from; open it here");
}

void Link::throw_if_gone(const Locked&) const {
  if (stopped_) throw Closed("the knob was closed; open it again");
  if (is_lost_) throw Disconnected(why_lost_);
}

// Time -------------------------------------------------------------------------------------------

bool Link::wait_until(const std::function<bool(const Locked&)>& done, std::int64_t timeout_ns) {
  Locked locked = lock();
  const std::int64_t begin_ns = now_ns();
  const std::int64_t deadline_ns =
      begin_ns > 0 && timeout_ns > INT64_MAX - begin_ns ? INT64_MAX : begin_ns + timeout_ns;
  auto ask_at = steady_clock::now() + kAskUserEvery;
  std::int64_t frame = begin_ns / kFrameNs;
  int still_frames = 0;
  auto moved_at = steady_clock::now();
  while (true) {
    // Arrived reports count even if the device is gone now.
    if (done(locked)) return true;
    throw_if_gone(locked);
    // To ask a virtual clock takes a lock, so it is asked once a frame.
    const std::int64_t now_ns = transport_->now_ns();
    if (now_ns >= deadline_ns) return false;
    const auto wall = steady_clock::now();
    if (now_ns / kFrameNs > frame) {
      frame = now_ns / kFrameNs;
      still_frames = 0;
      moved_at = wall;
    } else if (still_frames > kStillFrames && wall - moved_at > kStill) {
      throw Timeout("the transport's clock stands still; its time must pass in advance_to");
    }

    if (wall >= ask_at) {
      locked.lock_.unlock();
      ask_user();
      ask_at = steady_clock::now() + kAskUserEvery;
      locked.lock_.lock();
    } else if (time_is_virtual()) {
      pass_frame(locked, now_ns, deadline_ns);
      ++still_frames;
      locked.lock_.unlock();
      receiver_.tell();
      locked.lock_.lock();
    } else {
      const auto left = std::chrono::nanoseconds(deadline_ns - now_ns);
      news_.wait_until(locked.lock_,
                       std::min<steady_clock::time_point>(
                           ask_at, steady_clock::now() +
                                       std::min<std::chrono::nanoseconds>(left, kAskUserEvery)));
    }
  }
}

void Link::ask_user() {
  if (interrupted_ && unasked_ == 0 && interrupted_()) {
    throw Interrupted("interrupted by the program that uses the knob");
  }
  if (time_is_virtual()) std::this_thread::sleep_for(kStandAside);
}

void Link::sleep(std::int64_t duration_ns) {
  wait_until([](const Locked&) { return false; }, duration_ns);
}

/// Virtual time: passes from now to the next frame of the cable, but not beyond `limit_ns`. Input
/// is read and signs of life are sent at frames only. Frames lie at absolute times, so it does not
/// matter how calls cut the time.
void Link::pass_frame(const Locked& locked, std::int64_t now_ns, std::int64_t limit_ns) {
  const std::int64_t frame = now_ns / kFrameNs + 1;
  if (frame * kFrameNs > limit_ns) {
    transport_->advance_to(limit_ns);
    return;
  }
  transport_->advance_to(frame * kFrameNs);
  take_in_virtual(locked);
  const std::int64_t keep_alive_frames = std::max<std::int64_t>(keep_alive_ns_ / kFrameNs, 1);
  if (receiver_.is_armed(locked) && frame % keep_alive_frames == 0 && send_keep_alive()) {
    log(locked, true, keep_alive_report());
  }
}

void Link::take_in_virtual(const Locked& locked) {
  try {
    protocol::ReportBytes report;
    for (int n = 0; n < kMostReports && transport_->read(report, 0ns); ++n) take(locked, report);
  } catch (const Interrupted&) {
    throw;  // it is the program that ends here, not the device
  } catch (const std::exception& error) {
    lose(locked, error.what());
  }
}

void Link::look(const Locked& locked) {
  if (stopped_) throw_if_gone(locked);
  if (time_is_virtual() && !is_lost_) take_in_virtual(locked);
}

// In ---------------------------------------------------------------------------------------------

void Link::read_loop() {
  auto keep_alive_at = steady_clock::now();
  while (!stopped_) {
    try {
      bool armed = false;
      protocol::ReportBytes report;
      const std::chrono::nanoseconds period(keep_alive_ns_);
      const bool got = transport_->read(report, std::min<std::chrono::nanoseconds>(period, 20ms));
      {
        const Locked locked = lock();
        if (got) take(locked, report);
        armed = receiver_.is_armed(locked);
      }
      // Without the lock, which those who are woken want at once.
      if (got) news_.notify_all();
      const auto now = steady_clock::now();
      if (armed && now >= keep_alive_at && send_keep_alive()) {
        keep_alive_at = now + std::chrono::nanoseconds(keep_alive_ns_);
        log(lock(), true, keep_alive_report());
      }
    } catch (const std::exception& error) {
      lose(lock(), error.what());
      return;
    }
  }
}

void Link::take(const Locked& locked, const protocol::ReportBytes& report) {
  log(locked, false, report);
  if (!receiver_.take(locked, report)) ++statistics_.reports_undecodable;
}

void Link::lose(const Locked& locked, const std::string& why) {
  if (!is_lost_) {
    why_lost_ = why;
    is_lost_ = true;
    receiver_.lose(locked);
  }
  news_.notify_all();
}

// Out --------------------------------------------------------------------------------------------

/// Has the transport do something. A thread that finds the device gone tells all.
template <class Act>
void Link::on_transport(Act&& act) {
  throw_if_gone(lock());
  try {
    act();
  } catch (const Disconnected& error) {
    lose(lock(), error.what());
    throw;
  }
}

void Link::write(const protocol::ReportBytes& report, std::int64_t timeout_ns) {
  on_transport([&] {
    // The order goes before the clock, which may fail.
    std::optional<std::int64_t> begin_ns;
    // A full queue empties by one report a frame.
    while (!transport_->write(report)) {
      if (!begin_ns) begin_ns = now_ns();
      if (now_ns() - *begin_ns >= timeout_ns) {
        throw_late("the way to the device had no room", timeout_ns);
      }
      sleep(kFrameNs);
    }
    log(lock(), true, report);
  });
}

bool Link::write_blindly(const protocol::ReportBytes& report) {
  if (!transport_->write(report)) return false;
  log(lock(), true, report);
  return true;
}

bool Link::set_feature(const protocol::ReportBytes& report) {
  bool taken = false;
  on_transport([&] {
    taken = transport_->set_feature(report);
    if (taken) log(lock(), true, report);
  });
  return taken;
}

bool Link::get_feature(std::uint8_t id, protocol::ReportBytes& report) {
  bool given = false;
  on_transport([&] { given = transport_->get_feature(id, report); });
  return given;
}

protocol::ReportBytes Link::keep_alive_report() {
  return protocol::encode(protocol::Command{0, 0, protocol::Op::keep_alive});
}

bool Link::send_keep_alive() {
  try {
    return transport_->write(keep_alive_report());
  } catch (const Interrupted&) {
    throw;  // it is the program that ends here, not the device
  } catch (...) {
    return false;  // the next read finds out that the device is gone
  }
}

void Link::set_watchdog(double watchdog_s) {
  keep_alive_ns_ = static_cast<std::int64_t>(watchdog_s * 1e9 / 3.0);
}

class Link::Tap final : public ReportTap {
 public:
  Tap(bool with_telemetry, std::vector<LoggedReport> begin)
      : with_telemetry_(with_telemetry), reports_(std::move(begin)) {}

  void add(const LoggedReport& report) {
    const bool is_telemetry = report.bytes[0] == protocol::Layout<protocol::Telemetry>::id;
    if (is_telemetry && !with_telemetry_) return;
    const std::lock_guard lock(mutex_);
    reports_.push_back(report);
  }

  std::vector<LoggedReport> take() override {
    const std::lock_guard lock(mutex_);
    return std::exchange(reports_, {});
  }

 private:
  const bool with_telemetry_;
  std::mutex mutex_;
  std::vector<LoggedReport> reports_;
};

std::shared_ptr<ReportTap> Link::tap(bool with_telemetry, std::vector<LoggedReport> begin) {
  auto tap = std::make_shared<Tap>(with_telemetry, std::move(begin));
  const Locked locked = lock();
  taps_.push_back(tap);
  return tap;
}

void Link::count_samples(const Locked&, std::uint64_t received, std::uint64_t lost) {
  statistics_.samples_received += received;
  statistics_.samples_lost += lost;
}

void Link::count_refused_model(const Locked&, std::string why) {
  ++statistics_.local_models_refused;
  statistics_.last_refusal = std::move(why);
}

/// Counts a report, and shows it to the taps.
void Link::log(const Locked&, bool sent, const protocol::ReportBytes& report) {
  ++(sent ? statistics_.reports_sent : statistics_.reports_received);
  std::erase_if(taps_, [](const auto& tap) { return tap.expired(); });
  for (const auto& weak : taps_) {
    if (const auto tap = weak.lock()) tap->add({newest_tick_, sent, report});
  }
}

}  // namespace torsio
