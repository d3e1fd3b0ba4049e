/// @file
/// The limit on how fast the motor's command may change, after all that decides it; and torques
/// that end slowly.
#pragma once

#include <cstdint>

#include "core/math.hpp"

namespace torsio::core {

struct SlewParams {
  float motor_step_nm_per_tick = 0;  // largest change in a tick; 0 is no limit
};

struct SlewState {
  float motor_command_nm = 0;  // the last that was let through
};

/// Allowed commands of the motor in a tick.
struct MotorRange {
  float low_nm = 0;
  float high_nm = 0;
};

/// The same rate, for who has to know beforehand what it lets through.
/// @param most_nm that the motor gives, either way
constexpr MotorRange motor_range(const SlewState& state, const SlewParams& params, float most_nm) {
  const float step_nm = params.motor_step_nm_per_tick;
  if (step_nm <= 0.0F) return {-most_nm, most_nm};
  return {larger(-most_nm, state.motor_command_nm - step_nm),
          smaller(most_nm, state.motor_command_nm + step_nm)};
}

/// Holds the motor's torque within its rate.
constexpr float limit_motor(SlewState& state, const SlewParams& params, float motor_nm) {
  float allowed_nm = motor_nm;
  if (params.motor_step_nm_per_tick > 0.0F) {
    allowed_nm = state.motor_command_nm + clamp_symmetric(allowed_nm - state.motor_command_nm,
                                                          params.motor_step_nm_per_tick);
  }
  state.motor_command_nm = allowed_nm;
  return allowed_nm;
}

/// A torque that goes to zero along a straight line.
struct Fade {
  float nm = 0;
  float step_nm = 0;

  /// @param ticks 0: the first step ends it
  constexpr void begin(float from_nm, std::uint32_t ticks) {
    nm = from_nm;
    step_nm = absolute(from_nm);
    if (ticks != 0) step_nm /= static_cast<float>(ticks);
  }
  constexpr void step() { nm -= clamp_symmetric(nm, step_nm); }
};

}  // namespace torsio::core
