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
  // In free space nothing may move the knob. Without this the motor would answer to the sensed
  // torque of a spring that the brake's floor allows, and could drive the knob by itself.
  if (desired_nm == 0.0F) return {};

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

constexpr Shares partition(const PartitionParams& params, float desired_nm, float spring_nm) {
  return partition_by(params.law, params, desired_nm, spring_nm);
}

/// How the law calibrated takes off friction where the scene asks for nothing.
struct AssistParams {
  float most_nm = 0;
  float nm_s_per_rad = 0;  // until that is reached
};

/// Never more than three quarters of the friction. So a moving knob loses energy even if its speed
/// is late or wrong, and a resting one goes on resting. And no more than the friction of the knob's
/// own side: a swing on the shaft's spring leaves the brake's side at rest.
/// @param full_rad_s the speed from which on all of it is given, > 0
constexpr AssistParams make_assist_params(float wanted_nm, float knob_coulomb_nm,
                                          float brake_drag_nm, float full_rad_s) {
  const float friction_nm = smaller(0.75F * (knob_coulomb_nm + brake_drag_nm), knob_coulomb_nm);
  const float most_nm = smaller(wanted_nm, friction_nm);
  return {most_nm, most_nm / full_rad_s};
}

/// The motor's torque in free air under the law calibrated. It cancels the spring as far as a
/// decaying current in the brake's coil holds it, so a stiff wall does not draw the knob back. It
/// also helps along a turning knob.
/// @param coil_nm what the brake is made to hold by its current, >= 0
constexpr float share_free_air(const PartitionParams& params, const AssistParams& assist,
                               float spring_nm, float coil_nm, float speed_rad_s) {
  const float along_nm = clamp_number(assist.nm_s_per_rad * speed_rad_s, assist.most_nm);
  return clamp_number(along_nm - clamp_number(spring_nm, coil_nm), params.motor_torque_max_nm);
}

}  // namespace torsio::core
