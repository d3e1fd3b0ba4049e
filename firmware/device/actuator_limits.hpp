/// @file
/// The most that a configuration lets the actuator give; for the host too.
#pragma once

#include <cstdint>
#include <limits>

#include "core/math.hpp"
#include "protocol/configuration.hpp"

namespace torsio::device {

/// How far a configuration is believed. Other parts get little torque and speed.
enum class Trust : std::uint8_t {
  none,
  experiments,  // excitations, which bring their own bounds: so that a calibration can measure it
  all,
};

/// @param moves_parts there is a real motor
/// @param assumed     what torques are measured by is a guess, or has changed since it was none
constexpr Trust trust_in(bool moves_parts, protocol::Toggle confirmed, bool assumed) {
  if (!moves_parts) return Trust::all;
  if (confirmed == protocol::Toggle::off) return Trust::none;
  return assumed ? Trust::experiments : Trust::all;
}

struct ActuatorLimits {
  float motor_torque_max_nm = 0;
  float brake_torque_max_nm = 0;
  float speed_limit_rad_s = std::numeric_limits<float>::infinity();
};

/// The parts' limits, at most their caps.
constexpr ActuatorLimits configured_limits(const protocol::ActuatorConfig& actuator,
                                           const protocol::ControlConfig& control) {
  ActuatorLimits limits{core::smaller(actuator.motor_torque_max_nm, control.motor_torque_cap_nm),
                        core::smaller(actuator.brake_torque_max_nm, control.brake_torque_cap_nm)};
  if (control.speed_limit_rad_s > 0.0F) limits.speed_limit_rad_s = control.speed_limit_rad_s;
  return limits;
}

/// A sign that is wrong, or values of other parts, then end in a fault and not in a bruise.
constexpr ActuatorLimits held_low(const ActuatorLimits& limits) {
  return {core::smaller(limits.motor_torque_max_nm, protocol::unconfirmed_motor_torque_max_nm),
          core::smaller(limits.brake_torque_max_nm, protocol::unconfirmed_brake_torque_max_nm),
          core::smaller(limits.speed_limit_rad_s, protocol::unconfirmed_speed_limit_rad_s)};
}

}  // namespace torsio::device
