/// @file
/// Bounded experiments: commands of motor and brake that go past scene and law, for a device that
/// measures itself.
#pragma once

#include <cstdint>

#include "core/motion.hpp"
#include "core/partition.hpp"

namespace torsio::core {

/// One stretch of an experiment; prepared, in ticks.
struct Excitation {
  std::uint32_t duration_ticks = 0;
  std::int64_t travel_counts = 0;
  float speed_limit_rad_s = 0;
  float torque_limit_nm = 0;
  float motor_command_nm = 0;
  float brake_command_nm = 0;
  std::uint32_t ramp_ticks = 0;
  float share_per_tick = 1;  // of the ramp
  float sine_nm = 0;
  std::uint64_t sine_step_q64 = 0;   // of the phase at the beginning, 2^-64 turn in a tick
  std::int64_t sine_growth_q64 = 0;  // of that step in a tick
  float servo_stiffness_nm_per_rad = 0;
  float servo_damping_nm_s_per_rad = 0;
  float servo_rad_s = 0;
  std::int64_t servo_counts_q32 = 0;  // its reference moves so far in a tick, 2^-32 counts
  // A servo that pulls with all it may and sees a knob stand still ends after so many.
  std::uint32_t still_ticks = ~std::uint32_t{0};
};

enum class ExcitationEnd : std::uint8_t { none, over, out_of_bounds };

struct ExcitationState {
  Excitation now;
  ExcitationEnd end = ExcitationEnd::none;
  bool on = false;
  std::uint32_t ticks = 0;
  std::int64_t begin_counts = 0;
  std::int64_t reference_q32 = 0;  // the servo's, from `begin_counts`
  std::uint64_t sine_phase_q64 = 0;
  std::uint64_t sine_step_q64 = 0;
  std::int64_t still_counts = 0;    // where the knob stands while a servo pulls with all it may
  std::uint32_t still_ticks = 0;    // for so long by now
  float from_motor_command_nm = 0;  // both where they were when this stretch began
  float from_brake_command_nm = 0;
  float motor_command_nm = 0;  // both where the ramp is
  float brake_command_nm = 0;
};

/// Begins a stretch: from the place of the present one, or at rest if none is on.
void begin_excitation(ExcitationState& state, const Excitation& next, std::int64_t position_counts);

/// One tick. At its end and out of its bounds both commands are zero and `state.end` says why.
/// @param limits the law's row is not looked at, the largest torques are
Shares excite(ExcitationState& state, const PartitionParams& limits, const Motion& motion,
              float rad_per_count);

}  // namespace torsio::core
