#include "device/config.hpp"

#include <cstdint>
#include <optional>

#include "protocol/board_pins.hpp"
#include "protocol/registry.hpp"

namespace torsio::device {

using protocol::ActuatorConfig;

constexpr float kPi = 0.5F * core::kTwoPi;
// A game that plays nothing for so long lets go of the actuator.
constexpr float kIdleS = 1.0F;

// The law's number on the wire is its number in the core.
static_assert(static_cast<int>(protocol::Law::paper) == static_cast<int>(core::Law::paper));
static_assert(static_cast<int>(protocol::Law::compensated) ==
              static_cast<int>(core::Law::compensated));
static_assert(static_cast<int>(protocol::Law::parallel) == static_cast<int>(core::Law::parallel));
static_assert(static_cast<int>(protocol::Law::motor_only) ==
              static_cast<int>(core::Law::motor_only));

namespace {

float motor_max_nm(const Config& config) {
  return core::smaller(config.actuator.motor_torque_max_nm, config.control.motor_torque_cap_nm);
}

float game_torque_nm(const Config& config) {
  return core::smaller(config.game.torque_max_nm, motor_max_nm(config));
}

/// What this device can render without oscillating when no hand is on it; docs/games.md derives it.
game::StableLimits make_stable_limits(const Config& config, float period_s) {
  const protocol::ActuatorConfig& actuator = config.actuator;
  const float torque_nm = core::larger(game_torque_nm(config), 1e-6F);
  // Half a period of hold, one period until the power stage has the command, and the motor.
  const float delay_s = 1.5F * period_s + actuator.motor_time_constant_s;
  const float inertia = actuator.knob_inertia_kg_m2;
  const float count_rad = core::kTwoPi / static_cast<float>(actuator.counts_per_rev);
  // Dry friction takes 4 f / (pi a) from an oscillation of amplitude a, for a torque of k a that
  // does not exceed the cap.
  const float dry = (4.0F / kPi) * actuator.knob_coulomb_nm * core::square_root(inertia) / delay_s;
  const float held = dry / torque_nm;
  const float root =
      0.5F *
      (held + core::square_root(held * held + 4.0F * actuator.knob_viscous_nm_s_per_rad / delay_s));

  game::StableLimits most;
  most.quantised = 2.0F * actuator.knob_coulomb_nm / count_rad;
  most.stiffness = core::smaller(root * root, most.quantised);
  const float filter_s = 2.0F / (core::kTwoPi * config.control.speed_bandwidth_hz);
  most.damping = 0.25F * kPi * inertia / (filter_s + delay_s);
  most.inertia = 0.5F * inertia;
  most.bristle = dry * dry;
  return most;
}

game::ForceParams make_force_params(const Config& config, float period_s) {
  const auto at_least_one = [](std::uint32_t ticks) { return ticks == 0 ? 1U : ticks; };
  game::ForceParams params;
  params.allowed = config.game.enabled == protocol::Toggle::on;
  params.torque_max_nm = game_torque_nm(config);
  params.most = make_stable_limits(config, period_s);
  params.blend_ticks = at_least_one(core::round_to_u32(config.game.blend_s / period_s));
  params.release_ticks = at_least_one(core::round_to_u32(config.control.passive_ramp_s / period_s));
  params.idle_ticks = at_least_one(core::round_to_u32(kIdleS / period_s));
  return params;
}

}  // namespace

GameScale make_game_scale(const Config& config, std::uint32_t period_ns) {
  const core::Resolution resolution =
      core::make_resolution(config.actuator.counts_per_rev, period_ns);
  GameScale scale;
  scale.period_s = resolution.period_s;
  scale.torque_nm = game_torque_nm(config);
  scale.gain = config.game.gain;
  scale.half_range_rad = config.game.range_deg * (core::kTwoPi / 720.0F);
  scale.stiffness_nm_per_rad = scale.torque_nm / scale.half_range_rad * config.game.spring_gain;
  scale.speed_rad_s = config.game.speed_full_rad_s;
  scale.acceleration_rad_s2 = config.game.acceleration_full_rad_s2;
  scale.most = make_stable_limits(config, resolution.period_s);
  // Both ends are 2 * 32767 apart. In hundredths of a degree the division stays in integers.
  const std::uint64_t range = core::round_to_u32(config.game.range_deg * 100.0F);
  scale.axis_per_count_q32 = static_cast<std::int64_t>(
      ((std::uint64_t{2 * game::kFull} * 36'000) << 32) / (range * config.actuator.counts_per_rev));
  scale.silence_ticks = core::round_to_u32(config.game.silence_s / resolution.period_s);
  return scale;
}

LoopConfig make_loop_config(const Config& config, std::uint32_t period_ns) {
  const protocol::ActuatorConfig& actuator = config.actuator;
  const protocol::ControlConfig& control = config.control;
  const core::Resolution resolution = core::make_resolution(actuator.counts_per_rev, period_ns);
  const float period_s = resolution.period_s;
  const float motor_nm = motor_max_nm(config);
  const float brake_max_nm =
      core::smaller(actuator.brake_torque_max_nm, control.brake_torque_cap_nm);
  const auto law = static_cast<core::Law>(control.law);

  LoopConfig loop;
  loop.controller.motion = core::make_motion_params(
      resolution, actuator.counter_bits, actuator.encoder_reversed == protocol::Toggle::on,
      control.speed_bandwidth_hz);
  // Only the compensated law counts the drag: with the paper's the drag's help is what keeps the
  // motor from overcompensating (docs/theory.md).
  loop.controller.brake = core::make_brake_params(
      actuator.brake_time_constant_s, period_s, actuator.brake_torque_min_nm,
      law == core::Law::compensated ? actuator.brake_drag_nm : 0.0F);
  loop.controller.spring_stiffness_nm_per_rad = actuator.spring_stiffness_nm_per_rad;
  loop.controller.partition = {law, control.beta, motor_nm, brake_max_nm};
  loop.controller.limits = {control.motor_slew_nm_per_s * period_s};
  loop.watchdog_ticks = control.autonomous == protocol::Toggle::on
                            ? 0
                            : core::round_to_u32(control.watchdog_s / period_s) + 1;
  loop.passive_ramp_ticks = core::round_to_u32(control.passive_ramp_s / period_s);
  loop.passive_brake_nm = core::smaller(control.passive_brake_nm, brake_max_nm);
  if (control.speed_limit_rad_s > 0.0F) loop.speed_limit_rad_s = control.speed_limit_rad_s;
  // A quarter of a turn in one period: no hand does that, a lost encoder signal does.
  loop.jump_limit_counts = static_cast<std::int32_t>(actuator.counts_per_rev / 4);
  loop.game = make_force_params(config, period_s);
  return loop;
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

protocol::Verdict check_consistent(const protocol::BoardConfig& config) {
  const std::optional<protocol::PinConflict> conflict = protocol::find_pin_conflict(config);
  if (!conflict) return {};
  return {protocol::Status::inconsistent, conflict->field};
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
