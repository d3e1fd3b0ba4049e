/// @file
/// Raspberry Pi Pico 2 (RP2350): Cortex-M33 with single precision floating point.
#pragma once

#include <optional>

#include "boards/board.hpp"
#include "boards/rp2/pins.hpp"

namespace torsio::boards::pico2 {

constexpr std::optional<device::PinConflict> find_pin_conflict(const protocol::BoardConfig& config,
                                                               std::uint8_t index_pin) {
  return rp2::find_pin_conflict(config, index_pin, rp2::kPicoPins);
}

/// The current loop runs at the PWM's rate, twice a tick.
inline constexpr Board kBoard{"pico2", 2, 50'000, find_pin_conflict, {25'000, 25'000, true}};

}  // namespace torsio::boards::pico2
