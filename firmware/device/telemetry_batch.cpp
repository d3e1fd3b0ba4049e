#include "device/telemetry_batch.hpp"

#include "protocol/axis_samples.hpp"

namespace torsio::device {
namespace {

constexpr std::uint64_t kOldestNs = 10'000'000;

/// value / step as a 16-bit integer; holds at the ends, so that a torque beyond the range still
/// shows as large.
std::int16_t quantise(float value, float step) {
  const float scaled = value / step;
  if (scaled >= 32767.0F) return 32767;
  if (scaled <= -32767.0F) return -32767;
  return static_cast<std::int16_t>(scaled + (scaled < 0.0F ? -0.5F : 0.5F));
}

}  // namespace

bool TelemetryBatch::add(const LoopSample& sample, const SampleSteps& steps) {
  if (count_ == 0) {
    report_ = {};
    report_.tick = sample.tick;
    report_.decimation = sample.decimation;
    report_.base_counts = static_cast<std::int32_t>(sample.position_counts);
    base_counts_ = sample.position_counts;
  }
  const std::int64_t offset = sample.position_counts - base_counts_;
  const bool follows =
      sample.decimation == report_.decimation &&
      sample.tick == report_.tick + static_cast<std::uint64_t>(count_) * report_.decimation;
  const bool fits = offset >= -32768 && offset <= 32767;
  if (count_ == protocol::samples_per_report || !follows || !fits) return false;

  protocol::Sample& out = report_.sample[count_++];
  out.offset_counts = static_cast<std::int16_t>(offset);
  out.speed = quantise(sample.speed_rad_s, steps.speed_rad_s);
  out.desired_torque = quantise(sample.desired_torque_nm, steps.torque_nm);
  out.motor_command = quantise(sample.motor_command_nm, steps.torque_nm);
  out.brake_capacity = quantise(sample.brake_capacity_nm, steps.torque_nm);
  out.spring_torque = quantise(sample.spring_torque_nm, steps.torque_nm);
  // The state is the newest sample's; the other bits are any sample's.
  const auto older = static_cast<std::uint8_t>(report_.flags & ~protocol::flag::state_mask);
  report_.flags = static_cast<std::uint8_t>(older | sample.flags);
  return true;
}

bool TelemetryBatch::due(std::uint32_t period_ns) const {
  if (count_ == 0) return false;
  const std::uint64_t next_ns =
      (static_cast<std::uint64_t>(count_) + 1) * report_.decimation * period_ns;
  return prompt_ || count_ == protocol::samples_per_report || next_ns > kOldestNs;
}

protocol::Telemetry TelemetryBatch::last() const {
  protocol::Telemetry report = report_;
  if (count_ != 0) report.axis_samples = protocol::pack_axis_samples(0, count_);
  return report;
}

protocol::Telemetry TelemetryBatch::take() {
  report_.axis_samples = protocol::pack_axis_samples(0, count_);
  count_ = 0;
  return report_;
}

}  // namespace torsio::device
