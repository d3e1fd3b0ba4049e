/// @file
/// The shaft's spring: a straight line, or one with knees.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "core/math.hpp"

namespace torsio::core {

inline constexpr std::uint8_t kMostKnees = 4;

/// Where the spring's line bends, both ways alike.
struct ShaftKnee {
  float twist_rad = 0;             // 0: there is none, nor any after it
  float stiffness_nm_per_rad = 0;  // from there on, > 0
};

/// The inertia with the brake; only sense_driven_spring() knows it.
struct BrakeSideParams {
  float inertia_ratio = 0;  // inertia / (stiffness period^2)
  float give = 1;           // 1 / (1 + inertia_ratio)
  float countered_nm = 0;   // the most that the motor does about the inertia's torque
};

/// @param inertia_kg_m2 >= 0; 0 is none
/// @param friction_nm   dry friction of the knob. The motor takes up at most 1.5 times as much of
///                      the inertia's torque. A swing that lives on a wrong guess costs the trust
///                      (stiffness_bound.hpp), and friction stops it
constexpr BrakeSideParams make_brake_side_params(float inertia_kg_m2, float stiffness_nm_per_rad,
                                                 float period_s, float friction_nm) {
  const float ratio = inertia_kg_m2 / (stiffness_nm_per_rad * period_s * period_s);
  if (!is_finite(ratio)) return {};  // no spring
  return {ratio, 1.0F / (1.0F + ratio), 1.5F * friction_nm};
}

/// A straight piece of the spring: offset_nm + stiffness_nm_per_rad * wind, for torques from low_nm
/// to high_nm. The wind is what turns the knob: the twist with the torque's sign.
struct ShaftPiece {
  float stiffness_nm_per_rad = 0;
  float offset_nm = 0;
  float low_nm = 1;  // as it is made, it holds for no torque
  float high_nm = -1;
  BrakeSideParams brake_side{};
};

struct ShaftParams {
  std::array<ShaftPiece, kMostKnees + 1> piece{};  // from the middle to positive torques
  std::uint8_t pieces = 0;

  constexpr bool bent() const { return pieces > 1; }
  constexpr const ShaftPiece& middle() const { return piece[0]; }
};

/// @param stiffness_nm_per_rad up to the first knee, >= 0; without a spring there are no knees
/// @param knees                their twists grow
/// @param inertia_kg_m2, period_s, friction_nm as for make_brake_side_params()
constexpr ShaftParams make_shaft_params(float stiffness_nm_per_rad,
                                        std::span<const ShaftKnee, kMostKnees> knees,
                                        float inertia_kg_m2, float period_s, float friction_nm) {
  constexpr float kForEver = std::numeric_limits<float>::infinity();
  ShaftParams shaft;
  float stiffness = stiffness_nm_per_rad;
  float from_rad = 0.0F;
  float from_nm = 0.0F;
  for (;;) {
    const std::uint8_t next = shaft.pieces;
    const bool last = next == kMostKnees || !(knees[next].twist_rad > 0.0F && stiffness > 0.0F);
    const float to_nm = last ? kForEver : from_nm + stiffness * (knees[next].twist_rad - from_rad);
    shaft.piece[next] = {stiffness, from_nm - stiffness * from_rad, next == 0 ? -to_nm : from_nm,
                         to_nm,
                         make_brake_side_params(inertia_kg_m2, stiffness, period_s, friction_nm)};
    ++shaft.pieces;
    if (last) return shaft;
    stiffness = knees[next].stiffness_nm_per_rad;
    from_rad = knees[next].twist_rad;
    from_nm = to_nm;
  }
}

/// Energy in the spring.
constexpr float stored_energy_j(const ShaftParams& shaft, float torque_nm) {
  const float most_nm = absolute(torque_nm);
  float stored_j = 0.0F;
  for (std::uint8_t i = 0; i < shaft.pieces; ++i) {
    const ShaftPiece& piece = shaft.piece[i];
    const float from_nm = i == 0 ? 0.0F : piece.low_nm;
    if (most_nm <= from_nm || !(piece.stiffness_nm_per_rad > 0.0F)) break;
    const float to_nm = smaller(most_nm, piece.high_nm);
    stored_j += 0.5F * (to_nm - from_nm) * (to_nm + from_nm) / piece.stiffness_nm_per_rad;
  }
  return stored_j;
}

}  // namespace torsio::core
