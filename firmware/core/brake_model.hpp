/// @file
/// What the magnetic particle brake can hold, from what it was told.
#pragma once

#include "core/math.hpp"

namespace torsio::core {

struct BrakeParams {
  float decay = 0;           // exp(-period / time constant)
  float floor_nm = 3.3e-3F;  // lets the sensed torque change when the brake is off, drag included
  float drag_nm = 0;         // counted on top, if the law wants it
};

struct BrakeState {
  float capacity_nm = 0;  // after the lag, drag not included
};

/// @param time_constant_s >= 0; 0 is a brake without delay
constexpr BrakeParams make_brake_params(float time_constant_s, float period_s, float floor_nm,
                                        float drag_nm) {
  const float decay = time_constant_s > 0.0F ? exp_negative(period_s / time_constant_s) : 0.0F;
  return {decay, floor_nm, drag_nm};
}

/// One tick of the first order lag, exact for a command that was held over the tick, so that it is
/// stable for any time constant.
/// @returns the capacity for the sensor: the lagged one plus the drag, not below the floor
constexpr float model_brake(BrakeState& state, const BrakeParams& params, float held_command_nm) {
  state.capacity_nm =
      flush_tiny(held_command_nm + (state.capacity_nm - held_command_nm) * params.decay);
  return larger(state.capacity_nm + params.drag_nm, params.floor_nm);
}

}  // namespace torsio::core
