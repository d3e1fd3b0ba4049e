/// @file
/// The motor's current, held by the voltage of its bridge, behind the control law: torque is
/// current times a constant, whatever the winding's resistance and the motor's speed. Two loops:
/// one that costs little, and one that knows when its voltage acts and is several times faster.
#pragma once

#include <cstdint>

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

/// A PI controller whose zero cancels the winding's pole exp(-resistance period / inductance). The
/// rest is an integrator: the current then approaches its target with the given bandwidth. The
/// bandwidth is at most a tenth of the control rate, because the voltage acts one period after the
/// measurement.
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

/// One tick. The integral follows the voltage as the current does: integral_share of the way. It is
/// then the resistance's voltage, also while the supply cannot give the target. So nothing winds
/// up.
/// @returns voltage as a share of the supply, within [-1, 1]
constexpr float hold_current(CurrentLoopState& state, const CurrentLoopParams& params,
                             float target_a, float measured_a) {
  const float wanted_v = state.integral_v + params.proportional_v_per_a * (target_a - measured_a);
  const float voltage_v = clamp_symmetric(wanted_v, params.supply_v);
  state.integral_v =
      flush_tiny(state.integral_v + params.integral_share * (voltage_v - state.integral_v));
  return voltage_v * params.share_per_v;
}

/// For a loop whose voltage acts for a period, a known delay after the current is measured.
struct PredictiveParams {
  float delay_decay = 0;    // of the current over the delay, without voltage
  float delay_a_per_v = 0;  // the current that a volt adds over the delay
  float rest_decay = 1;     // the same from then to the next measurement
  float rest_a_per_v = 0;
  float resistance_ohm = 0;
  float push_v_per_a = 0;    // for what is missing
  float learn_v_per_a = 0;   // for what was not expected
  float believed_share = 1;  // of that, for the current
  float supply_v = 1;        // > 0
  float share_per_v = 1;     // 1 / supply_v
};

struct PredictiveState {
  float voltage_v = 0;   // acts now
  float expected_a = 0;  // at the next measurement
  float opposing_v = 0;  // back EMF, and what resistance and supply are not taken for
};

/// With the bandwidth w the current, once the voltage acts, makes 1 - exp(-w period) of its way in
/// each period. What was not expected may be noise of the sensor. So it corrects the model's
/// current and opposing voltage in part: both poles of the model's error are at 0.8. The model's
/// current of a winding that forgets a current sooner is not corrected, and one pole is then at up
/// to 0.9. That is enough for the back EMF of the hardest stop, and little enough for a winding
/// whose resistance and inductance are each a third off.
/// @param delay_s from a measurement to the voltage that answers it, > 0, at most period_s
/// @param resistance_ohm, inductance_h, bandwidth_hz, period_s, supply_v all > 0
constexpr PredictiveParams make_predictive_loop(float resistance_ohm, float inductance_h,
                                                float bandwidth_hz, float period_s, float delay_s,
                                                float supply_v) {
  constexpr float kLeft = 0.8F;
  const float rate = resistance_ohm / inductance_h;
  // A winding far slower than the period still needs a number above zero.
  const auto settled = [&](float time_s) {
    return larger(1.0F - exp_negative(rate * time_s), 1e-4F);
  };
  const float rest_s = period_s - delay_s;
  const float rest = rest_s > 0.0F ? settled(rest_s) : 0.0F;
  const float gone = settled(period_s);
  const float volts_per_a = resistance_ohm / gone;
  return {1.0F - settled(delay_s),
          settled(delay_s) / resistance_ohm,
          1.0F - rest,
          rest / resistance_ohm,
          resistance_ohm,
          (1.0F - exp_negative(kTwoPi * bandwidth_hz * period_s)) * volts_per_a,
          larger((1.0F - kLeft) * (1.0F - kLeft), 0.11F * gone) * volts_per_a,
          1.0F - kLeft * kLeft / larger(1.0F - gone, kLeft * kLeft),
          supply_v,
          1.0F / supply_v};
}

/// One period. The model computes the current at the moment when the new voltage acts, and sends it
/// from there to its target.
/// @returns voltage as a share of the supply, within [-1, 1]
constexpr float hold_current(PredictiveState& state, const PredictiveParams& params, float target_a,
                             float measured_a) {
  const float unexpected_a = measured_a - state.expected_a;
  const float now_a = state.expected_a + params.believed_share * unexpected_a;
  const float opposing_v =
      clamp_symmetric(state.opposing_v - params.learn_v_per_a * unexpected_a, params.supply_v);
  const float begin_a =
      params.delay_decay * now_a + params.delay_a_per_v * (state.voltage_v - opposing_v);
  const float wanted_v =
      opposing_v + params.resistance_ohm * begin_a + params.push_v_per_a * (target_a - begin_a);
  const float voltage_v = clamp_symmetric(wanted_v, params.supply_v);
  state.expected_a = params.rest_decay * begin_a + params.rest_a_per_v * (voltage_v - opposing_v);
  state.opposing_v = flush_tiny(opposing_v);
  state.voltage_v = voltage_v;
  return voltage_v * params.share_per_v;
}

// After so many of its own time constants the coil's current equals the model's. A supply that sags
// when driven hard makes them differ for a while.
inline constexpr float kRestTimes = 2.0F;

/// For a coil whose current is not measured: a model of the coil gives it.
struct CoilParams {
  float decay = 0;                 // of its current in a period, without voltage
  float a_per_v = 0;               // the current that a volt adds in a period
  float v_per_a = 0;               // 1 / a_per_v
  float follow_decay = 0;          // share of the missing current that remains after a period
  float supply_v = 1;              // > 0
  float share_per_v = 1;           // 1 / supply_v
  float erase_a = 0;               // sent backwards once it is told to let go; 0: never
  std::uint32_t rest_periods = 0;  // before that
};

struct CoilState {
  float current_a = 0;
  bool magnetised = false;  // more than erase_a has flowed, and was not erased
  std::uint32_t rested_periods = 0;
};

/// The share of the missing current that remains after a period.
/// @param lag_s with which the current shall follow, >= 0; below inductance / resistance it follows
/// faster than by itself, as far as the supply goes
constexpr float coil_follow_decay(float lag_s, float period_s) {
  return lag_s > 0.0F ? exp_negative(period_s / lag_s) : 0.0F;
}

/// @param lag_s   see coil_follow_decay()
/// @param erase_a current sent backwards in the end. A brake whose play has this half width keeps
/// no torque; others keep no more than without it
/// @param resistance_ohm, inductance_h, period_s, supply_v all > 0
constexpr CoilParams make_coil(float resistance_ohm, float inductance_h, float lag_s,
                               float period_s, float supply_v, float erase_a = 0.0F) {
  const float settled =
      larger(1.0F - exp_negative(resistance_ohm * period_s / inductance_h), 1e-6F);
  return {1.0F - settled,
          settled / resistance_ohm,
          resistance_ohm / settled,
          coil_follow_decay(lag_s, period_s),
          supply_v,
          1.0F / supply_v,
          erase_a,
          round_to_u32(kRestTimes * inductance_h / resistance_ohm / period_s)};
}

/// One period. The voltage may be the whole supply against the current. It never drives the current
/// past the target, so the coil is not magnetised the other way. After a while without a target and
/// nearly without current, a little flows backwards for a moment. That removes the iron's
/// remanence.
/// @param target_a >= 0
/// @returns voltage as a share of the supply, within [-1, 1]
constexpr float drive_coil(CoilState& state, const CoilParams& params, float target_a) {
  float next_a = target_a + (state.current_a - target_a) * params.follow_decay;
  if (target_a > 0.0F) {
    state.magnetised = state.magnetised || state.current_a > params.erase_a;
    state.rested_periods = 0;
  } else if (state.magnetised && state.current_a <= params.erase_a) {
    if (state.rested_periods >= params.rest_periods) next_a = -params.erase_a;
    ++state.rested_periods;
  } else if (state.current_a < 0.0F) {
    next_a = 0.0F;
  }
  const float voltage_v =
      clamp_symmetric((next_a - params.decay * state.current_a) * params.v_per_a, params.supply_v);
  state.current_a = flush_tiny(params.decay * state.current_a + params.a_per_v * voltage_v);
  if (state.current_a <= -0.99F * params.erase_a) state.magnetised = false;
  return voltage_v * params.share_per_v;
}

/// One period in which the bridge lets go: the current runs back into the supply, until it ends.
constexpr void release_coil(CoilState& state, const CoilParams& params) {
  state.current_a = larger(params.decay * state.current_a - params.a_per_v * params.supply_v, 0.0F);
  state.magnetised = state.magnetised && state.current_a > 0.0F;
}

}  // namespace torsio::core
