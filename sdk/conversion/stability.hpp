/// @file
/// How stiff a wall can be, from a device's configuration.
#pragma once

#include <cstdint>

#include "protocol/configuration.hpp"
#include "torsio/telemetry.hpp"

namespace torsio::conversion {

StableStiffness stable_stiffness(const protocol::ActuatorConfig& actuator,
                                 const protocol::ControlConfig& control,
                                 std::uint32_t control_period_ns);

}  // namespace torsio::conversion
