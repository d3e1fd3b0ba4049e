/// @file
/// Rows of the records that a plant alone and a closed loop give.
///
/// Printed from the field lists in emulator/definition/ by `./dev generate`; change those instead.
#pragma once

#include <cstdint>
#include <string_view>

#include "torsio/field.hpp"

namespace torsio {

/// True values of a plant at one moment. Torques on the knob.
struct PlantRow {
  double time_s;
  double angle_rad;        ///< of the knob
  double brake_angle_rad;  ///< of the far side of the shaft spring
  double speed_rad_s;      ///< of the knob
  double brake_speed_rad_s;
  double spring_torque_nm;         ///< of the shaft spring
  double motor_torque_nm;          ///< after the motor's lag
  double brake_torque_nm;          ///< torque that the brake transmits, drag included
  double brake_capacity_nm;        ///< most that it could transmit, drag included, >= 0
  double hand_torque_nm;           ///< of the hand on the knob
  double knob_friction_torque_nm;  ///< Coulomb friction on the knob
  bool knob_sticks;
  bool brake_sticks;
};

/// One control tick: the truth when it samples the encoder, and its decisions then. Torques on the
/// knob.
struct LoopRow {
  double time_s;
  double angle_rad;        ///< of the knob
  double brake_angle_rad;  ///< of the far side of the shaft spring
  double speed_rad_s;      ///< of the knob
  double brake_speed_rad_s;
  double spring_torque_nm;         ///< of the shaft spring
  double motor_torque_nm;          ///< after the motor's lag
  double brake_torque_nm;          ///< torque that the brake transmits, drag included
  double brake_capacity_nm;        ///< most that it could transmit, drag included, >= 0
  double hand_torque_nm;           ///< of the hand on the knob
  double knob_friction_torque_nm;  ///< Coulomb friction on the knob
  std::int64_t position_counts;    ///< measured, from the device's zero
  float estimated_speed_rad_s;     ///< measured
  float desired_torque_nm;         ///< torque that the scene asks for
  float motor_command_nm;
  float brake_command_nm;
  float sensed_spring_torque_nm;   ///< of the shaft spring, as the soft sensor has it
  float sensed_brake_capacity_nm;  ///< believed capacity of the brake, without drag
  bool knob_sticks;
  bool brake_sticks;
  bool motor_saturated;
  bool brake_saturated;
  bool numeric_error;  ///< the scene's torque was not finite
};

/// Decisions of the controller from a count. Torques on the knob.
struct ReplayRow {
  std::int64_t position_counts;
  double speed_rad_s;
  double desired_torque_nm;
  double motor_command_nm;
  double brake_command_nm;
  double spring_torque_nm;  ///< sensed
  bool numeric_error;
};

template <>
struct Fields<PlantRow> {
  static constexpr std::string_view name = "PlantRow";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("time_s", &PlantRow::time_s, "", -kNoLimit, kNoLimit, ""),
        field("angle_rad", &PlantRow::angle_rad, "", -kNoLimit, kNoLimit, "of the knob"),
        field("brake_angle_rad", &PlantRow::brake_angle_rad, "", -kNoLimit, kNoLimit,
              "of the far side of the shaft spring"),
        field("speed_rad_s", &PlantRow::speed_rad_s, "", -kNoLimit, kNoLimit, "of the knob"),
        field("brake_speed_rad_s", &PlantRow::brake_speed_rad_s, "", -kNoLimit, kNoLimit, ""),
        field("spring_torque_nm", &PlantRow::spring_torque_nm, "", -kNoLimit, kNoLimit,
              "of the shaft spring"),
        field("motor_torque_nm", &PlantRow::motor_torque_nm, "", -kNoLimit, kNoLimit,
              "after the motor's lag"),
        field("brake_torque_nm", &PlantRow::brake_torque_nm, "", -kNoLimit, kNoLimit,
              "torque that the brake transmits, drag included"),
        field("brake_capacity_nm", &PlantRow::brake_capacity_nm, "", -kNoLimit, kNoLimit,
              "most that it could transmit, drag included, >= 0"),
        field("hand_torque_nm", &PlantRow::hand_torque_nm, "", -kNoLimit, kNoLimit,
              "of the hand on the knob"),
        field("knob_friction_torque_nm", &PlantRow::knob_friction_torque_nm, "", -kNoLimit,
              kNoLimit, "Coulomb friction on the knob"),
        field("knob_sticks", &PlantRow::knob_sticks, "", -kNoLimit, kNoLimit, ""),
        field("brake_sticks", &PlantRow::brake_sticks, "", -kNoLimit, kNoLimit, ""));
  }
};
template <>
struct Fields<LoopRow> {
  static constexpr std::string_view name = "LoopRow";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("time_s", &LoopRow::time_s, "", -kNoLimit, kNoLimit, ""),
        field("angle_rad", &LoopRow::angle_rad, "", -kNoLimit, kNoLimit, "of the knob"),
        field("brake_angle_rad", &LoopRow::brake_angle_rad, "", -kNoLimit, kNoLimit,
              "of the far side of the shaft spring"),
        field("speed_rad_s", &LoopRow::speed_rad_s, "", -kNoLimit, kNoLimit, "of the knob"),
        field("brake_speed_rad_s", &LoopRow::brake_speed_rad_s, "", -kNoLimit, kNoLimit, ""),
        field("spring_torque_nm", &LoopRow::spring_torque_nm, "", -kNoLimit, kNoLimit,
              "of the shaft spring"),
        field("motor_torque_nm", &LoopRow::motor_torque_nm, "", -kNoLimit, kNoLimit,
              "after the motor's lag"),
        field("brake_torque_nm", &LoopRow::brake_torque_nm, "", -kNoLimit, kNoLimit,
              "torque that the brake transmits, drag included"),
        field("brake_capacity_nm", &LoopRow::brake_capacity_nm, "", -kNoLimit, kNoLimit,
              "most that it could transmit, drag included, >= 0"),
        field("hand_torque_nm", &LoopRow::hand_torque_nm, "", -kNoLimit, kNoLimit,
              "of the hand on the knob"),
        field("knob_friction_torque_nm", &LoopRow::knob_friction_torque_nm, "", -kNoLimit, kNoLimit,
              "Coulomb friction on the knob"),
        field("position_counts", &LoopRow::position_counts, "", -kNoLimit, kNoLimit,
              "measured, from the device's zero"),
        field("estimated_speed_rad_s", &LoopRow::estimated_speed_rad_s, "", -kNoLimit, kNoLimit,
              "measured"),
        field("desired_torque_nm", &LoopRow::desired_torque_nm, "", -kNoLimit, kNoLimit,
              "torque that the scene asks for"),
        field("motor_command_nm", &LoopRow::motor_command_nm, "", -kNoLimit, kNoLimit, ""),
        field("brake_command_nm", &LoopRow::brake_command_nm, "", -kNoLimit, kNoLimit, ""),
        field("sensed_spring_torque_nm", &LoopRow::sensed_spring_torque_nm, "", -kNoLimit, kNoLimit,
              "of the shaft spring, as the soft sensor has it"),
        field("sensed_brake_capacity_nm", &LoopRow::sensed_brake_capacity_nm, "", -kNoLimit,
              kNoLimit, "believed capacity of the brake, without drag"),
        field("knob_sticks", &LoopRow::knob_sticks, "", -kNoLimit, kNoLimit, ""),
        field("brake_sticks", &LoopRow::brake_sticks, "", -kNoLimit, kNoLimit, ""),
        field("motor_saturated", &LoopRow::motor_saturated, "", -kNoLimit, kNoLimit, ""),
        field("brake_saturated", &LoopRow::brake_saturated, "", -kNoLimit, kNoLimit, ""),
        field("numeric_error", &LoopRow::numeric_error, "", -kNoLimit, kNoLimit,
              "the scene's torque was not finite"));
  }
};
template <>
struct Fields<ReplayRow> {
  static constexpr std::string_view name = "ReplayRow";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("position_counts", &ReplayRow::position_counts, "", -kNoLimit, kNoLimit, ""),
        field("speed_rad_s", &ReplayRow::speed_rad_s, "", -kNoLimit, kNoLimit, ""),
        field("desired_torque_nm", &ReplayRow::desired_torque_nm, "", -kNoLimit, kNoLimit, ""),
        field("motor_command_nm", &ReplayRow::motor_command_nm, "", -kNoLimit, kNoLimit, ""),
        field("brake_command_nm", &ReplayRow::brake_command_nm, "", -kNoLimit, kNoLimit, ""),
        field("spring_torque_nm", &ReplayRow::spring_torque_nm, "", -kNoLimit, kNoLimit, "sensed"),
        field("numeric_error", &ReplayRow::numeric_error, "", -kNoLimit, kNoLimit, ""));
  }
};

}  // namespace torsio
