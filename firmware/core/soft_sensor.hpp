/// @file
/// The compliant shaft as torque sensor.
#pragma once

#include "core/math.hpp"

namespace torsio::core {

struct SoftSensorState {
  float spring_torque_nm = 0;  // on the knob
};

/// Torque of the shaft's spring on the knob: it winds up with the knob's motion and slips through
/// the brake at the brake's capacity (docs/theory.md, "Soft sensor").
/// @param stiffness_nm_per_rad of the shaft, >= 0
/// @param delta_rad            the knob's motion since the last tick
/// @param capacity_nm          what the brake can hold now, >= 0
/// @returns spring_torque_nm, within [-capacity_nm, capacity_nm]
constexpr float sense_spring(SoftSensorState& state, float stiffness_nm_per_rad, float delta_rad,
                             float capacity_nm) {
  state.spring_torque_nm =
      clamp_number(state.spring_torque_nm - stiffness_nm_per_rad * delta_rad, capacity_nm);
  return state.spring_torque_nm;
}

}  // namespace torsio::core
