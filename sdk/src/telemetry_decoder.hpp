/// @file
/// From telemetry reports to samples in SI units.
#pragma once

#include <cstdint>
#include <optional>

#include "protocol/axis_samples.hpp"
#include "protocol/reports.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

/// Unwraps positions, scales, and counts the samples that are missing between reports.
/// Not synchronised: its owner's lock guards it.
class TelemetryDecoder {
 public:
  /// Units and rates. Positions go on from where they are.
  void configure(const protocol::Identity& identity) { identity_ = identity; }

  /// The device's position in full, from which 32-bit positions are unwrapped.
  void set_position(std::int64_t counts) { position_counts_ = counts; }

  [[nodiscard]] double time_s(std::uint64_t tick) const;
  /// Ticks from sample to sample, as the newest report has it; 0 before the first.
  [[nodiscard]] unsigned decimation() const { return decimation_; }

  /// The next report begins a stream: no gap lies before it.
  void begin_stream() { next_tick_.reset(); }

  /// Calls `take(TelemetrySample)` for each sample of a report, oldest first.
  /// @returns how many samples are missing before this report
  template <class Take>
  std::uint64_t decode(const protocol::Telemetry& report, Take&& take) {
    const std::uint64_t missing = count_missing(report);
    position_counts_ = unwrapped(report.base_counts);
    const unsigned samples = protocol::samples_of(report.axis_samples);
    for (unsigned i = 0; i < samples && i < report.sample.size(); ++i) {
      take(sample(report, i));
    }
    return missing;
  }

 private:
  std::uint64_t count_missing(const protocol::Telemetry& report);
  [[nodiscard]] std::int64_t unwrapped(std::int32_t low_bits) const;
  [[nodiscard]] TelemetrySample sample(const protocol::Telemetry& report, unsigned index) const;

  protocol::Identity identity_;
  std::int64_t position_counts_ = 0;  // of the last report's first sample
  std::optional<std::uint64_t> next_tick_;
  std::uint8_t decimation_ = 0;
};

}  // namespace torsio
