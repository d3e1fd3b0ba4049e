/// @file
/// Raspberry Pi Pico 2 (RP2350): Cortex-M33 with single precision floating point.
#pragma once

#include <cstdint>

#include "protocol/reports.hpp"

namespace torsio::boards {

inline constexpr protocol::Board kBoard = protocol::Board::pico2;
inline constexpr std::uint32_t kControlPeriodNs = 50'000;

}  // namespace torsio::boards
