/// @file
/// Hands that hold the knob, with the times of their paths in the plant's nanoseconds.
/// torsio/plant_fields.hpp has their ranges.
#pragma once

#include <cstdint>
#include <variant>

#include "emulator/plant/profile.hpp"
#include "torsio/plant.hpp"

namespace torsio::emulator {

/// Along a path. Far beyond any hand, and far within what the plant can compute.
inline constexpr double kMostSpeedRadS = 1e5;

/// Nobody touches the knob.
struct NoHand {};

/// A torque on the knob that does not depend on its motion: a weight on a string, a motor test rig.
struct TorqueHand {
  Profile torque_nm;  ///< on the knob; may jump
};

/// A hand that holds the knob and means to move it along a path:
///
///     torque = stiffness (intended - angle) + damping (intended' - speed),
///
/// with the hand's own inertia fixed to the knob.
struct ImpedanceHand {
  double inertia_kg_m2 = 0.0;
  double stiffness_nm_per_rad = 0.0;
  double damping_nm_s_per_rad = 0.0;
  Profile intended_angle_rad = Profile::constant(0.0);  ///< continuous; see PrescribedMotion
};

/// The knob follows the path whatever torque that takes. Where the path has a corner the speed
/// jumps. When the hand takes the knob, the shafts are turned together to the path's angle.
struct PrescribedMotion {
  Profile angle_rad;  ///< continuous; nowhere faster than kMostSpeedRadS
};

/// A hand whose torque is a function of the knob's motion, asked once a period and held until the
/// next.
struct FeedbackHand {
  HandFunction torque_nm;              ///< of the time since start_ns, angle and speed
  std::int64_t period_ns = 1'000'000;  ///< > 0
  std::int64_t start_ns = 0;           ///< when it takes over
};

using Hand = std::variant<NoHand, TorqueHand, ImpedanceHand, PrescribedMotion, FeedbackHand>;

/// The user's hand as the plant wants it: times of its profiles in nanoseconds of the plant.
/// @param start_ns when it takes over, which is time 0 of its profiles
/// @throws std::invalid_argument that names the profile which breaks its rules
[[nodiscard]] Hand take_hold(const torsio::Hand& hand, std::int64_t start_ns = 0);

/// @throws std::invalid_argument that names the field: a quantity out of its range or not finite,
///         or a path that jumps
void validate(const Hand& hand);

}  // namespace torsio::emulator
