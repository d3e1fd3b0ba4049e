/// @file
/// How a plant and a closed loop may begin, if not at rest.
///
/// Printed from the field lists in emulator/definition/ by `./dev generate`; change those instead.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "torsio/field.hpp"

namespace torsio {

/// A first phase of a closed loop with the law held off: the motor's torque is prescribed, the
/// brake is off. It ends when the knob is fast enough. Where that happens becomes angle 0, and when
/// it happens time 0; the rows begin there.
struct SpinUp {
  /// must be given; positive or negative, not 0
  double motor_command_nm = std::numeric_limits<double>::quiet_NaN();
  /// must be given; to be reached in the direction of the torque; > 0
  double speed_rad_s = std::numeric_limits<double>::quiet_NaN();
  double longest_s = 10.0;  ///< giving up after; > 0
};

/// Where a plant begins, if not at rest at angle 0.
struct InitialState {
  double time_s = 0.0;           ///< 0 to 1e9
  std::int64_t revolutions = 0;  ///< whole turns, exact however many; -1e12 to 1e12
  double angle_rad = 0.0;        ///< beyond them; -1e9 to 1e9
  double speed_rad_s = 0.0;      ///< of knob and brake together; -1e15 to 1e15
  double twist_rad = 0.0;        ///< of the shaft spring: knob minus brake; -1e9 to 1e9
  double motor_torque_nm = 0.0;  ///< after the motor's lag; -1e15 to 1e15
  /// torque that the brake holds by its current, without its drag; >= 0
  double brake_magnetic_nm = 0.0;
};

template <>
struct Fields<SpinUp> {
  static constexpr std::string_view name = "SpinUp";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("motor_command_nm", &SpinUp::motor_command_nm, "N m", -1e15, 1e15, ""),
                 field("speed_rad_s", &SpinUp::speed_rad_s, "rad/s", 1e-15, 1e15,
                       "to be reached in the direction of the torque"),
                 field("longest_s", &SpinUp::longest_s, "s", 1e-15, 1e15, "giving up after"));
  }
};
template <>
struct Fields<InitialState> {
  static constexpr std::string_view name = "InitialState";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("time_s", &InitialState::time_s, "s", 0.0, 1e9, ""),
                 field("revolutions", &InitialState::revolutions, "", -1e12, 1e12,
                       "whole turns, exact however many"),
                 field("angle_rad", &InitialState::angle_rad, "rad", -1e9, 1e9, "beyond them"),
                 field("speed_rad_s", &InitialState::speed_rad_s, "rad/s", -1e15, 1e15,
                       "of knob and brake together"),
                 field("twist_rad", &InitialState::twist_rad, "rad", -1e9, 1e9,
                       "of the shaft spring: knob minus brake"),
                 field("motor_torque_nm", &InitialState::motor_torque_nm, "N m", -1e15, 1e15,
                       "after the motor's lag"),
                 field("brake_magnetic_nm", &InitialState::brake_magnetic_nm, "N m", 0.0, 1e15,
                       "torque that the brake holds by its current, without its drag"));
  }
};

}  // namespace torsio
