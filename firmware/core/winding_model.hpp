/// @file
/// What the motor's current should be by its winding's model, to notice a measurement that cannot
/// be true: a dead or stuck sensor, a cut wire, a missing supply, a motor that spins unseen.
#pragma once

#include <cstdint>

#include "core/math.hpp"

namespace torsio::core {

struct WindingParams {
  float settled_share = 0;  // of its way that the current goes in a period
  float a_per_v = 0;        // where the way ends: 1 / resistance
  float emf_v_s = 0;        // back EMF per rad/s of the knob
  float slack_a = 0;        // difference that is never doubted
  std::uint32_t patience_steps = 1;
  float least_a = 0;  // less says too little about the supply
  std::uint32_t patience_looks = 1;
};

struct WindingState {
  float voltage_v = 0;   // acts now
  float expected_a = 0;  // by the model
  std::uint32_t doubtful_steps = 0;
  std::uint32_t doubtful_looks = 0;
};

// Resistance and supply may each be a third off, and a warm winding has more of the one.
inline constexpr float kModelErrorShare = 0.4F;

// A winding of a third less than its resistance draws 1.43 times the current, and a supply of a
// tenth more 1.6 times; one of twice the voltage twice.
inline constexpr float kMostCurrentRatio = 1.7F;

// A winding of a third more than its resistance takes 1.3 times the voltage for its current, on a
// supply of a tenth less 1.44 times, and 70 degrees warmer 1.84 times; a supply of half the
// voltage, or a sensor that shows half the current, twice.
inline constexpr float kMostVoltageRatio = 1.85F;

// Of the voltage that the motor makes itself: constant and supply need not be what they are said.
inline constexpr float kOwnErrorShare = 0.5F;

/// The slack is half the limit: what the model cannot tell from a fault then stays below the limit.
/// @param resistance_ohm, inductance_h, period_s, torque_constant_nm_per_a all > 0
/// @param current_max_a >= 0
/// @param patience_s    longer than speed estimate and current need to settle
/// @param look_s        from one look at the supply to the next
/// @param supply_patience_s so long it must seem too much
constexpr WindingParams make_winding(float resistance_ohm, float inductance_h,
                                     float torque_constant_nm_per_a, float current_max_a,
                                     float period_s, float patience_s, float look_s,
                                     float supply_patience_s) {
  return {larger(1.0F - exp_negative(resistance_ohm * period_s / inductance_h), 1e-4F),
          1.0F / resistance_ohm,
          torque_constant_nm_per_a,
          0.5F * current_max_a,
          round_to_u32(patience_s / period_s) + 1,
          0.25F * current_max_a,
          round_to_u32(supply_patience_s / look_s) + 1};
}

/// One period of the model. The period by which the voltage comes late is short beside the
/// patience.
/// @param next_v what the bridge does from now on
constexpr void follow_winding(WindingState& state, const WindingParams& params, float speed_rad_s,
                              float next_v) {
  const float end_a = (state.voltage_v - params.emf_v_s * speed_rad_s) * params.a_per_v;
  state.expected_a =
      flush_tiny(state.expected_a + params.settled_share * (end_a - state.expected_a));
  state.voltage_v = next_v;
}

/// Once a period, a measurement beside the model.
/// @returns false once the two have differed for so long that they cannot both be true
constexpr bool believe_current(WindingState& state, const WindingParams& params, float measured_a) {
  const float most_a = larger(absolute(state.expected_a), absolute(measured_a));
  if (absolute(state.expected_a - measured_a) <= params.slack_a + kModelErrorShare * most_a) {
    state.doubtful_steps = 0;
  } else if (state.doubtful_steps < params.patience_steps) {
    ++state.doubtful_steps;
  }
  return state.doubtful_steps < params.patience_steps;
}

/// Now and then, a measurement beside the model: a supply of far more volts than the configured
/// gives far more amperes than the model has, as long as the motor makes little voltage itself; one
/// of far fewer volts far less.
/// @returns false once it has been so for long
constexpr bool believe_supply(WindingState& state, const WindingParams& params, float speed_rad_s,
                              float measured_a) {
  const float most_a = absolute(measured_a);
  const float expected_a = absolute(state.expected_a);
  const float own_a = absolute(params.emf_v_s * speed_rad_s * params.a_per_v);
  const bool too_much =
      most_a > params.least_a && own_a < 0.1F * most_a && most_a > kMostCurrentRatio * expected_a;
  const bool too_little = expected_a > params.least_a &&
                          expected_a > kMostVoltageRatio * most_a + kOwnErrorShare * own_a;
  if (!too_much && !too_little) {
    state.doubtful_looks = 0;
  } else if (state.doubtful_looks < params.patience_looks) {
    ++state.doubtful_looks;
  }
  return state.doubtful_looks < params.patience_looks;
}

}  // namespace torsio::core
