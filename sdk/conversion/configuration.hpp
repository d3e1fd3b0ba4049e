/// @file
/// Configurations as they travel, with the rules across their fields.
#pragma once

#include "conversion/convert.hpp"
#include "device/wiring.hpp"

namespace torsio::conversion {

/// @throws InvalidArgument that names the field, its value and its range, as all functions below
/// @param rule  what the board finds wrong with its wiring; nullptr: the device alone knows
/// @param board whose pins the encoder's index must leave alone
protocol::ActuatorConfig to_wire(const ActuatorConfig& config, device::WiringRule rule,
                                 const protocol::BoardConfig& board);
/// @param rule      as above
/// @param index_pin of the actuator's encoder
protocol::BoardConfig to_wire(const BoardConfig& config, device::WiringRule rule = nullptr,
                              std::uint8_t index_pin = 0);
/// One without such rules.
template <class Config>
WireType<Config>::type to_wire(const Config& config) {
  return convert(config);
}

}  // namespace torsio::conversion
