/// @file
/// The boards that this version of the library knows.
#pragma once

#include <string>

#include "device/wiring.hpp"
#include "protocol/reports.hpp"

namespace torsio {

/// "pico2", "emulated"; "board 7" for one that is newer than this library.
std::string board_name(protocol::Board board);

/// What the board finds wrong with its wiring; nullptr if it is newer than this library.
device::WiringRule wiring_rule(protocol::Board board);

}  // namespace torsio
