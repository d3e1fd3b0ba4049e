/// @file
/// No wall that buzzes: what the scene asks may rise along the angle only as steeply as the parts
/// can render, and that is found out from the knob's swings (docs/theory.md, "No wall that
/// buzzes").
#pragma once

#include <cstdint>

#include "core/math.hpp"
#include "core/stability.hpp"

namespace torsio::core {

struct BoundParams {
  float stiffness_nm_per_rad = 0;  // that a touch begins with
  float least_share = 1.0F / 64;   // of it that is always left
  std::uint32_t buzz_ticks = 0;    // a swing that takes longer is a hand's
};

/// A wall that somebody leans on can be several times as stiff as a spring that swings freely, so
/// the bound begins well above what is stable in every case and comes down when it must.
constexpr BoundParams make_bound_params(const StableStiffness& stable, float period_s) {
  BoundParams params;
  params.stiffness_nm_per_rad = 3.0F * stable.stiffness_nm_per_rad;
  params.buzz_ticks = round_to_u32(0.04F / period_s);
  return params;
}

struct BoundState {
  float asked_nm = 0;  // at the last tick
  float given_nm = 0;
  float in_time_nm = 0;            // what of it is none of the knob's motion
  float share = 1;                 // of the bound to begin with that is left
  bool new_scene = true;           // the next change is none of the knob's motion
  bool rises = true;               // the way of the swing that goes on
  std::int32_t swing_counts = 0;   // how far it went, >= 0
  std::int32_t back_counts = 0;    // how far the knob has come back from there, 0 to 2
  std::int32_t widest_counts = 0;  // of the swings before that did not get smaller
  std::uint32_t swings = 0;        // on end that did not get smaller
  std::uint32_t turned_tick = 0;
};

/// What moves by this much at most counts as being at rest: its encoder flickers.
inline constexpr std::int32_t kRestCounts = 2;

/// The knob has turned round: looks at the swing that has ended. One that is shorter than a hand's
/// and hardly smaller than those before got from the device what friction took from it, so the
/// bound goes down. Out of line: it is rare.
[[gnu::noinline]] constexpr void judge_swing(BoundState& state, const BoundParams& params,
                                             std::uint32_t tick) {
  const std::uint32_t lasted_ticks = tick - state.turned_tick;
  const std::int32_t width = state.swing_counts;
  state.turned_tick = tick;
  state.rises = !state.rises;
  state.swing_counts = state.back_counts;
  state.back_counts = 0;
  const bool by_hand = lasted_ticks > params.buzz_ticks;
  if (by_hand) state.share = 1.0F;  // a new touch
  if (by_hand || width * 8 < state.widest_counts * 7) {
    state.swings = 0;
    state.widest_counts = width;
    return;
  }
  if (width > state.widest_counts) state.widest_counts = width;
  if (++state.swings < 2) return;
  state.share = larger(0.6F * state.share, params.least_share);
}

/// Whether less is given than the scene asks.
constexpr bool is_bounded(const BoundState& state) { return state.given_nm != state.asked_nm; }

/// One tick.
/// @param asked_nm  the scene's torque
/// @param timed_nm  how much of its change comes from time, not from the knob's motion
/// @returns what may be given of it: of the same sign, and not more
constexpr float bound_stiffness(BoundState& state, const BoundParams& params, float asked_nm,
                                float timed_nm, std::int32_t delta_counts, float rad_per_count,
                                std::uint32_t tick) {
  float given_nm = asked_nm;
  float spring_nm = 0.0F;  // of a spring as stiff as the bound, for this tick's motion
  bool steep = false;
  if (delta_counts != 0) {
    state.back_counts += state.rises ? -delta_counts : delta_counts;
    if (state.back_counts < 0) {
      state.swing_counts -= state.back_counts;
      state.back_counts = 0;
    } else if (state.back_counts > kRestCounts) {
      judge_swing(state, params, tick);
    }
    spring_nm = -(params.stiffness_nm_per_rad * state.share) *
                (static_cast<float>(delta_counts) * rad_per_count);
    const float change_nm = asked_nm - state.asked_nm - timed_nm;
    steep = delta_counts > 0 ? change_nm < spring_nm : change_nm > spring_nm;
  }
  // What is left out is never made up for at rest: that would be energy from nowhere.
  if (steep || is_bounded(state)) {
    given_nm = state.given_nm + timed_nm + spring_nm;
    // Between nothing and what is asked.
    if (asked_nm < 0.0F) {
      given_nm = given_nm > 0.0F ? 0.0F : larger(given_nm, asked_nm);
    } else {
      given_nm = given_nm < 0.0F ? 0.0F : smaller(given_nm, asked_nm);
    }
  }
  state.asked_nm = asked_nm;
  state.given_nm = given_nm;
  return given_nm;
}

}  // namespace torsio::core
