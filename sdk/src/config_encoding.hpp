/// @file
/// Configuration between the user's structures and the protocol's.
#pragma once

#include "device/wiring.hpp"
#include "protocol/reports.hpp"
#include "torsio/config.hpp"

namespace torsio {

/// @throws InvalidArgument that names the field, its value and its range
protocol::ActuatorConfig to_wire(const ActuatorConfig& config);
protocol::ControlConfig to_wire(const ControlConfig& config);
/// @param rule what the board finds wrong with its wiring; nullptr: not known here, the device asks
protocol::BoardConfig to_wire(const BoardConfig& config, device::WiringRule rule = nullptr);
protocol::GameConfig to_wire(const GameConfig& config);

ActuatorConfig from_wire(const protocol::ActuatorConfig& config);
ControlConfig from_wire(const protocol::ControlConfig& config);
BoardConfig from_wire(const protocol::BoardConfig& config);
GameConfig from_wire(const protocol::GameConfig& config);

}  // namespace torsio
