#include "actuators/trial.hpp"

#include <cmath>
#include <numbers>

#include "emulator/plant/require.hpp"

namespace torsio::studies::actuators {
namespace {

double environment_torque_nm(const Environment& environment, double angle_rad) {
  const double depth_rad = angle_rad - environment.angle_rad;
  if (!environment.both_ways && depth_rad <= 0.0) return 0.0;
  return -environment.stiffness_nm_per_rad * depth_rad;
}

}  // namespace

std::vector<TrialRow> run_trial(const TrialParams& params) {
  require(params.counts_per_rev > 0, "actuator: counts_per_rev must be > 0");
  require(params.step_ns > 0 && params.period_ns > 0 && params.period_ns % params.step_ns == 0,
          "actuator: period_ns must be a multiple of step_ns, both > 0");
  require(params.duration_ns >= 0, "actuator: duration_ns must be >= 0");
  require(std::isfinite(params.environment.stiffness_nm_per_rad) &&
              params.environment.stiffness_nm_per_rad >= 0.0 &&
              std::isfinite(params.environment.angle_rad) &&
              std::isfinite(params.initial_speed_rad_s),
          "actuator: stiffness, angle and speed must be finite, the stiffness >= 0");

  Machine machine(machine_params(params.kind, params.parts), params.hand, params.step_ns);
  MachineState start;
  start.speed_rad_s = {params.initial_speed_rad_s, params.initial_speed_rad_s};
  machine.set_state(start);
  LawOf law(params.kind, params.parts, params.environment, params.counts_per_rev, params.period_ns);
  const double rad_per_count = 2.0 * std::numbers::pi / params.counts_per_rev;
  const auto counts = [&](double angle_rad) {
    return static_cast<std::int64_t>(std::floor(angle_rad / rad_per_count));
  };

  const std::int64_t ticks = params.duration_ns / params.period_ns;
  std::vector<TrialRow> rows;
  rows.reserve(static_cast<std::size_t>(ticks));
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    const MachineState& state = machine.state();
    const double angle_rad = state.angle_rad[0];
    require(std::isfinite(angle_rad), "actuator: the simulation diverged; take a smaller step");
    const std::int64_t knob_counts = counts(angle_rad);
    const double desired_nm =
        environment_torque_nm(params.environment, static_cast<double>(knob_counts) * rad_per_count);
    rows.push_back({1e-9 * static_cast<double>(state.time_ns), angle_rad, state.speed_rad_s[0],
                    environment_torque_nm(params.environment, angle_rad), desired_nm,
                    machine.rendered_torque_nm(), machine.hand_torque_nm(), state.motor_torque_nm,
                    law.motor_load_nm(state), state.brake_torque_nm,
                    state.brake_forward_capacity_nm});
    machine.set_command(
        law({knob_counts, counts(state.angle_rad[1]), machine.hand_torque_nm(), desired_nm}));
    for (std::int64_t at_ns = 0; at_ns < params.period_ns; at_ns += params.step_ns) machine.step();
  }
  return rows;
}

}  // namespace torsio::studies::actuators
