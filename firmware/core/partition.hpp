/// @file
/// The motor's part of the desired torque, and the brake's. All of a law is here: its row in the
/// table and its case; docs/explanation/theory.md derives them.
#pragma once

#include <array>
#include <cstddef>

#include "core/enumerations.hpp"
#include "core/math.hpp"

namespace torsio::core {

/// Facts about a law beside its equations.
struct LawTraits {
  bool counts_drag = false;  // the sensor takes the drag of a brake without current into account
  bool brakes = true;        // the brake carries its share
  bool bounds = false;       // core/stiffness_bound.hpp
  bool knows_brake = false;  // its inertia, hysteresis and lags, and that it lets go late
};

/// In the order of Law. Not every law counts the drag: with the paper's law the drag keeps the
/// motor from overcompensating (docs/explanation/theory.md).
inline constexpr std::array kLaws{
    LawTraits{},                                                          // paper
    LawTraits{.counts_drag = true},                                       // compensated
    LawTraits{},                                                          // parallel
    LawTraits{.brakes = false},                                           // motor_only
    LawTraits{.counts_drag = true, .bounds = true, .knows_brake = true},  // calibrated
};
constexpr const LawTraits& traits(Law law) { return kLaws[static_cast<std::size_t>(law)]; }

struct PartitionParams {
  Law law = Law::paper;
  float beta = 0;                 // the brake's share, 0 to 1
  float motor_torque_max_nm = 0;  // >= 0
  float brake_torque_max_nm = 0;  // >= 0
};

struct Shares {
  float motor_command_nm = 0;  // on the knob
  float brake_command_nm = 0;  // capacity to command, >= 0
  bool motor_saturated = false;
  bool brake_saturated = false;
};

/// @param law        params.law, of one who knows it beforehand: then the others cost nothing
/// @param desired_nm the scene's torque on the knob
/// @param spring_nm  the shaft spring's torque on the knob, sensed
[[gnu::always_inline]] constexpr Shares partition_by(Law law, const PartitionParams& params,
                                                     float desired_nm, float spring_nm) {
  const bool spring_helps = desired_nm * spring_nm >= 0.0F;
  float motor_nm = desired_nm;
  float brake_nm = params.beta * absolute(desired_nm);
  switch (law) {
    case Law::paper:
      if (spring_helps) motor_nm = desired_nm - spring_nm;
      if (!spring_helps) brake_nm = 0.0F;
      break;
    case Law::compensated:
    case Law::calibrated:
      motor_nm = desired_nm - spring_nm;
      if (!spring_helps) brake_nm = 0.0F;
      break;
    case Law::parallel:
      motor_nm = desired_nm - params.beta * desired_nm;
      break;
    case Law::motor_only:
      brake_nm = 0.0F;
      break;
  }
  bool motor_saturated = false;
  if (absolute(motor_nm) > params.motor_torque_max_nm) [[unlikely]] {
    motor_nm = clamp_symmetric(motor_nm, params.motor_torque_max_nm);
    motor_saturated = true;
  }
  bool brake_saturated = false;
  if (brake_nm > params.brake_torque_max_nm) [[unlikely]] {
    brake_nm = clamp_symmetric(brake_nm, params.brake_torque_max_nm);
    brake_saturated = true;
  }
  return {motor_nm, brake_nm, motor_saturated, brake_saturated};
}

/// The same, but in free space nothing may move the knob. Otherwise the motor would answer to the
/// sensed torque of a spring that the brake's floor allows, and could drive the knob by itself.
constexpr Shares partition(const PartitionParams& params, float desired_nm, float spring_nm) {
  if (desired_nm == 0.0F) return {};
  return partition_by(params.law, params, desired_nm, spring_nm);
}

/// How the law calibrated takes off drag and friction.
struct AssistParams {
  float most_nm = 0;          // of friction, where the scene asks for nothing
  float nm_s_per_rad = 0;     // until that is reached
  float drag_nm_per_rad = 0;  // see follow_drag()
  float drag_most_nm = 0;
  float drag_more_nm = 0;  // than the scene asks for
};

/// A drag of 3 mN m is taken off on 2.5 mrad.
inline constexpr float kDragNmPerRad = 1.2F;

/// The share of it that is taken off. The rest is left for wrong beliefs.
inline constexpr float kDragShare = 0.6F;

/// Never more than three quarters of the friction. So a moving knob loses energy even if its speed
/// is late or wrong, and a resting one goes on resting. And no more than the friction of the knob's
/// own side: a swing on the shaft's spring leaves the brake's side at rest. One count changes the
/// cancelled drag by at most a quarter of the friction.
/// @param full_rad_s the speed from which on all of it is given, > 0
/// @param hysteresis_nm, countered_nm what the sensor reads beside the drag where the brake's coil
///                   holds nothing
constexpr AssistParams make_assist_params(float wanted_nm, float knob_coulomb_nm,
                                          float brake_drag_nm, float full_rad_s,
                                          float rad_per_count, float hysteresis_nm,
                                          float countered_nm) {
  const float friction_nm = smaller(0.75F * (knob_coulomb_nm + brake_drag_nm), knob_coulomb_nm);
  const float most_nm = smaller(wanted_nm, friction_nm);
  return {most_nm, most_nm / full_rad_s,
          smaller(0.25F * knob_coulomb_nm / rad_per_count, kDragNmPerRad),
          kDragShare * (brake_drag_nm + hysteresis_nm + knob_coulomb_nm) + countered_nm,
          0.5F * knob_coulomb_nm};
}

/// How much of the cancelled drag comes or goes with the knob's way.
constexpr float drag_step(const AssistParams& params, float delta_rad) {
  return params.drag_nm_per_rad * absolute(delta_rad);
}

/// How much of the brake's drag the motor cancels. It follows the scene's torque with the knob's
/// way: a motor that leaps at a wall's edge keeps the knob there in motion. Once the knob has moved
/// it exceeds what the scene asks for by half the friction at most.
/// @param drag_nm at the last tick, >= 0
constexpr float follow_drag(float drag_nm, const AssistParams& params, float desired_nm,
                            float delta_rad) {
  const float way_nm = drag_step(params, delta_rad);
  // In this order a torque that is not finite does not stay.
  const float most_nm =
      smaller_number(params.drag_most_nm, absolute(desired_nm) + params.drag_more_nm);
  return larger(smaller_number(drag_nm + way_nm, most_nm), drag_nm - way_nm);
}

/// The same where the scene asks for nothing: it ends.
constexpr float end_drag(float drag_nm, const AssistParams& params, float delta_rad) {
  return larger(drag_nm - drag_step(params, delta_rad), 0.0F);
}

/// What is added where the scene asks for nothing: help along a turning knob.
constexpr float assist_torque(const AssistParams& params, float speed_rad_s) {
  return clamp_number(params.nm_s_per_rad * speed_rad_s, params.most_nm);
}

}  // namespace torsio::core
