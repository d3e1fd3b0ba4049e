/// @file
/// Axis and number of filled samples share a byte of telemetry, or four samples would not fit.
#pragma once

#include <cstdint>

namespace torsio::protocol {

constexpr std::uint8_t pack_axis_samples(unsigned axis, unsigned samples) {
  return static_cast<std::uint8_t>((axis & 0x0FU) | (samples << 4U));
}
constexpr std::uint8_t axis_of(std::uint8_t axis_samples) { return axis_samples & 0x0FU; }
constexpr std::uint8_t samples_of(std::uint8_t axis_samples) { return axis_samples >> 4U; }

}  // namespace torsio::protocol
