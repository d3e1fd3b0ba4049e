/// @file
/// Gathers samples into reports.
#pragma once

#include <cstdint>

#include "device/control_loop.hpp"
#include "protocol/reports.hpp"

namespace torsio::device {

/// Units of the samples' integers.
struct SampleSteps {
  float torque_nm = 1e-5F;
  float speed_rad_s = 0.01F;
};

class TelemetryBatch {
 public:
  /// Adds a sample unless it cannot stand behind the ones already there: then the report must be
  /// sent first.
  /// @returns false if the sample was not taken
  [[nodiscard]] bool add(const LoopSample& sample, const SampleSteps& steps);

  /// Prompt: samples are due at once. If they exceed a report, the older ones are dropped.
  void set_prompt(bool prompt) { prompt_ = prompt; }
  bool prompt() const { return prompt_; }

  /// True when the report should go: it is full, or waiting would make it older than 10 ms.
  bool due(std::uint32_t period_ns) const;
  bool empty() const { return count_ == 0; }

  /// Content of the report that is gathered, or of the last one. Before that one sample of zeros.
  protocol::Telemetry last() const;

  /// The report; the batch is empty afterwards.
  protocol::Telemetry take();

 private:
  protocol::Telemetry report_;
  std::uint8_t count_ = 0;
  bool prompt_ = false;
  std::int64_t base_counts_ = 0;
};

}  // namespace torsio::device
