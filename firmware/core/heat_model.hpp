/// @file
/// How warm a copper winding is, by the currents that it had, so that it gets more than its
/// continuous current only for a while.
#pragma once

#include "core/math.hpp"

namespace torsio::core {

// Continuous currents come from data sheets: in air of 25 degrees they warm the winding to 125
// degrees, the limit of its insulation.
inline constexpr float kRatedAirC = 25.0F;
inline constexpr float kMostRiseK = 100.0F;

// Only currents beyond the allowed ones reach this.
inline constexpr float kTooHotRiseK = 1.2F * kMostRiseK;

// Resistance of copper over that at 25 degrees, for each degree.
inline constexpr float kCopperPerK = 3.93e-3F;

struct HeatParams {
  float share = 0;             // of its way that the warming goes in a step
  float warming_k_per_a2 = 0;  // where the way ends, with cold copper
  float air_k = 0;             // of the air above 25 degrees
  float peak_a = 0;            // allowed while the winding is cold
  float continuous_a = 0;      // allowed for ever, in this air
};

struct HeatState {
  float rise_k = 0;  // of the winding above 25 degrees
  bool too_hot = false;
};

/// @param rated_a that the winding stands for ever in air of 25 degrees
/// @param air_c   at most 100
/// @returns what it stands in that air
constexpr float continuous_in_air(float rated_a, float air_c) {
  return rated_a * square_root((kMostRiseK - (air_c - kRatedAirC)) / kMostRiseK);
}

/// @param rated_a         that the winding stands for ever in air of 25 degrees, >= 0
/// @param air_c           at most 100
/// @param time_constant_s with which it warms and cools, > step_s > 0
constexpr HeatParams make_heat(float peak_a, float rated_a, float air_c, float time_constant_s,
                               float step_s) {
  const float rated_a2 = larger(rated_a * rated_a, 1e-6F);
  const float hot_copper = 1.0F + kCopperPerK * kMostRiseK;
  return {step_s / time_constant_s, kMostRiseK / (hot_copper * rated_a2), air_c - kRatedAirC,
          peak_a, smaller(continuous_in_air(rated_a, air_c), peak_a)};
}

/// Nothing has flowed for long.
constexpr HeatState cold_winding(const HeatParams& params) { return {params.air_k, false}; }

/// One step: the heat of the current in copper that is as warm as it is, less what the air takes.
constexpr void warm_up(HeatState& state, const HeatParams& params, float current_a) {
  const float copper = 1.0F + kCopperPerK * state.rise_k;
  const float end_k = params.air_k + params.warming_k_per_a2 * current_a * current_a * copper;
  const float rise_k = state.rise_k + params.share * (end_k - state.rise_k);
  state.rise_k = flush_tiny(smaller(rise_k, 10.0F * kMostRiseK));
  state.too_hot = state.rise_k > (state.too_hot ? kMostRiseK : kTooHotRiseK);
}

/// @returns the current that is allowed now: the peak until three quarters of the way from the air
///          to the most, from there less and less
constexpr float allow_current(const HeatState& state, const HeatParams& params) {
  const float left_k = kMostRiseK - state.rise_k;
  const float last_k = 0.25F * (kMostRiseK - params.air_k);
  if (left_k <= 0.0F) return params.continuous_a;
  if (left_k >= last_k) return params.peak_a;
  return params.continuous_a + (params.peak_a - params.continuous_a) * (left_k / last_k);
}

}  // namespace torsio::core
