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
  MotorLag motor_lag;
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
  bent,     // the same on a bent shaft
  full,     // everything
};

/// What the law plays: (scene + local) * gain + extra.
struct Play {
  const Scene* scene = nullptr;       // nullptr: none
  const LocalModel* local = nullptr;  // nullptr: nothing is streamed
  float gain = 1;                     // 0 to 1, for a soft start
  ForceSource* extra = nullptr;       // nullptr: nothing but scene and local model

  /// Whether it is another in each tick.
  bool passes() const { return gain != 1.0F || local != nullptr || extra != nullptr; }
};

/// What plays, and by which pipeline. Made when something changes, followed by every tick.
struct Plan : Play {
  Pipeline pipeline = Pipeline::full;     // right for every plan
  bool once = false;                      // the next tick needs a new plan
  bool impacts = false;                   // the scene has some
  bool bounds = false;                    // the law calibrated plays
  float inertia_kg_m2 = 0;                // of the scene, if the same plays
  ExcitationState* excitation = nullptr;  // instead of the law
};

/// For a scene of the simplest effects.
inline Pipeline least_pipeline(const ControllerParams& params) {
  const bool bent = params.shaft.bent();
  if (traits(params.partition.law).bounds) return bent ? Pipeline::bent : Pipeline::bounded;
  return bent ? Pipeline::full : Pipeline::plain;
}

/// While nobody plays.
inline Plan idle_plan(const ControllerParams& params) {
  Plan plan;
  const bool bounds = traits(params.partition.law).bounds;
  if (!bounds && !params.shaft.bent()) plan.pipeline = Pipeline::plain;
  return plan;
}

inline Plan plan_of(ExcitationState& excitation) {
  Plan plan;
  plan.once = true;
  plan.excitation = &excitation;
  return plan;
}

/// By the pipeline that does the least of those that do all of it.
inline Plan plan_of(const ControllerParams& params, const BoundState& bound, const Play& play) {
  Plan plan{play};
  const auto is = [&](bool (*so)(const Scene&)) {
    return play.scene != nullptr && so(*play.scene);
  };
  plan.impacts = is(has_impacts);
  plan.bounds = traits(params.partition.law).bounds;
  if (plan.bounds) plan.inertia_kg_m2 = inertia_kg_m2(play.scene);
  const bool in_time = plan.bounds && is(plays_in_time);
  // A change of the plan has yet to reach the bound.
  const bool pending = plan.bounds && !in_time && (bound.new_scene || bound.in_time_nm != 0.0F);
  plan.once = play.passes() || pending;
  if (plan.once || plan.impacts || plan.inertia_kg_m2 != 0.0F || in_time) return plan;
  plan.pipeline = least_pipeline(params);
  return plan;
}

/// The scene's torque for a law that bounds, at the last tick, with what passes the bound.
inline float asked_torque(const ControllerState& state, const Plan& plan) {
  const float inertia_nm = plan.inertia_kg_m2 != 0.0F ? state.scene.inertia_nm : 0.0F;
  return asked_torque(state.bound) + inertia_nm + (plan.impacts ? state.scene.knock_nm : 0.0F);
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

/// A host streams another model from the next tick on. Its torque passes the bound. So does what
/// its spring gives otherwise here; but where less is given than asked, nearly the same spring
/// keeps the bound's line, and any other is a new scene.
/// @param from, to nullptr: none; a stream that begins or ends is a new scene
void change_local_model(ControllerState& state, const ControllerParams& params,
                        const LocalModel* from, const LocalModel* to);

/// Senses, shares and limits. While nothing plays the commands are zero, and motion and sensor go
/// on.
ControllerOutputs control(ControllerState& state, const ControllerParams& params, const Plan& plan,
                          std::uint32_t encoder_count);

}  // namespace torsio::core
