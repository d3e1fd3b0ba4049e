/// @file
/// Raspberry Pi Pico (RP2040): Cortex-M0+ without floating point, which halves the control rate.
#pragma once

#include <optional>

#include "boards/board.hpp"
#include "boards/rp2/pins.hpp"

namespace torsio::boards::pico {

/// The RP2040's USB controller is helped out of a bus reset by way of GP15 (erratum E5).
constexpr std::optional<device::PinConflict> find_pin_conflict(
    const protocol::BoardConfig& config) {
  return rp2::find_pin_conflict(config, rp2::kPicoPins | 1U << 15);
}

/// Without floating point a tick has time for one round of the simple current loop.
inline constexpr Board kBoard{"pico", 1, 100'000, find_pin_conflict, {100'000, 100'000, false}};

}  // namespace torsio::boards::pico
