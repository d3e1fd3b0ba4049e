/// @file
/// Whether the knob, let go, may swing or hum for ever; docs/explanation/theory.md, "Stability".
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string>

#include "protocol/codec.hpp"
#include "protocol/configuration.hpp"

namespace torsio::conversion {

/// @param reports what plays together, as it travels: effects, points of curves, a local model
/// @param rests_nm_per_rad up to this stiffness springs are known to rest with these parts; grows
/// @param host_moves what plays: no law bounds that
/// @returns a sentence for the user if the knob may swing or hum in it; empty if it comes to rest
std::string swing_warning(std::span<const protocol::ReportBytes> reports,
                          const protocol::ActuatorConfig& actuator,
                          const protocol::ControlConfig& control, std::uint32_t control_period_ns,
                          std::atomic<double>& rests_nm_per_rad, bool host_moves = false);

}  // namespace torsio::conversion
