/// @file
/// Capacity of the magnetic particle brake, from its commands.
#pragma once

#include "core/math.hpp"

namespace torsio::core {

struct BrakeParams {
  float decay = 0;     // exp(-period / time constant)
  float floor_nm = 0;  // lets the sensed torque change when the brake is off, drag included
  float drag_nm = 0;   // counted on top, if the law wants it
  // Used by model_real_brake() only:
  float release_decay = 0;  // as `decay`, where the command is below what the coil gives
  float play_nm = 0;        // half the width of the hysteresis
};

struct BrakeState {
  float capacity_nm = 0;  // after the lag, drag not included
  float coil_nm = 0;      // the same before the hysteresis; of model_real_brake() only
};

/// Share of a lag's difference that is left after a period.
/// @param time_constant_s >= 0; 0 is no lag
constexpr float decay_of(float time_constant_s, float period_s) {
  return time_constant_s > 0.0F ? exp_negative(period_s / time_constant_s) : 0.0F;
}

/// @param time_constant_s >= 0; 0 is a brake without delay
constexpr BrakeParams make_brake_params(float time_constant_s, float period_s, float floor_nm,
                                        float drag_nm) {
  const float decay = decay_of(time_constant_s, period_s);
  return {decay, floor_nm, drag_nm, decay, 0.0F};
}

/// Bound of the sensor: the brake's capacity with drag, not below the floor.
constexpr float sensed_capacity(const BrakeState& state, const BrakeParams& params) {
  return larger(state.capacity_nm + params.drag_nm, params.floor_nm);
}

/// One tick of the first order lag, exact for a command that was held over the tick, so that it is
/// stable for any time constant.
/// @returns sensed_capacity()
constexpr float model_brake(BrakeState& state, const BrakeParams& params, float held_command_nm) {
  state.capacity_nm =
      flush_tiny_number(held_command_nm + (state.capacity_nm - held_command_nm) * params.decay);
  return sensed_capacity(state, params);
}

/// The same for a brake with hysteresis and with different lags up and down. The coil's current has
/// the lag, and a play follows it. Without either it is model_brake() to the bit.
constexpr float model_real_brake(BrakeState& state, const BrakeParams& params,
                                 float held_command_nm) {
  const float decay = held_command_nm < state.coil_nm ? params.release_decay : params.decay;
  const float coil_nm = held_command_nm + (state.coil_nm - held_command_nm) * decay;
  state.coil_nm = coil_nm >= kTiny ? coil_nm : 0.0F;  // flushed; it is never negative
  state.capacity_nm = larger(smaller_number(state.capacity_nm, state.coil_nm + params.play_nm),
                             state.coil_nm - params.play_nm);
  return sensed_capacity(state, params);
}

}  // namespace torsio::core
