/// @file
/// The parts of a configuration that decide how stiff a wall can be; for the host too.
#pragma once

#include "core/angle.hpp"
#include "core/partition.hpp"
#include "core/stability.hpp"
#include "device/actuator_limits.hpp"
#include "protocol/configuration.hpp"

namespace torsio::device {

constexpr core::Parts wall_parts(const protocol::ActuatorConfig& actuator,
                                 const protocol::ControlConfig& control,
                                 const core::Resolution& resolution) {
  return {
      .period_s = resolution.period_s,
      .rad_per_count = resolution.rad_per_count,
      .motor_time_constant_s = actuator.motor_time_constant_s,
      .knob_inertia_kg_m2 = actuator.knob_inertia_kg_m2,
      .knob_coulomb_nm = actuator.knob_coulomb_nm,
      .knob_viscous_nm_s_per_rad = actuator.knob_viscous_nm_s_per_rad,
      .spring_stiffness_nm_per_rad = actuator.spring_stiffness_nm_per_rad,
      .brake_share = core::traits(static_cast<core::Law>(control.law)).brakes ? control.beta : 0.0F,
      .motor_torque_max_nm = configured_limits(actuator, control).motor_torque_max_nm};
}

/// What dampers may give together, N m s/rad. Without spring and friction (9) of
/// docs/explanation/theory.md is 2 J a / (1 + 2 a d), within a tenth: a is the double pole of the
/// speed's filter, d the lag. At most that is half a period of hold, one until the power stage has
/// the command, and the motor's.
constexpr float stable_damping(const protocol::ActuatorConfig& actuator,
                               const protocol::ControlConfig& control, float period_s) {
  const float late_s = 1.5F * period_s + actuator.motor_time_constant_s;
  return actuator.knob_inertia_kg_m2 /
         (0.5F / (core::kTwoPi * control.speed_bandwidth_hz) + late_s);
}

}  // namespace torsio::device
