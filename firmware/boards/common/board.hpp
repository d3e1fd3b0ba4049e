/// @file
/// The board that is compiled for, and what both have in common.
#pragma once

#include <cstdint>

#if PICO_RP2350
#include "boards/pico2/board.hpp"
#else
#include "boards/pico/board.hpp"
#endif

namespace torsio::boards {

/// Above hearing, and a whole multiple of either control rate.
inline constexpr std::uint32_t kPwmHz = 40'000;

/// Without a tick or a round of the main loop for so long, the chip starts anew: outputs off.
inline constexpr std::uint32_t kWatchdogMs = 50;

}  // namespace torsio::boards
