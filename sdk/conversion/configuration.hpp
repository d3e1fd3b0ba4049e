/// @file
/// Configurations as they travel, with the rules across their fields.
#pragma once

#include "conversion/convert.hpp"
#include "device/wiring.hpp"

namespace torsio::conversion {

/// @throws InvalidArgument that names the field, its value and its range, as all functions below
protocol::ActuatorConfig to_wire(const ActuatorConfig& config);
protocol::ControlConfig to_wire(const ControlConfig& config);
/// @param rule what the board finds wrong with its wiring; nullptr: not known here, the device asks
protocol::BoardConfig to_wire(const BoardConfig& config, device::WiringRule rule = nullptr);
protocol::GameConfig to_wire(const GameConfig& config);
protocol::ShaftConfig to_wire(const ShaftConfig& config);
protocol::CalibrationConfig to_wire(const CalibrationConfig& config);

}  // namespace torsio::conversion
