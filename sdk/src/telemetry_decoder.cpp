#include "telemetry_decoder.hpp"

#include "conversion/reading.hpp"

namespace torsio {

double TelemetryDecoder::time_s(std::uint64_t tick) const {
  return conversion::time_s(tick, identity_);
}

std::uint64_t TelemetryDecoder::count_missing(const protocol::Telemetry& report) {
  std::uint64_t missing = 0;
  if (next_tick_ && report.decimation == decimation_ && report.tick > *next_tick_) {
    missing = (report.tick - *next_tick_) / decimation_;
  }
  // A decimation of 0 would be a damaged report; it must not divide.
  decimation_ = report.decimation == 0 ? std::uint8_t{1} : report.decimation;
  next_tick_ = report.tick + std::uint64_t{decimation_} * protocol::samples_of(report.axis_samples);
  return missing;
}

std::int64_t TelemetryDecoder::unwrapped(std::int32_t low_bits) const {
  const auto known = static_cast<std::uint32_t>(position_counts_);
  const std::uint32_t moved = static_cast<std::uint32_t>(low_bits) - known;
  return position_counts_ + static_cast<std::int32_t>(moved);
}

TelemetrySample TelemetryDecoder::sample(const protocol::Telemetry& report, unsigned index) const {
  const protocol::Sample& in = report.sample[index];
  auto out = conversion::read<TelemetrySample>(in, identity_);
  out.tick = report.tick + std::uint64_t{index} * report.decimation;
  out.time_s = time_s(out.tick);
  out.position_counts = position_counts_ + in.offset_counts;
  out.angle_rad = conversion::angle_rad(out.position_counts, identity_);
  out.flags = report.flags;
  return out;
}

}  // namespace torsio
