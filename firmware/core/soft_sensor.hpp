/// @file
/// The compliant shaft as torque sensor.
#pragma once

#include "core/math.hpp"
#include "core/shaft.hpp"

namespace torsio::core {

struct SoftSensorState {
  float spring_torque_nm = 0;  // on the knob
  float slipped_nm = 0;        // that the spring lost in the last tick, by the brake's turning
  ShaftPiece piece{};          // where a bent shaft is now; of a straight one its brake's side
};

/// Torque of the shaft's spring on the knob: it winds up with the knob's motion and slips through
/// the brake at the brake's capacity (docs/explanation/theory.md, "Soft sensor").
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

/// The same with an inertia on the brake's side, which the spring must drive beyond the brake's
/// capacity. Its speed after this tick goes with the spring's torque after it
/// (docs/explanation/theory.md, "Inertia behind the brake"). Stable for any period; without inertia
/// it equals sense_spring() up to rounding.
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

/// One tick on a straight piece: sense_driven_spring() or sense_spring().
template <bool kDriven>
constexpr float sense_piece(SoftSensorState& state, const ShaftPiece& piece, float delta_rad,
                            float capacity_nm) {
  const float stiffness = piece.stiffness_nm_per_rad;
  if constexpr (kDriven) {
    const BrakeSideParams side = state.piece.brake_side;
    return sense_driven_spring(state, side, stiffness, delta_rad, capacity_nm);
  } else {
    return sense_spring(state, stiffness, delta_rad, capacity_nm);
  }
}

/// The tick on which a bent shaft leaves its piece, and its first one; out of line, for that is
/// rare.
[[gnu::noinline]] float cross_knees(SoftSensorState& state, const ShaftParams& shaft,
                                    float delta_rad, float capacity_nm, bool driven);

/// The same for a shaft with knees. Each piece is a straight line. If a tick begins and ends on one
/// piece, only that piece counts. Exact at the knees and between them.
template <bool kDriven>
constexpr float sense_bent_shaft(SoftSensorState& state, const ShaftParams& shaft, float delta_rad,
                                 float capacity_nm) {
  const float torque_nm = state.spring_torque_nm;
  const float slipped_nm = state.slipped_nm;
  const float next_nm = sense_piece<kDriven>(state, state.piece, delta_rad, capacity_nm);
  if (next_nm < state.piece.low_nm || next_nm > state.piece.high_nm) [[unlikely]] {
    state.spring_torque_nm = torque_nm;
    state.slipped_nm = slipped_nm;
    return cross_knees(state, shaft, delta_rad, capacity_nm, kDriven);
  }
  return next_nm;
}

}  // namespace torsio::core
