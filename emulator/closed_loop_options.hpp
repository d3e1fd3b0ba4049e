/// @file
/// Inputs of a closed loop of controller and plant.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "emulator/beginnings.hpp"
#include "emulator/encoder.hpp"
#include "emulator/plant/hand.hpp"
#include "emulator/plant/plant.hpp"
#include "protocol/codec.hpp"
#include "protocol/effects.hpp"
#include "protocol/reports.hpp"

namespace torsio::emulator {

/// An effect of a scene as it would travel to the device.
using EffectReport = protocol::EffectReport;

struct ClosedLoopOptions {
  /// 1,000 to 1e9; a device may have min_control_period_ns to max_control_period_ns.
  std::int64_t control_period_ns = protocol::emulated_control_period_ns;
  std::uint32_t delay_ticks = 0;  ///< commands act so many ticks late, at most 1000
  protocol::ActuatorConfig actuator{};
  protocol::ControlConfig control{};
  protocol::ShaftConfig shaft{};
  /// The board's beliefs about a plant with electrics; by default the truth.
  std::optional<protocol::BoardConfig> board{};
  PlantParams plant{};
  std::uint64_t sensor_seed = 0;  ///< of the current sensor's noise
  EncoderParams encoder{};
  Hand hand = NoHand{};
  std::optional<PlantState> initial{};   ///< where the plant begins, if not at rest at 0
  std::vector<EffectReport> scene{};     ///< all of it plays from the first tick on; at most 16
  std::vector<float> curve_torque_nm{};  ///< the pool that curves read; at most 1024 points
  std::optional<SpinUp> spin_up{};
  std::uint64_t first_tick = 0;  ///< the controller's own count; effects began when it was 0
  std::int64_t step_ns = Plant::kStepNs;  ///< of the plant, > 0; never longer than a control period
  MakeStepper make_stepper = make_exact_stepper;
};

/// @returns the state of a plant that begins so
/// @throws std::invalid_argument that names what is out of its range
[[nodiscard]] PlantState state_of(const InitialState& initial);

/// Adds a report: a configuration, an effect of the scene, or points of its curves. It is rounded
/// and checked as on its way to a device.
/// @returns false if it is none of these, or damaged
[[nodiscard]] bool take_report(const protocol::ReportBytes& report, ClosedLoopOptions& options);

}  // namespace torsio::emulator
