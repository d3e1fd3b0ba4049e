/// @file
/// A device's limits by its configuration, as its firmware has them too.
#pragma once

#include "protocol/configuration.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

/// @param real whether the board has a real motor: currents limit it, and it is held low until its
/// parts are confirmed and known
Limits limits_of(const protocol::ActuatorConfig& actuator, const protocol::ControlConfig& control,
                 const protocol::BoardConfig& board, const protocol::CalibrationConfig& calibration,
                 bool real);

}  // namespace torsio
