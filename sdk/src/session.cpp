#include "session.hpp"

#include <algorithm>
#include <utility>

#include "session_scopes.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

// The user is promised to be asked every 20 ms.
constexpr auto kAskEvery = 10ms;
// How long a waiting thread in virtual time stands aside for others when it asks.
constexpr auto kStandAside = 20us;
constexpr std::int64_t kLastWordsNs = 1'000'000'000;

}  // namespace

Session::Session(std::unique_ptr<Transport> transport, SessionOptions options)
    : transport_(std::move(transport)),
      options_(std::move(options)),
      events_(!transport_->time_is_virtual()),
      ring_(options_.ring_samples) {
  if (!transport_->time_is_virtual()) reader_ = std::thread([this] { read_loop(); });
}

Session::~Session() { close(false); }

void Session::close(bool disarm_first) noexcept {
  if (closing_.exchange(true)) {
    // A closing thread waits for the callback, or has called it. So the callback must not wait for
    // the close.
    if (events_.tells_here()) return;
    {
      std::unique_lock lock(mutex_);
      news_.wait(lock, [&] { return all_closed_; });
    }
    events_.close();
    return;
  }
  if (disarm_first) disarm_quietly();
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  news_.notify_all();
  if (reader_.joinable()) reader_.join();
  events_.close();
  transport_->close();
  const std::lock_guard lock(mutex_);
  all_closed_ = true;
  news_.notify_all();
}

void Session::disarm_quietly() noexcept {
  const Unasked unasked(*this);
  const protocol::Command disarm{0, 0, protocol::Op::disarm};
  try {
    if (!drives() && !may_drive_) return;
    if (state() == State::disconnected) {
      transport_->write(protocol::encode(disarm));  // a way that gives nothing may still take
    } else {
      say(disarm);
    }
  } catch (...) {  // NOLINT(bugprone-empty-catch): the device's watchdog does it then
  }
}

/// Sends a report and gives the device a moment to answer; whether it does is all the same.
template <class Report>
void Session::say(const Report& report) {
  protocol::ReportBytes bytes = protocol::encode(report);
  Expectation expectation(*this);
  expectation.add(stamp(bytes));
  write(bytes, kLastWordsNs);
  wait_until([&] { return expectation.met(); }, kLastWordsNs);
}

void Session::stop_stream_quietly() noexcept {
  const Unasked unasked(*this);
  try {
    say(protocol::Stream{});
  } catch (...) {  // NOLINT(bugprone-empty-catch): a device that is gone sends nothing
  }
}

// Time -------------------------------------------------------------------------------------------

bool Session::wait_until(const std::function<bool()>& done, std::int64_t timeout_ns) {
  std::unique_lock lock(mutex_);
  const std::int64_t begin_ns = transport_->now_ns();
  const std::int64_t deadline_ns =
      timeout_ns < INT64_MAX - begin_ns ? begin_ns + timeout_ns : INT64_MAX;
  auto ask_at = steady_clock::now() + kAskEvery;
  while (true) {
    // Arrived reports count even if the device is gone now.
    if (done()) return true;
    throw_if_gone();
    // To ask a virtual clock takes a lock, so it is asked once a frame.
    const std::int64_t now_ns = transport_->now_ns();
    if (now_ns >= deadline_ns) return false;

    if (steady_clock::now() >= ask_at) {
      lock.unlock();
      if (options_.interrupted && unasked_ == 0 && options_.interrupted()) {
        throw Interrupted("interrupted by the program that uses the knob");
      }
      if (transport_->time_is_virtual()) std::this_thread::sleep_for(kStandAside);
      ask_at = steady_clock::now() + kAskEvery;
      lock.lock();
    } else if (transport_->time_is_virtual()) {
      pass_frame(now_ns, deadline_ns);
      lock.unlock();
      events_.tell();
      lock.lock();
    } else {
      const auto left = std::chrono::nanoseconds(deadline_ns - now_ns);
      news_.wait_until(lock, std::min<steady_clock::time_point>(
                                 ask_at, steady_clock::now() +
                                             std::min<std::chrono::nanoseconds>(left, kAskEvery)));
    }
  }
}

void Session::throw_unless_here() const {
  if (is_here()) return;
  throw Closed("the knob belongs to the process that this one was forked from; open it here");
}

void Session::throw_if_gone() const {
  if (closed_) throw Closed("the knob was closed; open it again");
  if (!lost_.empty()) throw Disconnected(lost_);
}

/// Virtual time: passes from now to the next frame of the cable, but not beyond `limit_ns`. Input
/// is read and signs of life are sent at frames only. Frames lie at absolute times, so it does not
/// matter how calls cut the time.
void Session::pass_frame(std::int64_t now_ns, std::int64_t limit_ns) {
  const std::int64_t frame = now_ns / kFrameNs + 1;
  if (frame * kFrameNs > limit_ns) {
    transport_->advance_to(limit_ns);
    return;
  }
  transport_->advance_to(frame * kFrameNs);
  take_in_virtual();
  const std::int64_t keep_alive_frames = std::max<std::int64_t>(keep_alive_ns_ / kFrameNs, 1);
  if (state_ == State::armed && frame % keep_alive_frames == 0 && send_keep_alive()) {
    log(true, keep_alive_report());
  }
}

void Session::take_in_virtual() {
  try {
    protocol::ReportBytes report;
    while (transport_->read(report, 0ns)) dispatch(report);
  } catch (const Interrupted&) {
    throw;  // it is the program that ends here, not the device
  } catch (const std::exception& error) {
    lose(error.what());
  }
}

void Session::sleep(std::int64_t duration_ns) {
  wait_until([] { return false; }, duration_ns);
}

void Session::sleep_until(std::int64_t time_ns) {
  wait_until([] { return false; }, std::max<std::int64_t>(time_ns - now_ns(), 0));
}

bool Session::wait_for(State state, std::int64_t timeout_ns) {
  return wait_until([&] { return state_ == state; }, timeout_ns);
}

}  // namespace torsio
