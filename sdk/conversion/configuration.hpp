/// @file
/// Configurations as they travel, with the rules across their fields.
#pragma once

#include "conversion/convert.hpp"

namespace torsio::conversion {

/// @throws InvalidArgument that names the field, its value and its range; likewise below
protocol::ActuatorConfig to_wire(const ActuatorConfig& config);
protocol::ControlConfig to_wire(const ControlConfig& config);
protocol::BoardConfig to_wire(const BoardConfig& config,
                              protocol::Board board = protocol::Board::emulated);
protocol::GameConfig to_wire(const GameConfig& config);

}  // namespace torsio::conversion
