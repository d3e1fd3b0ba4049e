/// @file
/// Position, speed and acceleration of the knob from a wrapping counter.
#pragma once

#include <cstdint>

#include "core/angle.hpp"
#include "core/math.hpp"

namespace torsio::core {

struct MotionParams {
  Resolution resolution;
  std::uint32_t counter_shift = 0;  // 32 minus the width of the counter in bits
  bool reversed = false;
  float lag_share = 0;  // of the tracking filter, see make_motion_params
  float speed_gain = 0;
  float speed_scale = 0;         // rad/s for a count per tick
  float acceleration_scale = 0;  // rad/s^2 for a count per tick, gained in a tick
};

/// What a tick makes of the counter.
enum class Counting : std::uint8_t {
  usual,
  first,  // it only learns where the counter is
  held,   // the knob rests, and its encoder may be noisy: a play of kRestCounts to either side
};

struct MotionState {
  std::uint32_t last_count = 0;
  Counting counting = Counting::first;
  std::uint32_t held_count = 0;  // the middle of the play
  std::uint32_t held_from = 0;   // where it was first
  std::int64_t position_counts = 0;
  float lag_counts = 0;             // how far the tracked position is behind the true one
  float speed_counts_per_tick = 0;  // tracked
};

struct Motion {
  std::int64_t position_counts = 0;
  std::int32_t delta_counts = 0;
  float delta_rad = 0;
  float speed_rad_s = 0;
  float acceleration_rad_s2 = 0;
};

/// The speed comes from a second order tracking filter (alpha-beta) with both poles at exp(-2 pi
/// bandwidth period). One count per tick is a coarse speed (0.77 rad/s at 8192 counts and 1 kHz).
/// The filter spreads it over its bandwidth.
constexpr MotionParams make_motion_params(const Resolution& resolution, std::uint32_t counter_bits,
                                          bool reversed, float speed_bandwidth_hz) {
  const float pole = exp_negative(kTwoPi * speed_bandwidth_hz * resolution.period_s);
  const float speed_scale = resolution.rad_per_count / resolution.period_s;
  return {resolution,
          32 - counter_bits,
          reversed,
          1.0F - (1.0F - pole * pole),  // in float32, a little more than the square
          (1.0F - pole) * (1.0F - pole),
          speed_scale,
          speed_scale / resolution.period_s};
}

/// A knob that moves by at most this much is at rest: its encoder flickers.
inline constexpr std::int32_t kRestCounts = 2;

/// A knob that leads the play further than this is moved by a hand.
inline constexpr std::int32_t kLedCounts = 6;

/// A tick that is not as usual: decides from which count it moves. The play follows a knob count by
/// count, so its torque does not leap.
constexpr void begin_counting(MotionState& state, std::uint32_t count, std::uint32_t shift) {
  state.last_count = count;
  if (state.counting == Counting::held) {
    const std::int32_t off = static_cast<std::int32_t>(count - state.held_count) >> shift;
    const std::int32_t led = static_cast<std::int32_t>(count - state.held_from) >> shift;
    if (led >= -kLedCounts && led <= kLedCounts) {
      std::int32_t within = off;
      if (within > kRestCounts) within = kRestCounts;
      if (within < -kRestCounts) within = -kRestCounts;
      state.held_count = count - (static_cast<std::uint32_t>(within) << shift);
      state.last_count -= static_cast<std::uint32_t>(off - within) << shift;
      return;
    }
    state.last_count = state.held_count;
  }
  state.counting = Counting::usual;
}

/// From now on a play of kRestCounts to either side is no motion.
/// @returns whether it has been so
constexpr bool hold_count(MotionState& state) {
  if (state.counting == Counting::held) return true;
  state.counting = Counting::held;
  state.held_count = state.held_from = state.last_count;
  return false;
}

/// The next tick follows each count again.
constexpr void release_count(MotionState& state) {
  if (state.counting != Counting::held) return;
  state.counting = Counting::usual;
  state.last_count = state.held_count;
}

/// One tick. The counter may wrap at its width; between two ticks it must not move by half its
/// range or more. The first tick only learns where the counter is.
constexpr Motion track_motion(MotionState& state, const MotionParams& params,
                              std::uint32_t encoder_count) {
  const std::uint32_t count = encoder_count << params.counter_shift;
  if (state.counting != Counting::usual) [[unlikely]] {
    begin_counting(state, count, params.counter_shift);
  }
  std::int32_t delta = static_cast<std::int32_t>(count - state.last_count) >> params.counter_shift;
  if (params.reversed) delta = -delta;
  state.last_count = count;
  state.position_counts += delta;

  const float old_speed = state.speed_counts_per_tick;
  const float innovation = state.lag_counts + static_cast<float>(delta) - old_speed;
  const float change = params.speed_gain * innovation;
  state.lag_counts = flush_tiny_number(params.lag_share * innovation);
  state.speed_counts_per_tick = flush_tiny_number(old_speed + change);

  return {state.position_counts, delta, static_cast<float>(delta) * params.resolution.rad_per_count,
          state.speed_counts_per_tick * params.speed_scale, change * params.acceleration_scale};
}

}  // namespace torsio::core
