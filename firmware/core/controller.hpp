/// @file
/// One control tick, from the encoder's count to the commands of motor and brake:
///
///     count -> motion -> scene -> brake model -> soft sensor -> bound -> partition -> impacts
///     -> slew
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
  BoundState bound;            // while a plan bounds
  Ledger ledger;               // of a law that knows its brake
  SceneState scene;            // last, for it is large
};

/// How a tick goes from the count to the commands. Each does what the next one does, but less.
enum class Pipeline : std::uint8_t {
  plain,    // the scene, by a law that does not know its brake, on a straight shaft
  bounded,  // the scene by the law calibrated: nothing in it plays in time, no impacts, and the
            // bound knows of no change but the knob's
  full,     // everything
  once,     // everything, and the next tick chooses anew
};

/// What plays, and by which pipeline. Made when something changes, followed by every tick.
struct Plan {
  Pipeline pipeline = Pipeline::full;  // right for every plan
  const Scene* scene = nullptr;        // nullptr: none plays
  // The full pipeline alone looks at these: (scene + local) * gain + extra, bounded.
  const LocalModel* local = nullptr;      // nullptr: nothing is streamed
  float gain = 1;                         // 0 to 1, for a soft start
  ForceSource* extra = nullptr;           // nullptr: nothing but scene and local model
  ExcitationState* excitation = nullptr;  // instead of all that, and of the law
  bool impacts = false;                   // the scene has some
  bool bounds = false;                    // the law calibrated, while somebody plays

  /// Whether it is another in each tick.
  bool passes() const {
    return gain != 1.0F || local != nullptr || extra != nullptr || excitation != nullptr;
  }
};

/// The plan for a scene alone, before its pipeline is chosen.
/// @param scene nullptr: none
inline Plan plan_of(const ControllerParams& params, const Scene* scene) {
  Plan plan;
  plan.scene = scene;
  plan.impacts = scene != nullptr && has_impacts(*scene);
  plan.bounds = traits(params.partition.law).bounds;
  return plan;
}

/// The pipeline that does the least of those that do all of the plan, for the next tick.
inline Pipeline pipeline_of(const Plan& plan, const ControllerParams& params,
                            const BoundState& bound) {
  if (plan.passes()) return Pipeline::once;
  if (plan.impacts) return Pipeline::full;
  if (!traits(params.partition.law).bounds) {
    return params.shaft.bent() ? Pipeline::full : Pipeline::plain;
  }
  const bool in_time = plan.scene != nullptr && plays_in_time(*plan.scene);
  if (!plan.bounds || in_time) return Pipeline::full;
  // A change of the plan has yet to reach the bound.
  return bound.new_scene || bound.in_time_nm != 0.0F ? Pipeline::once : Pipeline::bounded;
}

/// The scene's torque for a law that bounds, at the last tick, and its impacts' torque.
inline float asked_torque(const ControllerState& state, const Plan& plan) {
  return asked_torque(state.bound) + (plan.impacts ? state.scene.knock_nm : 0.0F);
}

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

/// Senses, shares and limits. While nothing plays the commands are zero, and motion and sensor go
/// on.
ControllerOutputs control(ControllerState& state, const ControllerParams& params, const Plan& plan,
                          std::uint32_t encoder_count);

}  // namespace torsio::core
