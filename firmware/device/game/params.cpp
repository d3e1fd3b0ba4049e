#include "device/game/params.hpp"

#include "core/angle.hpp"
#include "core/math.hpp"

namespace torsio::device::game {
namespace {

// A game that plays nothing for so long lets go of the actuator.
constexpr float kIdleS = 1.0F;
// An open device is read every few milliseconds, by the kernel; a busy host may skip some.
constexpr float kAbandonedS = 0.5F;
// A game at 30 Hz that is late by a third of its frame.
constexpr float kFrameMaxS = 0.045F;
// A share of the torque that the player's settings leave.
constexpr float kHitShare = 0.1F;
constexpr float kHoldCountsMax = 2e9F;

}  // namespace

GameScale make_game_scale(const Config& config, std::uint32_t period_ns) {
  const core::Resolution resolution =
      core::make_resolution(config.actuator.counts_per_rev, period_ns);
  GameScale scale;
  scale.period_s = resolution.period_s;
  scale.torque_nm = game_torque_max_nm(config);
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
  scale.reversed = config.game.reversed == protocol::Toggle::on;
  const protocol::GameConfig& game = config.game;
  const std::uint8_t waves = game.waves_gain_percent;
  const std::uint8_t constants = game.constants_gain_percent;
  scale.gain_percent = {0,
                        constants,
                        constants,
                        waves,
                        waves,
                        waves,
                        waves,
                        waves,
                        game.springs_gain_percent,
                        game.dampers_gain_percent,
                        game.inertias_gain_percent,
                        game.frictions_gain_percent};
  scale.own_is_felt = (game.own_spring_percent | game.own_damper_percent |
                       game.own_inertia_percent | game.own_friction_percent) != 0;
  const float stiffness = core::smaller(
      share_of(game.own_spring_percent) * scale.stiffness_nm_per_rad, scale.most.stiffness);
  if (stiffness > 0.0F) {
    scale.hold_counts = 1 + core::round_to_u32(core::smaller(
                                kHoldCountsMax, config.actuator.knob_coulomb_nm / stiffness /
                                                    resolution.rad_per_count));
  }
  return scale;
}

namespace {

OwnFeel make_own_feel(const GameScale& scale, const protocol::GameConfig& game) {
  OwnFeel own;
  own.stiffness = share_of(game.own_spring_percent) * scale.stiffness_nm_per_rad;
  own.damping = share_of(game.own_damper_percent) * scale.torque_nm / scale.speed_rad_s;
  own.inertia = share_of(game.own_inertia_percent) * scale.torque_nm / scale.acceleration_rad_s2;
  own.friction_nm = share_of(game.own_friction_percent) * scale.torque_nm;
  if (own.friction_nm > 0.0F) own.bristle = bristle_nm_per_rad(scale.most, own.friction_nm);
  own.is_felt = scale.own_is_felt;
  return own;
}

}  // namespace

ForceParams make_force_params(const Config& config, std::uint32_t period_ns) {
  const float period_s = core::make_resolution(config.actuator.counts_per_rev, period_ns).period_s;
  const auto at_least_one = [](std::uint32_t ticks) { return ticks == 0 ? 1U : ticks; };
  ForceParams params;
  params.allowed = config.game.enabled == protocol::Toggle::on;
  params.torque_max_nm = game_torque_max_nm(config);
  params.most = make_stable_limits(config, period_s);
  params.end_rad = config.game.range_deg * (core::kTwoPi / 720.0F);
  params.end_stiffness = core::smaller(config.game.end_stiffness_nm_per_rad, params.most.stiffness);
  params.blend_ticks = at_least_one(core::round_to_u32(config.game.blend_s / period_s));
  params.release_ticks = at_least_one(core::round_to_u32(config.control.passive_ramp_s / period_s));
  params.soft_ticks = params.release_ticks;
  if (config.game.join_updates == protocol::Toggle::on) {
    params.frame_max_ticks = core::round_to_u32(kFrameMaxS / period_s);
    params.hit_nm = kHitShare * config.game.gain * params.torque_max_nm;
  }
  params.idle_ticks = at_least_one(core::round_to_u32(kIdleS / period_s));
  params.own = make_own_feel(make_game_scale(config, period_ns), config.game);
  return params;
}

}  // namespace torsio::device::game
