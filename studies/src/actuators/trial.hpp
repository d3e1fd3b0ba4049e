/// @file
/// One trial of the comparison: an actuator, a hand and an environment over time.
#pragma once

#include <cstdint>
#include <vector>

#include "actuators/actuator.hpp"
#include "emulator/plant/hand.hpp"

namespace torsio::studies::actuators {

/// One actuator, one hand, one environment.
struct TrialParams {
  Kind kind = Kind::motor_only;
  Parts parts;
  Environment environment;
  emulator::Hand hand = emulator::NoHand{};
  double initial_speed_rad_s = 0.0;
  std::uint32_t counts_per_rev = kDefaultPlant.counts_per_rev;
  std::int64_t period_ns = 1'000'000;  ///< of control, a multiple of step_ns
  std::int64_t step_ns = 20'000;       ///< of the simulation
  std::int64_t duration_ns = 0;
};

/// The state at a control tick, and what was decided there. Torques on the knob unless said.
struct TrialRow {
  double time_s;
  double angle_rad;
  double speed_rad_s;
  double ideal_torque_nm;     ///< of the environment at the true angle
  double desired_torque_nm;   ///< ... at the angle that the encoder shows
  double rendered_torque_nm;  ///< Machine::rendered_torque_nm()
  double hand_torque_nm;
  double motor_torque_nm;    ///< on its shaft
  double motor_load_nm;      ///< that heats the motor
  double brake_torque_nm;    ///< on its shaft
  double brake_capacity_nm;  ///< against motion forward
};

/// @returns one row a tick
/// @throws std::invalid_argument if a parameter is out of its range
[[nodiscard]] std::vector<TrialRow> run_trial(const TrialParams& params);

}  // namespace torsio::studies::actuators
