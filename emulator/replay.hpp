/// @file
/// The controller on its own: set up from reports, and run over recorded counts. The 64-bit build
/// of the controller has this file too.
#pragma once

#include <cstdint>
#include <span>

#include "core/controller.hpp"
#include "device/config.hpp"
#include "emulator/closed_loop_options.hpp"
#include "emulator/rows.hpp"

namespace torsio::emulator {

/// Controller and scene as a device would have them after the reports of `options`.
struct ControlSetup {
  device::LoopConfig config;
  core::Scene scene;
};

/// @throws std::invalid_argument that names what is out of its range
[[nodiscard]] core::Scene make_scene(const torsio::emulator::ClosedLoopOptions& options,
                                     const core::Resolution& resolution);

/// @throws std::invalid_argument that names what is out of its range
[[nodiscard]] ControlSetup make_control_setup(const torsio::emulator::ClosedLoopOptions& options);

/// One tick for each count of the encoder; plant, encoder, hand and delay of the options are not
/// looked at.
/// @param rows as many as counts
/// @throws std::invalid_argument that names what is out of its range
void replay(const torsio::emulator::ClosedLoopOptions& options,
            std::span<const std::uint32_t> counts, std::span<torsio::ReplayRow> rows);

}  // namespace torsio::emulator
