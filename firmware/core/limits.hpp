/// @file
/// The limit on how fast the motor's command may change, after all that decides it.
#pragma once

#include "core/math.hpp"

namespace torsio::core {

struct LimitParams {
  float motor_step_nm_per_tick = 0;  // largest change in a tick; 0 is no limit
};

struct LimitState {
  float motor_command_nm = 0;  // the last that was let through
};

/// Holds the motor's torque within its rate.
constexpr float limit_motor(LimitState& state, const LimitParams& params, float motor_nm) {
  float allowed_nm = motor_nm;
  if (params.motor_step_nm_per_tick > 0.0F) {
    allowed_nm = state.motor_command_nm + clamp_symmetric(allowed_nm - state.motor_command_nm,
                                                          params.motor_step_nm_per_tick);
  }
  state.motor_command_nm = allowed_nm;
  return allowed_nm;
}

}  // namespace torsio::core
