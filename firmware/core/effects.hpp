/// @file
/// The effects of a scene, prepared for the tick: every division, conversion and exponential has
/// been done. Torques are torques on the knob, positive along positive angle.
#pragma once

#include <cstdint>
#include <variant>

#include "core/angle.hpp"
#include "core/enumerations.hpp"

namespace torsio::core {

/// When an effect plays and how strong it is then. Times in ticks since the effect began.
struct Timing {
  std::uint32_t delay_ticks = 0;
  std::uint32_t duration_ticks = 0;  // 0 is without end
  std::uint32_t attack_ticks = 0;
  std::uint32_t fade_ticks = 0;
  float attack_level = 1;
  float attack_rise_per_tick = 0;  // (1 - attack_level) / attack_ticks
  float fade_level = 1;
  float fade_fall_per_tick = 0;  // (1 - fade_level) / fade_ticks
};

/// stiffness * depth + damping * inward speed inside, never a pull.
struct Wall {
  Origin surface;
  float outward = -1;  // sign of the torque that pushes out of it
  float stiffness_nm_per_rad = 0;
  float damping_nm_s_per_rad = 0;
};

struct Spring {
  Origin rest;
  float stiffness_nm_per_rad = 0;
  float deadband_rad = 0;
  float torque_limit_nm = 0;
};

struct Damper {
  float damping_nm_s_per_rad = 0;
  float torque_limit_nm = 0;
};

/// A spring to an anchor that slips at reach_rad = torque / stiffness.
struct Friction {
  float stiffness_nm_per_rad = 0;
  float reach_rad = 0;
};

struct Inertia {
  float inertia_kg_m2 = 0;
  float torque_limit_nm = 0;
};

struct Constant {
  float torque_nm = 0;
  Timing timing;
};

struct Ramp {
  float start_torque_nm = 0;
  float rise_nm_per_tick = 0;
  Timing timing;
};

struct Periodic {
  Waveform waveform = Waveform::sine;
  float amplitude_nm = 0;
  float offset_nm = 0;
  std::uint32_t start_phase = 0;
  std::uint32_t phase_per_tick = 0;
  Timing timing;
};

struct Detents {
  Pattern pattern;
  float torque_nm = 0;
  DetentProfile profile = DetentProfile::sine;
  float slope = 4;  // click: torque share per pitch, 2 / width
};

struct EndStops {
  Wall lower;
  Wall upper;
};

struct Texture {
  std::uint64_t turns_per_count_q64 = 0;
  std::uint32_t grains_per_turn = 1;
  float torque_nm = 0;
  Grain grain = Grain::noise;
  std::uint32_t seed = 0;
};

/// Linear between points of the scene's pool.
struct Curve {
  Pattern pattern;  // repeats with the span
  float intervals_per_rad = 0;
  std::uint16_t first_point = 0;
  std::uint16_t intervals = 1;
  bool repeats = false;
};

/// The knock of something hard, in proportion to the speed with which the knob comes in.
struct Impact {
  Origin surface;
  float outward = -1;  // as a wall's
  float strength_nm_s_per_rad = 0;
  std::uint32_t phase_per_tick = 0;
  float decay_per_tick = 0;
  std::uint32_t sine_ticks = 0;  // until it has died away
  float pulse_nm_s_per_rad = 0;
  std::uint32_t pulse_ticks = 0;
  float torque_limit_nm = 0;
  float least_speed_rad_s = 0;   // slower is a count that flickers
  std::uint32_t rest_ticks = 0;  // from one impact to the next, at least
};

/// std::monostate is an empty slot.
using Effect = std::variant<std::monostate, Wall, Spring, Damper, Friction, Inertia, Constant, Ramp,
                            Periodic, Detents, EndStops, Texture, Curve, Impact>;

/// Value in [-1, 1] of a waveform; a period is 2^32. Sine and triangle start at 0 and rise, the
/// square starts high.
constexpr float waveform_value(Waveform waveform, std::uint32_t phase) {
  switch (waveform) {
    case Waveform::sine:
      return sin_phase(phase);
    case Waveform::square:
      return phase < 0x80000000U ? 1.0F : -1.0F;
    case Waveform::triangle: {
      if (phase + 0x40000000U > 0x80000000U) phase = 0x80000000U - phase;
      return static_cast<float>(static_cast<std::int32_t>(phase)) * 0x1p-30F;
    }
    case Waveform::sawtooth_up:
      return static_cast<float>(static_cast<std::int32_t>(phase - 0x80000000U)) * 0x1p-31F;
    case Waveform::sawtooth_down:
      return static_cast<float>(static_cast<std::int32_t>(phase - 0x80000000U)) * -0x1p-31F;
  }
  return 0.0F;
}

}  // namespace torsio::core
