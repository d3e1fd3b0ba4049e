/// @file
/// Up to 16 effects at once, and the torque that they ask for together.
#pragma once

#include <array>
#include <cstdint>

#include "core/brake_model.hpp"
#include "core/effects.hpp"
#include "core/motion.hpp"
#include "core/slew_limit.hpp"

namespace torsio::core {

inline constexpr std::uint8_t kMaxEffects = 16;
inline constexpr std::uint16_t kCurvePoolPoints = 1024;

/// The scene. Written as a whole and then left alone; only the effects in `order` are looked at.
struct Scene {
  std::array<Effect, kMaxEffects> effect;
  std::array<std::uint8_t, kMaxEffects> order{};  // slots that play, lowest first
  std::uint8_t active = 0;                        // how many of them
  std::array<float, kCurvePoolPoints> curve_torque_nm{};
};

/// How late the motor gives what it is told, as far as an impact's energy depends on it.
struct MotorLag {
  float decay = 0;           // exp(-period / time constant)
  float behind_in_tick = 0;  // largest mean share of a difference that is left in a tick
  float tail_s = 0;          // longest time constant
};

// The motor's lag may be so many times the configured one: a winding at its voltage's limit is
// slower than its current loop.
inline constexpr float kLongestLag = 2.5F;

/// @param time_constant_s >= 0
constexpr MotorLag make_motor_lag(float time_constant_s, float period_s) {
  const float decay = decay_of(time_constant_s, period_s);
  const float longest_s = kLongestLag * time_constant_s;
  return {decay, longest_s / period_s * (1.0F - decay), longest_s};
}

/// Memory of an impact.
struct ImpactState {
  std::uint64_t ready_tick = 0;  // from which on there may be another one
  bool ready = false;            // the knob has been away from the surface since
  std::uint32_t ticks = 0;       // since the impact
  std::uint32_t phase = 0;
  float sine_nm = 0;   // its amplitude by now; 0 when it is over
  float pulse_nm = 0;  // 0 when it is over
  float push_nm = 0;   // outward, as the motor was told in the last tick
  float late_nm = 0;   // the same, as the motor gave it at that tick's end
  float way_rad = 0;   // its last motion, inward
  float taken_j = 0;   // certainly, from the knob since it came in
};

/// Memory of the effects from tick to tick.
struct SceneState {
  std::array<std::uint64_t, kMaxEffects> start_tick{};
  std::array<float, kMaxEffects> twist_rad{};  // of a friction's spring
  std::array<ImpactState, kMaxEffects> impact{};
  std::uint64_t impacts_tick = 0;  // the last tick with an active impact
  float knock_nm = 0;              // torque that all of them together gave then
  float damping_nm_s_per_rad = 0;  // of all dampers, a streamed one too
  float damping_share = 1;         // of their torque that they give
  float inertia_share = 1;         // of its torque that an Inertia gives
  float inertia_nm = 0;            // that all of them gave at the last tick that had some
};

/// Makes the effects of `slots` (bit n: slot n) begin at `tick`.
void restart_effects(SceneState& state, std::uint16_t slots, std::uint64_t tick);

/// Sum of the active effects' torques on the knob but impacts', N m. Costs nothing for slots that
/// do not play.
float evaluate_scene(const Scene& scene, SceneState& state, const Motion& motion,
                     const Resolution& resolution, const std::uint64_t& tick);

/// Bit n: an active effect is the alternative n of Effect.
std::uint32_t kinds_that_play(const Scene& scene);

template <class... Kinds>
bool plays(const Scene& scene) {
  constexpr std::uint32_t kinds = ((1U << Effect(Kinds{}).index()) | ...);
  return (kinds_that_play(scene) & kinds) != 0;
}

/// Whether one of the active effects plays in time, whatever the knob does. An impact does not
/// count: it is apart.
inline bool plays_in_time(const Scene& scene) { return plays<Constant, Ramp, Periodic>(scene); }

/// Whether one of the active effects turns its torque to and fro, whatever the knob does.
inline bool shakes(const Scene& scene) { return plays<Periodic>(scene); }

/// The part of that sum that comes from virtual inertia.
float evaluate_inertia(const Scene& scene, SceneState& state, const Motion& motion,
                       const Resolution& resolution, const std::uint64_t& tick);

/// The part of that sum that plays in time.
float evaluate_timed(const Scene& scene, SceneState& state, const Resolution& resolution,
                     const std::uint64_t& tick);

/// Whether one of the active effects is an Impact.
inline bool has_impacts(const Scene& scene) { return plays<Impact>(scene); }

/// Sum of the active effects' virtual inertia.
/// @param scene nullptr: none
float inertia_kg_m2(const Scene* scene);

/// The same of the damping of its dampers; walls have theirs apart.
float damping_nm_s_per_rad(const Scene* scene);

/// Adds the impacts' torque to the motor's command for the rest of the scene. A torque beyond the
/// limits is not given, and does not count in their energy. Apart from the other effects, which
/// must not be slower for them.
/// @param motor_nm for all else
/// @param gain     0 to 1, for a soft start
/// @param lag      of the motor
/// @returns what the motor is to be told, within `range`
float add_impacts(const Scene& scene, SceneState& state, const Motion& motion,
                  const Resolution& resolution, const std::uint64_t& tick, float motor_nm,
                  float gain, const MotorRange& range, const MotorLag& lag);

/// A torque, a spring and a damper, streamed by the host.
struct LocalModel {
  float torque_nm = 0;
  Origin reference;
  float stiffness_nm_per_rad = 0;
  float damping_nm_s_per_rad = 0;

  friend bool operator==(const LocalModel&, const LocalModel&) = default;
};

/// torque - stiffness * (angle - reference) - damping * speed, N m; of the damping the same share
/// as a Damper's.
float evaluate_local_model(const LocalModel& model, const SceneState& state, const Motion& motion,
                           const Resolution& resolution);

}  // namespace torsio::core
