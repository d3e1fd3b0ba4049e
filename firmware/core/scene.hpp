/// @file
/// Up to 16 effects at once, and the torque that they ask for together.
#pragma once

#include <array>
#include <cstdint>

#include "core/effects.hpp"
#include "core/motion.hpp"

namespace torsio::core {

inline constexpr std::uint8_t kMaxEffects = 16;
inline constexpr std::uint16_t kCurvePoolPoints = 1024;

/// What plays. Written as a whole and then left alone; only the effects in `order` are looked at.
struct Scene {
  std::array<Effect, kMaxEffects> effect;
  std::array<std::uint8_t, kMaxEffects> order{};  // slots that play, lowest first
  std::uint8_t active = 0;                        // how many of them
  std::array<float, kCurvePoolPoints> curve_torque_nm{};
};

/// What the effects remember from tick to tick.
struct SceneState {
  std::array<std::uint64_t, kMaxEffects> start_tick{};
  std::array<float, kMaxEffects> twist_rad{};  // of a friction's spring
};

/// Makes the effects of `slots` (bit n: slot n) begin at `tick`.
void restart_effects(SceneState& state, std::uint16_t slots, std::uint64_t tick);

/// Sum of the active effects' torques on the knob, N m. Costs nothing for slots that do not play.
float evaluate_scene(const Scene& scene, SceneState& state, const Motion& motion,
                     const Resolution& resolution, const std::uint64_t& tick);

/// Whether one of the active effects plays in time, whatever the knob does.
bool plays_in_time(const Scene& scene);

/// Whether one of the active effects turns its torque to and fro, whatever the knob does.
bool shakes(const Scene& scene);

/// The part of the sum that plays in time.
float evaluate_timed(const Scene& scene, SceneState& state, const Resolution& resolution,
                     const std::uint64_t& tick);

/// A torque, a spring and a damper, streamed by the host.
struct LocalModel {
  float torque_nm = 0;
  Origin reference;
  float stiffness_nm_per_rad = 0;
  float damping_nm_s_per_rad = 0;
};

/// torque - stiffness * (angle - reference) - damping * speed, N m.
float evaluate_local_model(const LocalModel& model, const Motion& motion,
                           const Resolution& resolution);

}  // namespace torsio::core
