/// @file
/// Limits of this device without oscillating when no hand is on it; docs/reference/games.md derives
/// them.
#pragma once

#include "device/config.hpp"

namespace torsio::device {

/// How strong all springs, dampers and inertias together may be.
struct StableLimits {
  float stiffness = 0;  // N m/rad
  float quantised = 0;  // N m/rad, as far as the encoder's steps are concerned
  float damping = 0;    // N m s/rad
  float inertia = 0;    // kg m^2
  float bristle = 0;    // of dry friction: stiffness times the square of its torque
};

StableLimits make_stable_limits(const Config& config, float period_s);

/// How stiff a bristle of dry friction may be: as stiff as is stable, but it need not hold within
/// less than a count or two.
/// @param held_nm the torque that it holds, more than 0
float bristle_nm_per_rad(const StableLimits& limits, float held_nm);

/// The most that all effects of a game give together.
float game_torque_max_nm(const Config& config);

}  // namespace torsio::device
