#include "telemetry_stream.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "conversion/field_check.hpp"
#include "protocol_names.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

// Full speed USB polls once in a millisecond. Where the user names no rate a tenth of that is left
// for acknowledgements and events. At the full rate each of these delays telemetry by a millisecond
// from then on. The device's buffer of 64 samples has room for a dozen.
constexpr double kMaxSampleRateHz = 1000.0 * protocol::samples_per_report;
constexpr double kEasySampleRateHz = 900.0 * protocol::samples_per_report;

// Most samples of one recording in memory: a day at 1,000 a second, about 6 GB.
constexpr double kMaxRecordedSamples = 1e8;

// With a report a frame that has the newest samples: when an answer takes a frame, the next report
// holds all that is there.
constexpr double kPromptSampleRateHz = 500.0 * protocol::samples_per_report;

/// Control ticks from sample to sample at the highest rate that is not above `sample_rate_hz`; a
/// little room for control rates that were computed.
double fewest_ticks(double control_rate_hz, double sample_rate_hz) {
  return std::ceil(control_rate_hz / std::min(control_rate_hz, sample_rate_hz) * (1 - 1e-9));
}

bool is_armed(const TelemetrySample& sample) {
  return static_cast<protocol::State>(sample.flags & protocol::flag::state_mask) ==
         protocol::State::armed;
}

}  // namespace

/// Keeps telemetry going for a recording: starts it, and stops it if nobody else wants it.
class TelemetryStream::Use {
 public:
  explicit Use(TelemetryStream& stream) : stream_(stream) {
    const std::lock_guard lock(stream_.mutex_);
    if (stream_.decimation_ == 0) stream_.begin(stream_.ticks_per_sample({}, false), false);
    ++stream_.recordings_;
  }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;
  ~Use() {
    const std::lock_guard lock(stream_.mutex_);
    if (--stream_.recordings_ > 0 || stream_.wanted_) return;
    stream_.decimation_ = 0;
    stream_.samples_.stop_quietly();
  }

 private:
  TelemetryStream& stream_;
};

unsigned TelemetryStream::ticks_per_sample(std::optional<double> rate_hz, bool prompt) const {
  if (!rate_hz) {
    return static_cast<unsigned>(
        fewest_ticks(control_rate_hz(), prompt ? kPromptSampleRateHz : kEasySampleRateHz));
  }
  // A prompt report leaves out what it has no room for.
  const double most_hz = prompt ? control_rate_hz() : kMaxSampleRateHz;
  const double highest_hz = std::min(control_rate_hz(), most_hz);
  const double lowest_hz = control_rate_hz() / 255.0;
  // The comparison is also false for NaN; a little room for rates that were computed.
  if (!(*rate_hz >= lowest_hz * (1 - 1e-9) && *rate_hz <= highest_hz * (1 + 1e-9))) {
    throw InvalidArgument("rate_hz is " + number_text(*rate_hz) + ", allowed are " +
                          number_text(lowest_hz) + " to " + number_text(highest_hz) +
                          " Hz with this knob; without a rate it takes the highest that "
                          "leaves room for answers");
  }
  return static_cast<unsigned>(std::clamp(std::round(control_rate_hz() / *rate_hz),
                                          fewest_ticks(control_rate_hz(), most_hz), 255.0));
}

/// With the lock held.
void TelemetryStream::begin(unsigned decimation, bool prompt) {
  samples_.set_position(requests_.get<protocol::Clock>().position_counts);
  samples_.stream(static_cast<std::uint8_t>(decimation), prompt);
  decimation_ = decimation;
}

double TelemetryStream::start(std::optional<double> rate_hz, bool prompt) {
  const unsigned decimation = ticks_per_sample(rate_hz, prompt);
  const std::lock_guard lock(mutex_);
  begin(decimation, prompt);
  wanted_ = true;
  return control_rate_hz() / decimation;
}

void TelemetryStream::stop() {
  const std::lock_guard lock(mutex_);
  wanted_ = false;
  if (recordings_ > 0) return;
  samples_.stream(0, false);
  decimation_ = 0;
}

TelemetrySample TelemetryStream::latest() {
  if (decimation_ == 0) {
    throw Error("no telemetry runs: call start_telemetry() first");
  }
  if (const auto sample = samples_.latest(command_timeout_ns_)) return *sample;
  throw Timeout("no telemetry came; does another program use the device?");
}

void TelemetryStream::check_length(std::int64_t duration_ns, unsigned decimation) const {
  const double duration_s = 1e-9 * static_cast<double>(duration_ns);
  const double longest_s = kMaxRecordedSamples * decimation / control_rate_hz();
  if (duration_s <= longest_s) return;
  throw InvalidArgument("duration_s is " + number_text(duration_s) + ", allowed are 0 to " +
                        number_text(longest_s) +
                        " s at this rate; for more take samples with read() as they come");
}

void TelemetryStream::record(TelemetryRecord& into, std::int64_t duration_ns,
                             std::optional<double> rate_hz, bool must_stay_armed) {
  const unsigned known = rate_hz ? ticks_per_sample(rate_hz, false) : decimation_.load();
  const unsigned decimation = known != 0 ? known : ticks_per_sample({}, false);
  check_length(duration_ns, decimation);
  if (rate_hz) start(rate_hz, false);
  const std::size_t had = into.size();
  SampleFeed::Listener listener(samples_, into);  // before the first sample can come
  const Use use(*this);
  if (must_stay_armed) throw_unless_armed();
  const std::uint64_t first_tick = requests_.get<protocol::Clock>().tick;
  const auto ticks =
      static_cast<std::uint64_t>(std::llround(static_cast<double>(duration_ns) / period_ns_));
  const std::int64_t report_ns =
      std::int64_t{protocol::samples_per_report} * decimation * period_ns_;
  try {
    listener.run(first_tick, first_tick + ticks, command_timeout_ns_ + report_ns, must_stay_armed);
  } catch (...) {
    into.disarmed = listener.disarmed();
    throw;
  }
  into.disarmed = listener.disarmed();
  into.armed_late = into.size() > had && !is_armed(into[had]) && is_armed(into.back());
}

void TelemetryStream::throw_unless_armed() const {
  const auto health = requests_.get<protocol::Health>();
  if (health.state == protocol::State::armed) return;
  std::optional<Disarm> disarm = device_.last_disarm();
  // Its event may still be on the way.
  if (health.faults != 0) disarm = Disarm{DisarmReason::fault, fault_names(health.faults)};
  throw Disarmed("the recording was to stay armed, but the knob is not armed: call arm() first" +
                     (disarm ? "; " + disarm_text(*disarm) : std::string()),
                 disarm ? disarm_reason_name(disarm->reason) : std::string());
}

}  // namespace torsio
