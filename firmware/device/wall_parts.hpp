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

}  // namespace torsio::device
