/// @file
/// The motor's current, held by the voltage of its bridge. Runs once a tick, behind the control
/// law: torque is current times a constant, whatever the winding's resistance and the motor's
/// speed.
#pragma once

#include "core/math.hpp"

namespace torsio::core {

struct CurrentLoopParams {
  float proportional_v_per_a = 0;
  float integral_share = 0;  // 1 - the winding's pole
  float supply_v = 1;        // > 0
  float share_per_v = 1;     // 1 / supply_v
};

struct CurrentLoopState {
  float integral_v = 0;
};

/// A PI controller whose zero cancels the winding's pole exp(-resistance period / inductance). What
/// is left is an integrator: the current then approaches its target with the given bandwidth, which
/// is held at a tenth of the control rate, because the voltage acts one period after the current
/// was measured.
/// @param resistance_ohm, inductance_h, bandwidth_hz, period_s, supply_v all > 0
constexpr CurrentLoopParams make_current_loop(float resistance_ohm, float inductance_h,
                                              float bandwidth_hz, float period_s, float supply_v) {
  const float bandwidth_rad = kTwoPi * smaller(bandwidth_hz * period_s, 0.1F);
  const float approach = 1.0F - exp_negative(bandwidth_rad);
  // Share of its way that the current goes in a period under a constant voltage. A winding faster
  // than the period counts as a resistor, one far slower still needs a number above zero.
  const float settled =
      larger(1.0F - exp_negative(resistance_ohm * period_s / inductance_h), 1e-4F);
  return {approach * resistance_ohm / settled, settled, supply_v, 1.0F / supply_v};
}

/// One tick. The integral follows the voltage as the current does: integral_share of the way. It
/// then is what the resistance takes, also while the supply cannot give what is wanted, so that
/// nothing winds up.
/// @returns voltage as a share of the supply, within [-1, 1]
constexpr float hold_current(CurrentLoopState& state, const CurrentLoopParams& params,
                             float target_a, float measured_a) {
  const float wanted_v = state.integral_v + params.proportional_v_per_a * (target_a - measured_a);
  const float voltage_v = clamp_symmetric(wanted_v, params.supply_v);
  state.integral_v =
      flush_tiny(state.integral_v + params.integral_share * (voltage_v - state.integral_v));
  return voltage_v * params.share_per_v;
}

}  // namespace torsio::core
