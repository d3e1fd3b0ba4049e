#include "limits.hpp"

#include <algorithm>
#include <cmath>

#include "conversion/convert.hpp"
#include "conversion/heat.hpp"
#include "device/actuator_limits.hpp"

namespace torsio {

Limits limits_of(const protocol::ActuatorConfig& actuator, const protocol::ControlConfig& control,
                 const protocol::BoardConfig& board, const protocol::CalibrationConfig& calibration,
                 bool real) {
  // The device tells values as assumed that have changed since they were not.
  const bool assumed = calibration.values_are == protocol::Basis::assumed;
  const bool held_low = device::trust_in(real, board.confirmed, assumed) != device::Trust::all;
  const device::ActuatorLimits configured = device::configured_limits(actuator, control);
  const device::ActuatorLimits limits = held_low ? device::held_low(configured) : configured;
  float motor_nm = limits.motor_torque_max_nm;
  float brake_nm = limits.brake_torque_max_nm;
  const float speed_rad_s =
      std::isfinite(limits.speed_limit_rad_s) ? limits.speed_limit_rad_s : 0.0F;
  float continuous_nm = motor_nm;
  if (real) {
    const float nm_per_a = board.motor_torque_constant_nm_per_a;
    motor_nm = std::min(motor_nm, nm_per_a * board.motor_current_max_a);
    continuous_nm = std::min(motor_nm, nm_per_a * conversion::motor_continuous_a(board));
    brake_nm = std::min(brake_nm, board.brake_torque_constant_nm_per_a * board.brake_current_max_a);
  }
  return {.motor_torque_max_nm = conversion::detail::widen(motor_nm),
          .motor_torque_continuous_max_nm = conversion::detail::widen(continuous_nm),
          .brake_torque_max_nm = conversion::detail::widen(brake_nm),
          .speed_limit_rad_s = conversion::detail::widen(speed_rad_s),
          .held_low = held_low};
}

}  // namespace torsio
