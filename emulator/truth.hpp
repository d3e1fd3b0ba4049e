/// @file
/// True values of a plant, as rows of records.
#pragma once

#include "emulator/plant/plant.hpp"

namespace torsio::emulator {

/// Fills in the plant's columns of a TruthSample, a PlantRow or a LoopRow. Its other columns stay
/// as they are.
template <class Row>
void tell_truth(const Plant& plant, Row& row) {
  const PlantState& state = plant.state();
  const Truth truth = plant.truth();
  row.time_s = 1e-9 * static_cast<double>(state.time_ns);
  row.angle_rad = state.knob_angle_rad();
  row.brake_angle_rad = state.brake_angle_rad();
  row.speed_rad_s = state.knob_speed_rad_s();
  row.spring_torque_nm = truth.spring_torque_nm;
  row.motor_torque_nm = truth.motor_torque_nm;
  row.brake_torque_nm = truth.brake_torque_nm;
  row.brake_capacity_nm = truth.brake_capacity_nm;
  row.hand_torque_nm = truth.hand_torque_nm;
  // A sample of the truth has not all columns.
  if constexpr (requires { row.brake_speed_rad_s; }) {
    row.brake_speed_rad_s = state.brake_speed_rad_s();
    row.knob_friction_torque_nm = truth.knob_friction_torque_nm;
    row.knob_sticks = truth.knob_sticks;
    row.brake_sticks = truth.brake_sticks;
  }
}

}  // namespace torsio::emulator
