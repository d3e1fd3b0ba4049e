/// @file
/// Torque of one of a game's effects at a moment. forces.hpp decides which of them play, and joins
/// them.
#pragma once

#include <cstdint>

#include "core/motion.hpp"
#include "device/game/forces.hpp"

namespace torsio::device::game {

/// Torque of a force over time, before its gain.
/// @param wave_phase that the wave has come to before
float timed_nm(const TimedForce& force, std::uint64_t elapsed, std::uint32_t duration_ticks,
               std::uint32_t wave_phase = 0);

/// A spring, a damper or an inertia.
/// @param share of its slope that is rendered; it still goes up to its limit
float proportional_nm(const Condition& condition, float value, float share);

/// Dry friction as the scene renders it, by a bristle that bends until it slips. The offset is a
/// speed that the other surface moves with; within the dead band the bristle is lifted.
float slip_nm(const Condition& condition, const core::Motion& motion, float period_s, float share,
              float& slip_rad);

}  // namespace torsio::device::game
