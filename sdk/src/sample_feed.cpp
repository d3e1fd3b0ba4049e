#include "sample_feed.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "protocol/axis_samples.hpp"
#include "protocol_names.hpp"
#include "torsio/error.hpp"
#include "torsio/knob.hpp"

namespace torsio {

void SampleFeed::set_position(std::int64_t counts) {
  const Link::Locked locked = link_.lock();
  decoder_.set_position(counts);
}

void SampleFeed::stream(std::uint8_t decimation, bool prompt) {
  {
    const Link::Locked locked = link_.lock();
    stream_starts_ = decimation != 0;
  }
  requests_.request(
      protocol::Stream{0, 0, decimation, prompt ? protocol::Toggle::on : protocol::Toggle::off});
}

void SampleFeed::stop_quietly() noexcept {
  const Link::Unasked unasked(link_);
  try {
    requests_.say(protocol::encode(protocol::Stream{}));
  } catch (...) {  // NOLINT(bugprone-empty-catch): a device that is gone sends nothing
  }
}

std::optional<TelemetrySample> SampleFeed::latest(std::int64_t timeout_ns) {
  link_.wait_until([&](const Link::Locked&) { return latest_.has_value(); }, timeout_ns);
  const Link::Locked locked = link_.lock();
  return latest_;
}

std::size_t SampleFeed::read(std::span<TelemetrySample> out, std::int64_t timeout_ns) {
  std::size_t count = 0;
  link_.wait_until(
      [&](const Link::Locked&) {
        count = ring_.pop(out);
        return count > 0 || out.empty();
      },
      timeout_ns);
  return count;
}

void SampleFeed::take(const Link::Locked& locked, const protocol::Telemetry& report) {
  const std::uint64_t samples = protocol::samples_of(report.axis_samples);
  const std::uint64_t last_tick = report.tick + report.decimation * (samples - 1);
  if (last_tick < stream_from_tick_) return;
  std::uint64_t received = 0;
  std::uint64_t unread = 0;
  const auto take = [&](const TelemetrySample& sample) {
    if (sample.tick < stream_from_tick_) return;
    // A recording loses nothing.
    bool taken = false;
    for (Listener* listener : listeners_) taken |= listener->take(locked, sample);
    if (!ring_.push(sample) && !taken) ++unread;
    ++received;
    if (sample.tick == last_tick) latest_ = sample;
    link_.note_tick(locked, sample.tick);
  };
  const std::uint64_t missing = decoder_.decode(report, take);
  link_.count_samples(locked, received, missing + unread);
  device_.take(locked, static_cast<State>(report.flags & protocol::flag::state_mask), last_tick);
}

void SampleFeed::take(const Link::Locked&, const protocol::Acknowledgement& answer) {
  if (answer.report != protocol::Layout<protocol::Stream>::id || answer.status != 0) return;
  if (!std::exchange(stream_starts_, false)) return;
  // Here and not where somebody waits for it: the first samples may be right behind.
  decoder_.begin_stream();
  ring_.clear();
  stream_from_tick_ = answer.tick;
  latest_.reset();
}

SampleFeed::Listener::Listener(SampleFeed& feed, TelemetryRecord& into)
    : feed_(feed), into_(into), had_(into.size()) {
  const Link::Locked locked = feed_.link_.lock();
  disarms_before_ = feed_.device_.disarms(locked);
  feed_.listeners_.push_back(this);
}

SampleFeed::Listener::~Listener() {
  const Link::Locked locked = feed_.link_.lock();
  std::erase(feed_.listeners_, this);
  // Samples from before the start was known.
  if (end_tick_ == UINT64_MAX)
    into_.erase(into_.begin() + static_cast<std::ptrdiff_t>(had_), into_.end());
}

/// @returns false if the sample does not belong to it
bool SampleFeed::Listener::take(const Link::Locked&, const TelemetrySample& sample) {
  received_until_tick_ = sample.tick + 1;
  if (sample.tick < first_tick_ || sample.tick >= end_tick_) return false;
  try {
    into_.push_back(sample);
  } catch (...) {
    failure_ = std::current_exception();
  }
  return true;
}

void SampleFeed::Listener::begin(std::uint64_t first_tick, std::uint64_t end_tick) {
  const Link::Locked locked = feed_.link_.lock();
  first_tick_ = first_tick;
  end_tick_ = end_tick;
  into_.erase(std::remove_if(into_.begin() + static_cast<std::ptrdiff_t>(had_), into_.end(),
                             [&](const TelemetrySample& sample) {
                               return sample.tick < first_tick || sample.tick >= end_tick;
                             }),
              into_.end());
}

void SampleFeed::Listener::throw_disarmed(const Disarm& disarm) const {
  throw Disarmed("the recording was to stay armed, but " + disarm_text(disarm) +
                     "; samples until then: " + std::to_string(into_.size() - had_),
                 disarm_reason_name(disarm.reason));
}

/// Read once is read.
void SampleFeed::Listener::take_what_was_read(const Link::Locked&) {
  TelemetrySample read{};
  while (feed_.ring_.size() > 0 && feed_.ring_.front().tick < end_tick_) {
    feed_.ring_.pop({&read, 1});
    if (read.tick < first_tick_) into_.unread_before.push_back(read);
  }
}

void SampleFeed::Listener::run(std::uint64_t first_tick, std::uint64_t end_tick,
                               std::int64_t silence_ns, bool must_stay_armed) {
  begin(first_tick, end_tick);
  const auto fallen = [&](const Link::Locked& locked) {
    return must_stay_armed ? feed_.device_.disarm_since(locked, disarms_before_) : std::nullopt;
  };
  // No sample of the span comes any more once the next one would lie behind it.
  const auto done = [&](const Link::Locked& locked) {
    return failure_ != nullptr || fallen(locked) ||
           received_until_tick_ + feed_.decoder_.decimation() > end_tick_;
  };
  // As long as samples come, the device is alive, however slow its world: a paced one on a busy
  // machine falls behind the wall clock.
  std::uint64_t known_until_tick = 0;
  while (!feed_.link_.wait_until(done, silence_ns)) {
    const Link::Locked locked = feed_.link_.lock();
    if (received_until_tick_ > known_until_tick) {
      known_until_tick = received_until_tick_;
      continue;
    }
    throw Timeout("telemetry dried up; samples until then: " + std::to_string(into_.size() - had_) +
                  ". Does another program use the device?");
  }
  const Link::Locked locked = feed_.link_.lock();
  if (failure_ != nullptr) std::rethrow_exception(failure_);
  if (const auto disarm = fallen(locked)) throw_disarmed(*disarm);
  take_what_was_read(locked);
}

std::optional<Disarm> SampleFeed::Listener::disarmed() const {
  const Link::Locked locked = feed_.link_.lock();
  return feed_.device_.disarm_since(locked, disarms_before_);
}

}  // namespace torsio
