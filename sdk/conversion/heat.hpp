/// @file
/// A motor's torque for ever, as the device has it.
#pragma once

#include "core/heat_model.hpp"
#include "protocol/configuration.hpp"

namespace torsio::conversion {

inline float motor_continuous_a(const protocol::BoardConfig& board) {
  return core::continuous_in_air(board.motor_current_continuous_a, board.ambient_c);
}

}  // namespace torsio::conversion
