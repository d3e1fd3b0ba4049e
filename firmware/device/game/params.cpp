#include "device/game/params.hpp"

#include "core/angle.hpp"
#include "core/math.hpp"

namespace torsio::device::game {
namespace {

constexpr float kPi = 0.5F * core::kTwoPi;
// A game that plays nothing for so long lets go of the actuator.
constexpr float kIdleS = 1.0F;
// An open device is read every few milliseconds, by the kernel; a busy host may skip some.
constexpr float kAbandonedS = 0.5F;
// A game at 30 Hz, and a millisecond for its frame on the bus.
constexpr float kFrameMaxS = 0.035F;

float motor_max_nm(const Config& config) {
  return core::smaller(config.actuator.motor_torque_max_nm, config.control.motor_torque_cap_nm);
}

float game_torque_nm(const Config& config) {
  return core::smaller(config.game.torque_max_nm, motor_max_nm(config));
}

/// What this device can render without oscillating when no hand is on it; docs/games.md derives it.
StableLimits make_stable_limits(const Config& config, float period_s) {
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

  StableLimits most;
  most.quantised = 2.0F * actuator.knob_coulomb_nm / count_rad;
  most.stiffness = core::smaller(root * root, most.quantised);
  const float filter_s = 2.0F / (core::kTwoPi * config.control.speed_bandwidth_hz);
  most.damping = 0.25F * kPi * inertia / (filter_s + delay_s);
  most.inertia = 0.5F * inertia;
  most.bristle = dry * dry;
  return most;
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
  scale.axis_per_count_q32 = static_cast<std::int64_t>(((std::uint64_t{2 * kFull} * 36'000) << 32) /
                                                       (range * config.actuator.counts_per_rev));
  scale.silence_ticks = core::round_to_u32(config.game.silence_s / resolution.period_s);
  scale.abandoned_ticks = core::round_to_u32(kAbandonedS / resolution.period_s);
  scale.allowed = config.game.enabled == protocol::Toggle::on;
  return scale;
}

ForceParams make_force_params(const Config& config, std::uint32_t period_ns,
                              protocol::Personality personality) {
  const float period_s = core::make_resolution(config.actuator.counts_per_rev, period_ns).period_s;
  const auto at_least_one = [](std::uint32_t ticks) { return ticks == 0 ? 1U : ticks; };
  ForceParams params;
  const bool dial = personality == protocol::Personality::dial;
  params.allowed = config.game.enabled == protocol::Toggle::on && !dial;
  params.torque_max_nm = game_torque_nm(config);
  params.most = make_stable_limits(config, period_s);
  params.end_rad = config.game.range_deg * (core::kTwoPi / 720.0F);
  params.end_stiffness = core::smaller(config.game.end_stiffness_nm_per_rad, params.most.stiffness);
  params.blend_ticks = at_least_one(core::round_to_u32(config.game.blend_s / period_s));
  params.release_ticks = at_least_one(core::round_to_u32(config.control.passive_ramp_s / period_s));
  params.soft_ticks = params.release_ticks;
  if (config.game.join_updates == protocol::Toggle::on) {
    params.frame_max_ticks = core::round_to_u32(kFrameMaxS / period_s);
  }
  params.idle_ticks = at_least_one(core::round_to_u32(kIdleS / period_s));
  // -T sin(n angle) is in its notch as stiff as n T.
  const auto detents = static_cast<float>(config.game.dial_detents);
  params.detents = {dial,
                    core::make_pattern(0, std::uint64_t{config.game.dial_detents} << 32,
                                       config.actuator.counts_per_rev),
                    core::smaller(core::smaller(config.game.dial_torque_nm, motor_max_nm(config)),
                                  params.most.stiffness / detents),
                    params.soft_ticks};
  return params;
}

}  // namespace torsio::device::game
