/// @file
/// The boards that this version of the library knows.
#pragma once

#include <cstdint>
#include <string>

#include "device/wiring.hpp"

namespace torsio {

/// "pico2", "emulated"; "board 7" for one that is newer than this library.
std::string board_name(std::uint8_t number);

/// False for the emulated one, which nobody can be hurt by.
bool moves_parts(std::uint8_t number);

/// The board's objection to its wiring; nullptr if it is newer than this library.
device::WiringRule wiring_rule(std::uint8_t number);

}  // namespace torsio
