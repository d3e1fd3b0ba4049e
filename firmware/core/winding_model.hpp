/// @file
/// The motor's current by its winding's model, to notice impossible measurements: a sensor that is
/// dead, stuck or moved from its zero, a cut wire, another supply, an unseen spin.
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
  float mean_share = 0;       // 1 / comparisons from one look at the means to the next
  float mean_slack_a = 0;     // the same of the means
  float mean_patience_a = 0;  // the most that lasts, summed over the looks
  float own_decay = 0;        // of the motor's own voltage, from one look to the next
  float steady_share = 0;     // of their way that the steady values go in a look
};

struct WindingState {
  float voltage_v = 0;   // acts now
  float expected_a = 0;  // by the model
  std::uint32_t doubtful_steps = 0;
  // Sums of all comparisons since the last look.
  float difference_sum_a = 0;
  float measured_sum_a = 0;
  // The last look's means.
  float difference_a = 0;
  float measured_a = 0;
  float never_doubted_a = 0;  // at the speeds of late and with so much current
  float own_a = 0;            // that the motor's own voltage made of late
  // By how much the model has been too high and too low, less what is never doubted.
  float above_a = 0;
  float below_a = 0;
  // The same sums for recent changes only.
  float steady_difference_a = 0;
  float steady_measured_a = 0;
  float steady_own_a = 0;
  float rise_a = 0;
  float fall_a = 0;
};

// Resistance and supply may each be a third off, and a warm winding has more of the one.
inline constexpr float kModelErrorShare = 0.4F;

// A winding with a third less resistance draws 1.43 times the current; with a supply a tenth too
// high it draws 1.6 times. The model then lacks 0.37 of the real current. Half of it is missing
// with a supply of twice the voltage.
inline constexpr float kMostTooLow = 0.41F;

// A winding of a third more than its resistance takes 1.3 times the voltage for its current. On a
// supply of a tenth less it takes 1.44 times, and 70 degrees warmer 1.84 times. A supply of half
// the voltage, or a sensor that shows half the current, takes twice.
inline constexpr float kMostTooHigh = 0.85F;

// Current beyond the model, beside the slack of the means: a bridge's own loss makes it less. So
// much also resistance and supply may change within a second.
inline constexpr float kQuickShare = 0.2F;

// Limit for the motor's own voltage: a constant a tenth larger on a supply a sixth weaker seems
// 1.32 times as much.
inline constexpr float kOwnErrorShare = 0.35F;

// The speed estimate is late by some milliseconds: so long it is remembered how fast it was.
inline constexpr float kOwnMemoryS = 10e-3F;

// So long no winding gets warm, and no supply weak.
inline constexpr float kSteadyS = 0.5F;

/// The slack is half the limit. For the means it is a twentieth or a fiftieth of the supply's
/// voltage, which a bridge's dead time takes.
/// @param resistance_ohm, inductance_h, period_s, torque_constant_nm_per_a, supply_v all > 0
/// @param current_max_a >= 0
/// @param patience_s    longer than speed estimate and current need to settle
/// @param look_s        from one look at the means to the next
constexpr WindingParams make_winding(float resistance_ohm, float inductance_h,
                                     float torque_constant_nm_per_a, float current_max_a,
                                     float supply_v, float period_s, float patience_s,
                                     float look_s) {
  return {larger(1.0F - exp_negative(resistance_ohm * period_s / inductance_h), 1e-4F),
          1.0F / resistance_ohm,
          torque_constant_nm_per_a,
          0.5F * current_max_a,
          round_to_u32(patience_s / period_s) + 1,
          period_s / look_s,
          larger(0.05F * current_max_a, 0.02F * supply_v / resistance_ohm),
          patience_s * current_max_a / look_s,
          exp_negative(look_s / kOwnMemoryS),
          look_s / kSteadyS};
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
  const float difference_a = state.expected_a - measured_a;
  state.difference_sum_a += difference_a;
  state.measured_sum_a += measured_a;
  if (absolute(difference_a) <= params.slack_a + kModelErrorShare * most_a) {
    state.doubtful_steps = 0;
  } else if (state.doubtful_steps < params.patience_steps) {
    ++state.doubtful_steps;
  }
  return state.doubtful_steps < params.patience_steps;
}

/// Now and then, the means since the last time: what lasts is told once it has added up, the sooner
/// the more it is. Another supply voltage, or a sensor with another gain, makes a difference that
/// is a share of the current. A moved zero makes the same difference at any current and any speed.
/// @returns false once they cannot be true
constexpr bool believe_means(WindingState& state, const WindingParams& params, float speed_rad_s) {
  state.difference_a = state.difference_sum_a * params.mean_share;
  state.measured_a = state.measured_sum_a * params.mean_share;
  state.difference_sum_a = 0.0F;
  state.measured_sum_a = 0.0F;
  state.own_a = larger(absolute(params.emf_v_s * speed_rad_s * params.a_per_v),
                       flush_tiny(state.own_a * params.own_decay));
  const float most_a = absolute(state.measured_a);
  const float own_a = kOwnErrorShare * state.own_a;
  state.never_doubted_a = own_a + params.mean_slack_a + kQuickShare * most_a;
  const float too_low_a = larger(state.never_doubted_a, own_a + kMostTooLow * most_a);
  const float too_high_a =
      own_a + larger(params.mean_slack_a + kModelErrorShare * most_a, kMostTooHigh * most_a);
  const bool forth = state.measured_a >= 0.0F;
  state.above_a =
      larger(state.above_a + state.difference_a - (forth ? too_high_a : too_low_a), 0.0F);
  state.below_a =
      larger(state.below_a - state.difference_a - (forth ? too_low_a : too_high_a), 0.0F);
  return larger(state.above_a, state.below_a) < params.mean_patience_a;
}

/// After each believe_means(): the change while nearly the same current flowed. So much as
/// resistance and supply may be wrong they are so for long.
/// @returns false once it cannot be true
constexpr bool believe_change(WindingState& state, const WindingParams& params) {
  const float rise_a = state.difference_a - state.steady_difference_a;
  const float moved_a = state.measured_a - state.steady_measured_a;
  const float allowed_a = state.never_doubted_a + kMostTooHigh * absolute(moved_a) +
                          kOwnErrorShare * state.steady_own_a;
  state.steady_difference_a = flush_tiny(state.steady_difference_a + params.steady_share * rise_a);
  state.steady_measured_a = flush_tiny(state.steady_measured_a + params.steady_share * moved_a);
  state.steady_own_a =
      flush_tiny(state.steady_own_a + params.steady_share * (state.own_a - state.steady_own_a));
  state.rise_a = larger(state.rise_a + rise_a - allowed_a, 0.0F);
  state.fall_a = larger(state.fall_a - rise_a - allowed_a, 0.0F);
  return larger(state.rise_a, state.fall_a) < params.mean_patience_a;
}

}  // namespace torsio::core
