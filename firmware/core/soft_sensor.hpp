/// @file
/// The compliant shaft as torque sensor.
#pragma once

#include "core/math.hpp"

namespace torsio::core {

struct SoftSensorState {
  float spring_torque_nm = 0;  // on the knob
  float slipped_nm = 0;        // that the spring lost in the last tick, by the brake's turning
};

/// What turns with the brake, of which only sense_driven_spring() knows.
struct BrakeSideParams {
  float inertia_ratio = 0;  // inertia / (stiffness period^2)
  float give = 1;           // 1 / (1 + inertia_ratio)
  float countered_nm = 0;   // the most that the motor does about the inertia's torque
};

/// @param inertia_kg_m2 >= 0; 0 is none
/// @param friction_nm   dry friction of the knob. The motor takes up half as much of the inertia's
///                      torque at most: what it does late or on a wrong guess dies by friction
constexpr BrakeSideParams make_brake_side_params(float inertia_kg_m2, float stiffness_nm_per_rad,
                                                 float period_s, float friction_nm) {
  const float ratio = inertia_kg_m2 / (stiffness_nm_per_rad * period_s * period_s);
  if (!is_finite(ratio)) return {};  // no spring
  return {ratio, 1.0F / (1.0F + ratio), 0.5F * friction_nm};
}

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

/// The same where the brake's side has an inertia, which the spring must drive beyond what the
/// brake holds: its speed after this tick is the one that goes with the spring's torque after it
/// (docs/theory.md, "Inertia behind the brake"). Stable for any period; without inertia it is
/// sense_spring() but for rounding.
/// @returns spring_torque_nm, beyond the capacity by what the inertia takes
constexpr float sense_driven_spring(SoftSensorState& state, const BrakeSideParams& brake_side,
                                    float stiffness_nm_per_rad, float delta_rad,
                                    float capacity_nm) {
  const float wound_nm = state.spring_torque_nm - stiffness_nm_per_rad * delta_rad;
  const float drive_nm = wound_nm + brake_side.inertia_ratio * state.slipped_nm;
  const float beyond_nm = drive_nm - clamp_number(drive_nm, capacity_nm);
  state.slipped_nm = brake_side.give * beyond_nm;
  state.spring_torque_nm = wound_nm - state.slipped_nm;
  return state.spring_torque_nm;
}

}  // namespace torsio::core
