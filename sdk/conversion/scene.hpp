/// @file
/// A scene as it travels, with the rules across fields and the device's limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "protocol/effects.hpp"
#include "protocol/reports.hpp"
#include "torsio/scene.hpp"

namespace torsio::conversion {

/// Limits of a device's scenes.
struct SceneLimits {
  std::size_t effects = protocol::max_effects;
  std::size_t curve_points = protocol::curve_pool_points;
  std::uint32_t counts_per_rev = protocol::Identity{}.counts_per_rev;
  std::uint32_t control_period_ns = protocol::emulated_control_period_ns;
};

/// One report for each effect, in its slot, and the pool that the curves read.
struct ConvertedScene {
  std::vector<protocol::EffectReport> effects;
  std::vector<float> curve_torque_nm;
};

/// @throws InvalidArgument that names the effect, the field, its value and its range
ConvertedScene to_wire(const Scene& scene, const SceneLimits& limits);

/// @throws InvalidArgument as above
protocol::LocalModel to_wire(const LocalModel& model);
protocol::Excitation to_wire(const Excitation& excitation);

}  // namespace torsio::conversion
