/// @file
/// Scenes and configurations as the reports that travel, for tools that keep, show or replay them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "torsio/config.hpp"
#include "torsio/export.hpp"
#include "torsio/scene.hpp"

namespace torsio {

/// The 64 bytes of a report; docs/protocol.md says what they mean. Sequence numbers are 0.
using WireReport = std::array<std::uint8_t, 64>;

/// The reports of a scene: an effect report for each effect, in order, then the pieces of the pool
/// of curve points.
/// @throws InvalidArgument that names the effect, the field, its value and its range
[[nodiscard]] TORSIO_EXPORT std::vector<WireReport> wire_reports(const Scene& scene,
                                                                 std::uint32_t counts_per_rev,
                                                                 std::uint32_t control_period_ns);

/// @throws InvalidArgument that names the field, its value and its range
[[nodiscard]] TORSIO_EXPORT WireReport wire_report(const ActuatorConfig& config);
[[nodiscard]] TORSIO_EXPORT WireReport wire_report(const ControlConfig& config);

}  // namespace torsio
