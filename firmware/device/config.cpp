#include "device/config.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "device/wall_parts.hpp"
#include "protocol/registry.hpp"

namespace torsio::device {

using protocol::ActuatorConfig;
using protocol::ShaftConfig;

namespace {

// No hand turns a knob faster, and no small motor without load gets there in a moment.
constexpr float kFastestRadS = 2000.0F;
constexpr std::uint32_t kLeastJumpCounts = 16;

/// Counts in one period that no knob can make, but noise and a loose cable can. Never more than a
/// quarter of a turn.
std::uint32_t jump_limit(const core::Resolution& resolution, std::uint32_t counts_per_rev) {
  const std::uint32_t fastest =
      core::round_to_u32(kFastestRadS * resolution.period_s / resolution.rad_per_count);
  const std::uint32_t limit = fastest > kLeastJumpCounts ? fastest : kLeastJumpCounts;
  return limit < counts_per_rev / 4 ? limit : counts_per_rev / 4;
}

void hold_low(LoopConfig& loop, Trust trust) {
  if (trust == Trust::all) return;
  core::PartitionParams& partition = loop.controller.partition;
  const ActuatorLimits low = held_low(
      {partition.motor_torque_max_nm, partition.brake_torque_max_nm, loop.speed_limit_rad_s});
  partition.motor_torque_max_nm = low.motor_torque_max_nm;
  partition.brake_torque_max_nm = low.brake_torque_max_nm;
  loop.passive_brake_nm = core::smaller(loop.passive_brake_nm, low.brake_torque_max_nm);
  loop.speed_limit_rad_s = low.speed_limit_rad_s;
  if (trust == Trust::experiments) return;
  loop.controller.excitation = partition;
  loop.excitation_speed_limit_rad_s = loop.speed_limit_rad_s;
}

std::array<core::ShaftKnee, core::kMostKnees> knees_of(const ShaftConfig& shaft) {
  return {{{shaft.knee_1_rad, shaft.knee_1_nm_per_rad},
           {shaft.knee_2_rad, shaft.knee_2_nm_per_rad},
           {shaft.knee_3_rad, shaft.knee_3_nm_per_rad},
           {shaft.knee_4_rad, shaft.knee_4_nm_per_rad}}};
}

core::BrakeParams make_brake_params(const ActuatorConfig& actuator, core::Law law, float period_s) {
  const float drag_nm = core::traits(law).counts_drag ? actuator.brake_drag_nm : 0.0F;
  float floor_nm = actuator.brake_torque_min_nm;
  // A floor above a drag that is known is a torque that the brake does not hold.
  if (core::traits(law).knows_brake && drag_nm > 0.0F) floor_nm = core::smaller(floor_nm, drag_nm);
  core::BrakeParams params =
      core::make_brake_params(actuator.brake_time_constant_s, period_s, floor_nm, drag_nm);
  const float release_s = actuator.brake_release_time_constant_s;
  if (release_s > 0.0F) params.release_decay = core::decay_of(release_s, period_s);
  params.play_nm = actuator.brake_hysteresis_nm;
  return params;
}

}  // namespace

LoopConfig make_loop_config(const Config& config, std::uint32_t period_ns, Trust trust) {
  const protocol::ActuatorConfig& actuator = config.actuator;
  const protocol::ControlConfig& control = config.control;
  const core::Resolution resolution = core::make_resolution(actuator.counts_per_rev, period_ns);
  const float period_s = resolution.period_s;
  static_assert(core::kLaws.size() == protocol::Enumerators<protocol::Law>::names.size());
  const auto law = static_cast<core::Law>(control.law);

  LoopConfig loop{};  // GCC 14 takes the braces left out for a value that nobody uses
  loop.controller.motion = core::make_motion_params(
      resolution, actuator.counter_bits, actuator.encoder_reversed == protocol::Toggle::on,
      control.speed_bandwidth_hz);
  loop.controller.brake = make_brake_params(actuator, law, period_s);
  loop.controller.shaft =
      core::make_shaft_params(actuator.spring_stiffness_nm_per_rad, knees_of(config.shaft),
                              actuator.brake_inertia_kg_m2, period_s, actuator.knob_coulomb_nm);
  const ActuatorLimits limits = configured_limits(actuator, control);
  loop.controller.partition = {law, control.beta, limits.motor_torque_max_nm,
                               limits.brake_torque_max_nm};
  loop.speed_limit_rad_s = limits.speed_limit_rad_s;
  loop.controller.bound =
      core::make_bound_params(core::stable_stiffness(wall_parts(actuator, control, resolution)),
                              stable_damping(actuator, control, period_s), resolution,
                              loop.controller.partition.motor_torque_max_nm,
                              actuator.knob_inertia_kg_m2, actuator.knob_coulomb_nm);
  // No slower than the speed of one count.
  const float full_rad_s =
      core::larger(0.1F, core::kTwoPi * control.speed_bandwidth_hz * resolution.rad_per_count);
  loop.controller.assist = core::make_assist_params(
      control.free_assist_nm, actuator.knob_coulomb_nm, actuator.brake_drag_nm, full_rad_s,
      resolution.rad_per_count, actuator.brake_hysteresis_nm,
      loop.controller.shaft.middle().brake_side.countered_nm);
  loop.controller.motor_lag = core::make_motor_lag(actuator.motor_time_constant_s, period_s);
  loop.controller.slew = {control.motor_slew_nm_per_s * period_s};
  loop.watchdog_ticks = control.autonomous == protocol::Toggle::on
                            ? 0
                            : core::round_to_u32(control.watchdog_s / period_s) + 1;
  loop.passive_ramp_ticks = core::round_to_u32(control.passive_ramp_s / period_s);
  loop.let_go_ticks =
      core::round_to_u32(core::smaller(protocol::let_go_s, control.passive_ramp_s) / period_s);
  loop.passive_brake_nm =
      core::smaller(control.passive_brake_nm, loop.controller.partition.brake_torque_max_nm);
  loop.jump_limit_counts =
      static_cast<std::int32_t>(jump_limit(resolution, actuator.counts_per_rev));
  // The main loop, with USB and the hardware watchdog in it, lives on the last twentieth.
  loop.tick_budget_ns = period_ns - period_ns / 20;
  loop.turn_counts = static_cast<std::int32_t>(actuator.counts_per_rev);
  loop.index_counts = config.index_counts;
  loop.controller.excitation = loop.controller.partition;
  loop.excitation_speed_limit_rad_s = loop.speed_limit_rad_s;
  hold_low(loop, trust);
  return loop;
}

float motor_max_nm(const Config& config) {
  return configured_limits(config.actuator, config.control).motor_torque_max_nm;
}

protocol::Verdict check_consistent(const ActuatorConfig& config) {
  using protocol::field_index;
  if (config.brake_torque_min_nm > config.brake_torque_max_nm) {
    return {protocol::Status::inconsistent, field_index<ActuatorConfig>("brake_torque_min_nm")};
  }
  // The counter must not wrap within the largest step that is not a fault.
  if (config.counter_bits < 32 && config.counts_per_rev / 2 >= (1U << (config.counter_bits - 1))) {
    return {protocol::Status::inconsistent, field_index<ActuatorConfig>("counter_bits")};
  }
  return {};
}

/// The torque of the shaft's spring grows all the way.
protocol::Verdict check_consistent(const ShaftConfig& config) {
  constexpr std::array kKneeFields{protocol::field_index<ShaftConfig>("knee_1_rad"),
                                   protocol::field_index<ShaftConfig>("knee_2_rad"),
                                   protocol::field_index<ShaftConfig>("knee_3_rad"),
                                   protocol::field_index<ShaftConfig>("knee_4_rad")};
  const auto knees = knees_of(config);
  float last_rad = 0.0F;
  bool ended = false;
  for (std::size_t i = 0; i < knees.size(); ++i) {
    const core::ShaftKnee& knee = knees[i];
    if (knee.twist_rad == 0.0F) {
      ended = true;
      continue;
    }
    if (ended || knee.twist_rad <= last_rad)
      return {protocol::Status::inconsistent, kKneeFields[i]};
    if (!(knee.stiffness_nm_per_rad > 0.0F)) {
      const auto stiffness_field = static_cast<std::uint8_t>(kKneeFields[i] + 1);
      return {protocol::Status::inconsistent, stiffness_field};
    }
    last_rad = knee.twist_rad;
  }
  return {};
}

/// Both are out of line, so that tools/stack_bound.py finds their calls through a pointer.
[[gnu::noinline]] protocol::Verdict check_rules(const protocol::BoardConfig& report,
                                                const protocol::Configurations& others,
                                                WiringRule rule) {
  const std::optional<PinConflict> conflict = rule(report, others.actuator.encoder_index_pin);
  if (!conflict) return {};
  return {protocol::Status::inconsistent, conflict->field};
}

[[gnu::noinline]] protocol::Verdict check_rules(const ActuatorConfig& report,
                                                const protocol::Configurations& others,
                                                WiringRule rule) {
  const protocol::Verdict verdict = check_consistent(report);
  if (!verdict.ok() || !rule(others.board, report.encoder_index_pin)) return verdict;
  return {protocol::Status::inconsistent,
          protocol::field_index<ActuatorConfig>("encoder_index_pin")};
}

float torque_step_nm(const ActuatorConfig& config) {
  const float wanted_nm =
      1.5F * (config.motor_torque_max_nm + config.brake_torque_max_nm) / 32767.0F;
  float decade_nm = 1e-6F;
  for (;;) {
    if (decade_nm >= wanted_nm) return decade_nm;
    if (2.0F * decade_nm >= wanted_nm) return 2.0F * decade_nm;
    if (5.0F * decade_nm >= wanted_nm) return 5.0F * decade_nm;
    decade_nm *= 10.0F;
  }
}

}  // namespace torsio::device
