/// @file
/// Raspberry Pi Pico (RP2040): Cortex-M0+ without floating point, which halves the control rate.
#pragma once

#include <cstdint>

#include "protocol/reports.hpp"

namespace torsio::boards {

inline constexpr protocol::Board kBoard = protocol::Board::pico;
inline constexpr std::uint32_t kControlPeriodNs = 100'000;

}  // namespace torsio::boards
