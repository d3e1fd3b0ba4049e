/// @file
/// The board that docs/how-to/hardware.md builds and that the emulated device stands in for.
#pragma once

#include "boards/pico2/board.hpp"

namespace torsio::boards {

inline constexpr const Board& kReference = pico2::kBoard;

}  // namespace torsio::boards
