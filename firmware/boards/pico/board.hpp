/// @file
/// Raspberry Pi Pico (RP2040): Cortex-M0+ without floating point, which halves the control rate.
#pragma once

#include <optional>

#include "boards/board.hpp"
#include "boards/rp2/pins.hpp"

namespace torsio::boards::pico {

/// The RP2040's USB controller is helped out of a bus reset by way of GP15 (erratum E5).
constexpr std::optional<device::PinConflict> find_pin_conflict(const protocol::BoardConfig& config,
                                                               std::uint8_t index_pin) {
  return rp2::find_pin_conflict(config, index_pin, rp2::kPicoPins | 1U << 15);
}

/// Without floating point a tick has time for one round of the simple current loop, at a tenth of
/// the control rate. In each period it goes the share 1 - exp(-2 pi / 10) of the way. It trails by
/// 100 us (1 / share - 1 / 2).
inline constexpr Board kBoard{"pico",  1, 100'000, find_pin_conflict, {100'000, 100'000, false},
                              0.16e-3F};

}  // namespace torsio::boards::pico
