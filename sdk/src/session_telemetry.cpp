// Session: streams of samples, and recordings.
#include <algorithm>
#include <string>

#include "protocol_names.hpp"
#include "session.hpp"
#include "torsio/error.hpp"
#include "torsio/knob.hpp"

namespace torsio {

void Session::set_identity(const protocol::Identity& identity) {
  const std::lock_guard lock(mutex_);
  decoder_.configure(identity);
}

void Session::set_position(std::int64_t counts) {
  const std::lock_guard lock(mutex_);
  decoder_.set_position(counts);
}

void Session::stream(std::uint8_t decimation, bool prompt) {
  {
    const std::lock_guard lock(mutex_);
    stream_starts_ = decimation != 0;
  }
  request(
      protocol::Stream{0, 0, decimation, prompt ? protocol::Toggle::on : protocol::Toggle::off});
}

std::optional<TelemetrySample> Session::latest(std::int64_t timeout_ns) {
  wait_until([&] { return latest_.has_value(); }, timeout_ns);
  const std::lock_guard lock(mutex_);
  return latest_;
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

Session::Listener::Listener(Session& session, TelemetryRecord& into)
    : session_(session), into_(into), had_(into.size()) {
  const std::lock_guard lock(session_.mutex_);
  disarms_before_ = session_.disarms_;
  session_.listeners_.push_back(this);
}

Session::Listener::~Listener() {
  const std::lock_guard lock(session_.mutex_);
  std::erase(session_.listeners_, this);
  // Samples from before the start was known.
  if (end_tick_ == UINT64_MAX)
    into_.erase(into_.begin() + static_cast<std::ptrdiff_t>(had_), into_.end());
}

/// @returns false if the sample does not belong to it. With the session's lock held, maybe in the
/// reading thread.
bool Session::Listener::take(const TelemetrySample& sample) {
  received_until_tick_ = sample.tick + 1;
  if (sample.tick < first_tick_ || sample.tick >= end_tick_) return false;
  try {
    into_.push_back(sample);
  } catch (...) {
    failure_ = std::current_exception();
  }
  return true;
}

void Session::Listener::run(std::uint64_t first_tick, std::uint64_t end_tick,
                            std::int64_t silence_ns, bool must_stay_armed) {
  {
    const std::lock_guard lock(session_.mutex_);
    first_tick_ = first_tick;
    end_tick_ = end_tick;
    into_.erase(std::remove_if(into_.begin() + static_cast<std::ptrdiff_t>(had_), into_.end(),
                               [&](const TelemetrySample& sample) {
                                 return sample.tick < first_tick || sample.tick >= end_tick;
                               }),
                into_.end());
  }
  // No sample of the span comes any more once the next one would lie behind it.
  const auto done = [&] {
    return failure_ != nullptr || (must_stay_armed && session_.disarms_ != disarms_before_) ||
           received_until_tick_ + session_.decoder_.decimation() > end_tick_;
  };
  // As long as samples come, the device is alive, however slow its world: a paced one on a busy
  // machine falls behind the wall clock.
  std::uint64_t known_until_tick = 0;
  while (!session_.wait_until(done, silence_ns)) {
    const std::lock_guard lock(session_.mutex_);
    if (received_until_tick_ > known_until_tick) {
      known_until_tick = received_until_tick_;
      continue;
    }
    throw Timeout("telemetry dried up: " + std::to_string(into_.size() - had_) +
                  " samples came, then nothing more; does another program use the device?");
  }
  const std::lock_guard lock(session_.mutex_);
  if (failure_ != nullptr) std::rethrow_exception(failure_);
  if (must_stay_armed && session_.disarms_ != disarms_before_) {
    const Disarm& disarm = *session_.last_disarm_;
    throw Disarmed("the recording was to stay armed, but " + disarm_text(disarm) + "; " +
                       std::to_string(into_.size() - had_) + " samples came until then",
                   disarm_reason_name(disarm.reason));
  }
  // Read once is read.
  TelemetrySample read{};
  while (session_.ring_.size() > 0 && session_.ring_.front().tick < end_tick) {
    session_.ring_.pop({&read, 1});
    if (read.tick < first_tick) into_.unread_before.push_back(read);
  }
}

std::optional<Disarm> Session::Listener::disarmed() const {
  const std::lock_guard lock(session_.mutex_);
  if (session_.disarms_ == disarms_before_) return std::nullopt;
  return session_.last_disarm_;
}

}  // namespace torsio
