/// @file
/// The stiffest spring that motor, encoder and rate can render without swinging for ever
/// (docs/explanation/theory.md, "Stability").
#pragma once

#include <cstdint>

#include "core/math.hpp"

namespace torsio::core {

/// Inputs of stability. SI units, torques at the knob. Here as in all of core a number that nobody
/// has given is 0: what an actuator is by default, its configuration says.
struct Parts {
  float period_s = 0;
  float rad_per_count = 0;
  float motor_time_constant_s = 0;
  float delay_s = 0;  // between decision and voltage, beyond the half period of holding
  float knob_inertia_kg_m2 = 0;
  float knob_coulomb_nm = 0;
  float knob_viscous_nm_s_per_rad = 0;
  float spring_stiffness_nm_per_rad = 0;
  float brake_share = 0;  // beta; 0 with a law that leaves the brake alone
  float motor_torque_max_nm = 0;
};

enum class StabilityLimit : std::uint8_t { rate, lag, counts };

struct StableStiffness {
  float stiffness_nm_per_rad = 0;
  StabilityLimit limited_by = StabilityLimit::rate;
};

/// Whether the motor moves the knob against its friction. Else one count switches nothing that
/// moves.
constexpr bool moves_knob(float motor_torque_max_nm, float knob_coulomb_nm) {
  return motor_torque_max_nm > knob_coulomb_nm;
}

/// A spring that acts late by d feeds every swing, as negative damping of (K - what spring and
/// brake carry) d would. Friction takes 4 f / (pi v), least where the motor saturates, at v = Tmm /
/// sqrt(K J). Both are equal at the limit. A fifth is taken off the friction's part, for what the
/// describing function leaves out.
/// @param parts period_s, rad_per_count and knob_inertia_kg_m2 > 0
constexpr StableStiffness stable_stiffness(const Parts& parts) {
  const float held_s = 0.5F * parts.period_s;
  const float late_s = held_s + parts.motor_time_constant_s + parts.delay_s;
  const float friction = 1.02F * parts.knob_coulomb_nm * square_root(parts.knob_inertia_kg_m2) /
                         larger(parts.motor_torque_max_nm, 1e-6F);
  // late (K - carried) = viscous + friction sqrt(K), for sqrt(K).
  const auto solve = [&](float late, float carried_nm_per_rad) {
    const float losses = parts.knob_viscous_nm_s_per_rad + late * carried_nm_per_rad;
    const float root =
        (friction + square_root(friction * friction + 4.0F * late * losses)) / (2.0F * late);
    return root * root;
  };
  // The brake carries its share, but never more than the shaft's spring winds up.
  float stiffness = solve(late_s, parts.spring_stiffness_nm_per_rad);
  if (parts.brake_share * stiffness < parts.spring_stiffness_nm_per_rad) {
    const float alone = 1.0F - parts.brake_share;
    stiffness = alone > 0.0F ? solve(late_s * alone, 0.0F) : stiffness;
    const float full = parts.spring_stiffness_nm_per_rad / larger(parts.brake_share, 1e-6F);
    stiffness = smaller(stiffness, full);
  }
  const float lag_s = late_s - held_s;
  const auto cause = lag_s > held_s ? StabilityLimit::lag : StabilityLimit::rate;
  // One count switches the whole motor.
  const float one_count = parts.motor_torque_max_nm / parts.rad_per_count;
  const bool moves = moves_knob(parts.motor_torque_max_nm, parts.knob_coulomb_nm);
  if (moves && one_count < stiffness) return {one_count, StabilityLimit::counts};
  return {stiffness, cause};
}

}  // namespace torsio::core
