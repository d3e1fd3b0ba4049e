#include "session.hpp"

#include <algorithm>
#include <utility>

#include "protocol/axis_samples.hpp"
#include "protocol_names.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::int64_t kFrameNs = 1'000'000;
// The user is promised to be asked every 20 ms.
constexpr auto kAskEvery = 10ms;
// How long a waiting thread in virtual time stands aside for others when it asks.
constexpr auto kStandAside = 20us;
constexpr std::int64_t kDisarmTimeoutNs = 250'000'000;

State state_of(protocol::State state) { return static_cast<State>(state); }
static_assert(static_cast<int>(State::fault) == static_cast<int>(protocol::State::fault));

}  // namespace

/// Acknowledgements that somebody waits for; gives up on them when it goes out of scope.
class Session::Expectation {
 public:
  explicit Expectation(Session& session) : session_(session) {}
  Expectation(const Expectation&) = delete;
  Expectation& operator=(const Expectation&) = delete;
  ~Expectation() {
    const std::lock_guard lock(session_.mutex_);
    std::erase_if(session_.pending_, [&](const Pending& pending) {
      return std::ranges::find(sequences_, pending.sequence) != sequences_.end();
    });
  }

  void add(std::uint16_t sequence) {
    const std::lock_guard lock(session_.mutex_);
    sequences_.push_back(sequence);
    session_.pending_.push_back({sequence, {}});
  }

  // With the session's lock held.
  [[nodiscard]] bool met() const {
    return std::ranges::all_of(sequences_,
                               [&](auto sequence) { return find(sequence).answer.has_value(); });
  }
  [[nodiscard]] std::vector<protocol::Acknowledgement> answers() const {
    std::vector<protocol::Acknowledgement> answers;
    for (const std::uint16_t sequence : sequences_) answers.push_back(*find(sequence).answer);
    return answers;
  }

 private:
  [[nodiscard]] const Pending& find(std::uint16_t sequence) const {
    return *std::ranges::find(session_.pending_, sequence, &Pending::sequence);
  }

  Session& session_;
  std::vector<std::uint16_t> sequences_;
};

Session::Session(std::unique_ptr<Transport> transport, SessionOptions options)
    : transport_(std::move(transport)), options_(std::move(options)), ring_(options_.ring_samples) {
  if (!transport_->time_is_virtual()) reader_ = std::thread([this] { read_loop(); });
}

Session::~Session() { close(false); }

void Session::close(bool disarm_first) noexcept {
  const std::lock_guard closing(close_mutex_);
  if (closed_) return;
  closing_ = true;  // from here on nobody asks the user
  if (disarm_first) {
    try {
      if (state() == State::armed) {
        protocol::ReportBytes disarm =
            protocol::encode(protocol::Command{0, 0, protocol::Op::disarm});
        Expectation expectation(*this);
        expectation.add(stamp(disarm));
        write(disarm);
        wait_until([&] { return expectation.met(); }, kDisarmTimeoutNs);
      }
    } catch (...) {  // NOLINT(bugprone-empty-catch): the device's watchdog does it then
    }
  }
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  news_.notify_all();
  if (reader_.joinable()) reader_.join();
  transport_->close();
}

// Time -------------------------------------------------------------------------------------------

/// Lets time pass until `done()`, which is called with the lock held.
/// @returns false if the time is over first
template <class Done>
bool Session::wait_until(Done done, std::int64_t timeout_ns) {
  std::unique_lock lock(mutex_);
  const std::int64_t now_ns = transport_->now_ns();
  const std::int64_t deadline_ns =
      timeout_ns < INT64_MAX - now_ns ? now_ns + timeout_ns : INT64_MAX;
  auto ask_at = steady_clock::now() + kAskEvery;
  while (true) {
    // What has arrived counts even if the device is gone now.
    if (done()) return true;
    throw_if_gone();
    if (transport_->now_ns() >= deadline_ns) return false;

    if (steady_clock::now() >= ask_at) {
      lock.unlock();
      if (options_.interrupted && !closing_ && options_.interrupted()) {
        throw Interrupted("interrupted by the program that uses the knob");
      }
      if (transport_->time_is_virtual()) std::this_thread::sleep_for(kStandAside);
      ask_at = steady_clock::now() + kAskEvery;
      lock.lock();
    } else if (transport_->time_is_virtual()) {
      pass_frame(deadline_ns);
    } else {
      const auto left = std::chrono::nanoseconds(deadline_ns - transport_->now_ns());
      news_.wait_until(lock, std::min<steady_clock::time_point>(
                                 ask_at, steady_clock::now() +
                                             std::min<std::chrono::nanoseconds>(left, kAskEvery)));
    }
  }
}

void Session::throw_if_gone() const {
  if (closed_) throw Closed("the knob was closed; open it again");
  if (!lost_.empty()) throw Disconnected(lost_);
}

/// Virtual time: passes to the next frame of the cable, but not beyond `limit_ns`. Input is taken
/// in and signs of life are sent at frames only, which lie at absolute times, so that it makes no
/// difference how calls cut the time.
void Session::pass_frame(std::int64_t limit_ns) {
  const std::int64_t frame = transport_->now_ns() / kFrameNs + 1;
  if (frame * kFrameNs > limit_ns) {
    transport_->advance_to(limit_ns);
    return;
  }
  transport_->advance_to(frame * kFrameNs);
  take_in_virtual();
  const std::int64_t keep_alive_frames = std::max<std::int64_t>(keep_alive_ns_ / kFrameNs, 1);
  if (state_ == State::armed && frame % keep_alive_frames == 0) send_keep_alive();
}

void Session::take_in_virtual() {
  try {
    protocol::ReportBytes report;
    while (transport_->read(report, 0ns)) dispatch(report);
  } catch (const std::exception& error) {
    lose(error.what());
  }
}

void Session::sleep(std::int64_t duration_ns) {
  wait_until([] { return false; }, duration_ns);
}

bool Session::wait_for(State state, std::int64_t timeout_ns) {
  return wait_until([&] { return state_ == state; }, timeout_ns);
}

// Out --------------------------------------------------------------------------------------------

std::uint16_t Session::stamp(protocol::ReportBytes& report) {
  // 0 is for reports that nobody waits for.
  std::uint16_t sequence = ++sequence_;
  if (sequence == 0) sequence = ++sequence_;
  // Every report that the host sends begins with its id and its sequence number.
  report[1] = static_cast<std::uint8_t>(sequence & 0xFFU);
  report[2] = static_cast<std::uint8_t>(sequence >> 8U);
  return sequence;
}

void Session::write(const protocol::ReportBytes& report) {
  {
    const std::lock_guard lock(mutex_);
    throw_if_gone();
  }
  try {
    // A full queue empties by one report a frame.
    while (!transport_->write(report)) sleep(kFrameNs);
  } catch (const Disconnected& error) {
    const std::lock_guard lock(mutex_);
    lose(error.what());
    throw;
  }
  ++reports_sent_;
}

void Session::send_while_armed(protocol::ReportBytes report) {
  // A lost device is no matter of arming: write() finds it.
  if (const State known = state(); known == State::disarmed || known == State::fault) {
    protocol::Acknowledgement answer;
    answer.report = report[0];
    answer.status = static_cast<std::uint8_t>(protocol::Status::not_armed);
    throw_if_refused(answer);
  }
  stamp(report);
  write(report);
}

bool Session::send_keep_alive() noexcept {
  try {
    const bool sent =
        transport_->write(protocol::encode(protocol::Command{0, 0, protocol::Op::keep_alive}));
    if (sent) ++reports_sent_;
    return sent;
  } catch (...) {
    return false;  // whoever reads next finds out that the device is gone
  }
}

std::vector<protocol::Acknowledgement> Session::exchange(std::span<protocol::ReportBytes> reports) {
  Expectation expectation(*this);
  for (protocol::ReportBytes& report : reports) {
    expectation.add(stamp(report));
    write(report);
  }
  await(expectation);
  const std::lock_guard lock(mutex_);
  return expectation.answers();
}

void Session::await(Expectation& expectation) {
  if (!wait_until([&] { return expectation.met(); }, options_.command_timeout_ns)) {
    throw Timeout("the device did not answer within " +
                  std::to_string(options_.command_timeout_ns / 1'000'000) +
                  " ms; unplug it and plug it in again if that goes on");
  }
}

void Session::throw_if_refused(const protocol::Acknowledgement& answer) {
  if (answer.status == 0) return;
  const std::string status = status_name(answer.status);
  const std::string report = report_name(answer.report);
  const std::string field = report_field_name(answer.report, answer.field);
  std::string message = "the device refused the " + report + " report (" + status;
  if (!field.empty()) message += ", field " + field;
  message += "): " + std::string(status_advice(answer.status));
  throw Refused(message, status, report, field);
}

// Feature reports
// ----------------------------------------------------------------------------------

protocol::ReportBytes Session::get_feature(std::uint8_t id) {
  {
    const std::lock_guard lock(mutex_);
    throw_if_gone();
  }
  try {
    protocol::ReportBytes report{};
    if (transport_->get_feature(id, report)) return report;
  } catch (const Disconnected& error) {
    const std::lock_guard lock(mutex_);
    lose(error.what());
    throw;
  }
  throw Error("the device does not give its " + report_name(id) + " report");
}

void Session::check_feature(protocol::Verdict verdict, std::uint8_t id) {
  if (verdict.ok()) return;
  throw Error("the device's " + report_name(id) + " report is damaged (" +
              status_name(static_cast<std::uint8_t>(verdict.status)) + "); try again");
}

void Session::set_feature(protocol::ReportBytes report) {
  {
    const std::lock_guard lock(mutex_);
    throw_if_gone();
  }
  Expectation expectation(*this);
  expectation.add(stamp(report));
  try {
    if (!transport_->set_feature(report)) throw_stalled(report[0]);
    ++reports_sent_;
  } catch (const Disconnected& error) {
    const std::lock_guard lock(mutex_);
    lose(error.what());
    throw;
  }
  await(expectation);
  const std::lock_guard lock(mutex_);
  throw_if_refused(expectation.answers().front());
}

/// A stalled request carries no reason; the device's state tells the likely one.
void Session::throw_stalled(std::uint8_t id) {
  const auto health = get<protocol::Health>();
  note(health);
  protocol::Acknowledgement answer;
  answer.report = id;
  answer.status = static_cast<std::uint8_t>(health.state == protocol::State::armed
                                                ? protocol::Status::not_disarmed
                                                : protocol::Status::busy);
  throw_if_refused(answer);
  std::abort();  // not reached: neither status is ok
}

// In ---------------------------------------------------------------------------------------------

void Session::read_loop() {
  auto keep_alive_at = steady_clock::now();
  while (!closed_) {
    bool armed = false;
    try {
      protocol::ReportBytes report;
      const std::chrono::nanoseconds period(keep_alive_ns_);
      const bool got = transport_->read(report, std::min<std::chrono::nanoseconds>(period, 20ms));
      {
        const std::lock_guard lock(mutex_);
        if (got) dispatch(report);
        armed = state_ == State::armed;
      }
      // Without the lock, which those who are woken want at once.
      if (got) news_.notify_all();
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex_);
      lose(error.what());
      return;
    }
    const auto now = steady_clock::now();
    if (armed && now >= keep_alive_at && send_keep_alive()) {
      keep_alive_at = now + std::chrono::nanoseconds(keep_alive_ns_);
    }
  }
}

void Session::lose(const std::string& why) {
  if (lost_.empty()) lost_ = why;
  state_ = State::disconnected;
  news_.notify_all();
}

void Session::dispatch(const protocol::ReportBytes& report) {
  ++statistics_.reports_received;
  const auto decode = [&]<class Report>(Report content) {
    if (protocol::decode(report, content).ok()) {
      dispatch(content);
    } else {
      ++statistics_.reports_undecodable;
    }
  };
  switch (report[0]) {
    case protocol::Layout<protocol::Telemetry>::id:
      decode(protocol::Telemetry{});
      break;
    case protocol::Layout<protocol::Acknowledgement>::id:
      decode(protocol::Acknowledgement{});
      break;
    case protocol::Layout<protocol::Event>::id:
      decode(protocol::Event{});
      break;
    default:
      ++statistics_.reports_undecodable;
  }
}

void Session::dispatch(const protocol::Telemetry& report) {
  const std::uint64_t samples = protocol::samples_of(report.axis_samples);
  const std::uint64_t last_tick = report.tick + report.decimation * (samples - 1);
  if (last_tick < stream_from_tick_) return;
  const auto take = [&](const TelemetrySample& sample) {
    if (sample.tick < stream_from_tick_) return;
    if (!ring_.push(sample)) ++statistics_.samples_lost;
    ++statistics_.samples_received;
    received_until_tick_ = sample.tick + 1;
  };
  statistics_.samples_lost += decoder_.decode(report, take);
}

void Session::dispatch(const protocol::Acknowledgement& answer) {
  state_ = state_of(answer.state);
  if (answer.report == protocol::Layout<protocol::LocalModel>::id) {
    ++statistics_.local_models_refused;
    statistics_.last_refusal =
        status_name(answer.status) + ": " + std::string(status_advice(answer.status));
    return;
  }
  if (answer.report == protocol::Layout<protocol::Stream>::id && answer.status == 0 &&
      std::exchange(stream_starts_, false)) {
    // Here and not where somebody waits for it: the first samples may be right behind.
    decoder_.begin_stream();
    ring_.clear();
    stream_from_tick_ = answer.tick;
    received_until_tick_ = 0;
  }
  const auto pending = std::ranges::find(pending_, answer.sequence, &Pending::sequence);
  if (pending != pending_.end()) pending->answer = answer;
}

void Session::dispatch(const protocol::Event& event) { state_ = state_of(event.state); }

// What is known
// ------------------------------------------------------------------------------------

State Session::state() {
  const std::lock_guard lock(mutex_);
  if (closed_) throw_if_gone();
  // A plug may have been pulled without any time passing.
  if (transport_->time_is_virtual() && lost_.empty()) take_in_virtual();
  return state_;
}

void Session::note(const protocol::Health& health) {
  const std::lock_guard lock(mutex_);
  if (lost_.empty()) state_ = state_of(health.state);
}

LinkStatistics Session::statistics() const {
  const std::lock_guard lock(mutex_);
  LinkStatistics statistics = statistics_;
  statistics.reports_sent = reports_sent_;
  return statistics;
}

void Session::set_watchdog(double watchdog_s) {
  keep_alive_ns_ = static_cast<std::int64_t>(watchdog_s * 1e9 / 3.0);
}

// Telemetry
// ----------------------------------------------------------------------------------------

void Session::set_identity(const protocol::Identity& identity) {
  const std::lock_guard lock(mutex_);
  decoder_.configure(identity);
}

void Session::set_position(std::int64_t counts) {
  const std::lock_guard lock(mutex_);
  decoder_.set_position(counts);
}

void Session::stream(std::uint8_t decimation) {
  {
    const std::lock_guard lock(mutex_);
    stream_starts_ = decimation != 0;
  }
  request(protocol::Stream{0, 0, decimation});
}

std::size_t Session::read(std::span<TelemetrySample> out, std::int64_t timeout_ns) {
  std::size_t count = 0;
  wait_until(
      [&] {
        count = ring_.pop(out);
        return count > 0 || out.empty();
      },
      timeout_ns);
  return count;
}

std::vector<TelemetrySample> Session::collect(std::uint64_t first_tick, std::uint64_t end_tick,
                                              unsigned decimation, std::int64_t silence_ns) {
  std::vector<TelemetrySample> collected;
  constexpr std::uint64_t kReserveAtMost =
      1U << 20U;  // some recordings last until they are interrupted
  collected.reserve(std::min((end_tick - first_tick) / decimation + 1, kReserveAtMost));
  const auto take = [&] {
    TelemetrySample sample;
    while (ring_.size() > 0 && ring_.front().tick < end_tick) {
      ring_.pop({&sample, 1});
      if (sample.tick >= first_tick) collected.push_back(sample);
    }
    return received_until_tick_ + decimation > end_tick;
  };
  // As long as samples come, the device is alive, however slow its world: a paced one on a busy
  // machine falls behind the wall clock.
  std::uint64_t known_until_tick = 0;
  while (!wait_until(take, silence_ns)) {
    const std::lock_guard lock(mutex_);
    if (received_until_tick_ > known_until_tick) {
      known_until_tick = received_until_tick_;
      continue;
    }
    throw Timeout("telemetry dried up: " + std::to_string(collected.size()) +
                  " samples came, then nothing more; does another program use the device?");
  }
  return collected;
}

}  // namespace torsio
