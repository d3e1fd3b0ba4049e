/// @file
/// One control tick, from the encoder's count to the commands of motor and brake:
///
///     count -> motion -> scene -> brake model -> soft sensor -> partition -> slew
///
/// The brake model says what the brake can hold *now*, after it has followed the last command for
/// one period.
#pragma once

#include <array>
#include <cstdint>

#include "core/brake_model.hpp"
#include "core/excitation.hpp"
#include "core/force_source.hpp"
#include "core/ledger.hpp"
#include "core/motion.hpp"
#include "core/partition.hpp"
#include "core/scene.hpp"
#include "core/shaft.hpp"
#include "core/slew_limit.hpp"
#include "core/soft_sensor.hpp"
#include "core/stiffness_bound.hpp"

namespace torsio::core {

struct ControllerParams {
  MotionParams motion;
  BrakeParams brake;
  ShaftParams shaft = make_shaft_params(0, std::array<ShaftKnee, kMostKnees>{}, 0, 0, 0);  // none
  PartitionParams partition;
  SlewParams slew;
  PartitionParams excitation;  // the limits of one
  BoundParams bound;           // used by the law calibrated, with `assist`
  AssistParams assist;
};

struct ControllerState {
  std::uint64_t tick = 0;  // number of ticks done
  MotionState motion;
  BrakeState brake;
  SoftSensorState sensor;
  SlewState slew;
  float brake_command_nm = 0;  // held since the last tick
  BoundState bound;            // while an overlay bounds
  Ledger ledger;               // while an overlay keeps it
  SceneState scene;            // last, for it is large
};

/// Rare parts beside the scene: (scene + local) * gain + extra, bounded. The ordinary tick without
/// it is spared all of that.
struct Overlay {
  const LocalModel* local = nullptr;      // nullptr: nothing is streamed
  float gain = 1;                         // 0 to 1, for a soft start
  ForceSource* extra = nullptr;           // nullptr: nothing but scene and local model
  ExcitationState* excitation = nullptr;  // instead of all that, and of the law
  bool impacts = false;                   // the scene has some
  bool bounds = false;                    // the law calibrated: nothing that would buzz
  bool ledger = false;       // the same law, whether or not something plays; it knows the brake
  bool bent = false;         // the shaft has knees
  bool only_bounds = false;  // nothing of the above but these three, nothing in the scene plays in
                             // time, and the bound knows of no change but the knob's
};

/// Inputs of a law and its parts beside the scene.
constexpr Overlay overlay_of(const ControllerParams& params) {
  Overlay overlay;
  overlay.bounds = overlay.ledger = traits(params.partition.law).bounds;
  overlay.bent = params.shaft.bent();
  return overlay;
}

/// The same, and what the scene itself needs beside the ordinary tick.
inline Overlay overlay_of(const ControllerParams& params, const Scene& scene) {
  Overlay overlay = overlay_of(params);
  overlay.impacts = has_impacts(scene);
  return overlay;
}

/// Whether the ledger, a bent shaft or an impact needs the slower tick.
constexpr bool is_needed(const Overlay& overlay) {
  return overlay.ledger || overlay.bent || overlay.impacts;
}

/// The scene's torque for a law that bounds, at the last tick, and its impacts' torque.
inline float asked_torque(const ControllerState& state, const Overlay& overlay) {
  return asked_torque(state.bound) + (overlay.impacts ? state.scene.knock_nm : 0.0F);
}

struct ControllerInputs {
  std::uint32_t encoder_count = 0;
  const Scene* scene = nullptr;      // nullptr: nothing plays
  const Overlay* overlay = nullptr;  // nullptr: nothing but the scene
};

struct ControllerOutputs {
  Motion motion;
  float desired_torque_nm = 0;  // within the bound, if there is one
  float motor_command_nm = 0;
  float brake_command_nm = 0;
  float brake_capacity_nm = 0;  // the brake's assumed capacity now
  float spring_torque_nm = 0;   // sensed
  bool motor_saturated = false;
  bool brake_saturated = false;
  bool numeric_error = false;  // the desired torque was not finite: commands are zero
};

/// Senses, decides and limits. With scene and overlay absent the commands are zero, while motion
/// and sensor go on.
ControllerOutputs control(ControllerState& state, const ControllerParams& params,
                          const ControllerInputs& in);

}  // namespace torsio::core
