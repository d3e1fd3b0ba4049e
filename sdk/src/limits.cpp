#include "limits.hpp"

#include <algorithm>

#include "conversion/convert.hpp"
#include "conversion/heat.hpp"

namespace torsio {

Limits limits_of(const protocol::ActuatorConfig& actuator, const protocol::ControlConfig& control,
                 const protocol::BoardConfig& board, const protocol::CalibrationConfig& calibration,
                 bool real) {
  float motor_nm = std::min(actuator.motor_torque_max_nm, control.motor_torque_cap_nm);
  float brake_nm = std::min(actuator.brake_torque_max_nm, control.brake_torque_cap_nm);
  float speed_rad_s = std::max(control.speed_limit_rad_s, 0.0F);
  const bool held_low = real && (board.confirmed == protocol::Toggle::off ||
                                 calibration.values_are == protocol::Basis::assumed);
  if (held_low) {
    motor_nm = std::min(motor_nm, protocol::unconfirmed_motor_torque_max_nm);
    brake_nm = std::min(brake_nm, protocol::unconfirmed_brake_torque_max_nm);
    const float most_rad_s = protocol::unconfirmed_speed_limit_rad_s;
    speed_rad_s = speed_rad_s > 0.0F ? std::min(speed_rad_s, most_rad_s) : most_rad_s;
  }
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
