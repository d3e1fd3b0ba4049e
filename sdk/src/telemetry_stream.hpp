/// @file
/// Starting, stopping and recording telemetry: who wants it, and at which rate.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>

#include "sample_feed.hpp"
#include "torsio/knob.hpp"

namespace torsio {

/// May be used from any thread.
class TelemetryStream {
 public:
  TelemetryStream(DeviceState& device, Requests& requests, SampleFeed& samples,
                  std::int64_t command_timeout_ns)
      : device_(device),
        requests_(requests),
        samples_(samples),
        command_timeout_ns_(command_timeout_ns) {}

  void set_control_period(std::uint32_t period_ns) { period_ns_ = period_ns; }

  /// As Knob's members of these names.
  double start(std::optional<double> rate_hz, bool prompt);
  void stop();
  TelemetrySample latest();
  void record(TelemetryRecord& into, std::int64_t duration_ns, std::optional<double> rate_hz,
              bool must_stay_armed);

 private:
  class Use;
  [[nodiscard]] double control_rate_hz() const { return 1e9 / period_ns_; }
  [[nodiscard]] unsigned ticks_per_sample(std::optional<double> rate_hz, bool prompt) const;
  void begin(unsigned decimation, bool prompt);
  void throw_unless_armed() const;
  void check_length(std::int64_t duration_ns, unsigned decimation) const;

  DeviceState& device_;
  Requests& requests_;
  SampleFeed& samples_;
  const std::int64_t command_timeout_ns_;
  std::atomic<std::uint32_t> period_ns_{1'000'000};

  std::mutex mutex_;     // guards `wanted_`, and the order of the sent reports
  bool wanted_ = false;  // by the user, not only by recordings
  int recordings_ = 0;
  std::atomic<unsigned> decimation_{0};  // 0: off
};

}  // namespace torsio
