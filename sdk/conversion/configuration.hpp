/// @file
/// Configurations as they travel, with the rules across their fields.
#pragma once

#include "conversion/convert.hpp"
#include "device/wiring.hpp"

namespace torsio::conversion {

/// @throws InvalidArgument that names the field, its value and its range, as all functions below
protocol::ActuatorConfig to_wire(const ActuatorConfig& config);
/// @param rule what the board finds wrong with its wiring; nullptr: not known here, the device asks
protocol::BoardConfig to_wire(const BoardConfig& config, device::WiringRule rule = nullptr);
protocol::ShaftConfig to_wire(const ShaftConfig& config);
/// One without such rules.
template <class Config>
WireType<Config>::type to_wire(const Config& config) {
  return convert(config);
}

}  // namespace torsio::conversion
