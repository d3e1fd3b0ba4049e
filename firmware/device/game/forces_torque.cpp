// Forces: the torque of what plays.
#include "core/math.hpp"
#include "device/game/effect_torque.hpp"
#include "device/game/forces.hpp"

namespace torsio::device::game {
namespace {

constexpr std::size_t at(Metric metric) { return static_cast<std::size_t>(metric); }

}  // namespace

/// Several springs are as stiff as their sum, so they share the stable stiffness.
void Forces::share_out() {
  std::array<float, kMetrics> sum{};
  const OwnFeel& own = params_.own;
  if (active_ == 0) sum[at(Metric::angle)] = own.stiffness;
  sum[at(Metric::speed)] = own.damping;
  sum[at(Metric::acceleration)] = own.inertia;
  sum[at(Metric::slip)] = own.bristle;
  float slip_limit_nm = own.friction_nm;
  for (std::uint8_t i = 0; i < active_; ++i) {
    const PreparedEffect& effect = effect_[order_[i]];
    const Condition& condition = effect.condition;
    const float gain = effect.gain * gain_;
    sum[at(effect.metric)] += gain * core::larger(core::absolute(condition.positive_gain),
                                                  core::absolute(condition.negative_gain));
    if (effect.metric == Metric::slip) {
      slip_limit_nm +=
          gain * core::larger(condition.positive_limit_nm, condition.negative_limit_nm);
    }
  }
  const auto share = [](float wanted, float most) { return wanted > most ? most / wanted : 1.0F; };
  share_[at(Metric::angle)] = share(sum[at(Metric::angle)], params_.most.stiffness);
  share_[at(Metric::speed)] = share(sum[at(Metric::speed)], params_.most.damping);
  share_[at(Metric::acceleration)] = share(sum[at(Metric::acceleration)], params_.most.inertia);
  share_[at(Metric::slip)] =
      share(sum[at(Metric::slip)] * slip_limit_nm * slip_limit_nm, params_.most.bristle);
}

/// The walls at the ends of the axis, and the player's own feel. They act in every game.
/// Its gains and pauses do not scale them.
float Forces::own_nm(const core::Motion& motion, float period_s) {
  const float inside = core::clamp_symmetric(motion_angle_, params_.end_rad);
  float nm = core::clamp_symmetric(params_.end_stiffness * (inside - motion_angle_),
                                   params_.torque_max_nm);
  const OwnFeel& own = params_.own;
  const auto against = [&](float gain, Metric metric, float value) {
    if (gain != 0.0F) nm -= gain * share_[at(metric)] * value;
  };
  if (active_ == 0) against(own.stiffness, Metric::angle, motion_angle_);
  against(own.damping, Metric::speed, motion.speed_rad_s);
  against(own.inertia, Metric::acceleration, motion.acceleration_rad_s2);
  if (own.friction_nm != 0.0F) {
    const Condition friction{.positive_gain = own.bristle,
                             .positive_limit_nm = own.friction_nm,
                             .negative_limit_nm = own.friction_nm};
    nm += slip_nm(friction, motion, period_s, share_[at(Metric::slip)], own_slip_rad_);
  }
  if (walls_soft_left_ != 0) {
    nm *= static_cast<float>(params_.soft_ticks - walls_soft_left_) /
          static_cast<float>(params_.soft_ticks);
    --walls_soft_left_;
  }
  return nm;
}

/// The delay is over.
bool Forces::pass_delay(const PreparedEffect& effect, Playing& play, std::uint64_t now) {
  if (play.sounding) return true;
  if (now - play.start < effect.delay_ticks) return false;
  play.start += effect.delay_ticks;
  play.sounding = true;
  changed_ = true;
  return true;
}

/// At the end of a loop the next one begins.
/// @returns false after the last
bool Forces::pass_loops(const PreparedEffect& effect, Playing& play, std::uint64_t now) {
  const std::uint64_t elapsed = now - play.start;
  if (effect.duration_ticks == 0 || elapsed < effect.duration_ticks) return true;
  const std::uint64_t loops =
      elapsed < std::uint64_t{2} * effect.duration_ticks ? 1 : elapsed / effect.duration_ticks;
  if (play.loops_left != kEndlessLoops) {
    if (loops >= play.loops_left) return false;
    play.loops_left = static_cast<std::uint8_t>(play.loops_left - loops);
  }
  play.start += loops * effect.duration_ticks;
  return true;
}

float Forces::effect_nm(const PreparedEffect& effect, Playing& play, const core::Motion& motion,
                        float period_s, std::uint64_t now) {
  const float share = share_[at(effect.metric)];
  switch (effect.metric) {
    case Metric::time: {
      core::Fade& late = play.updates.late;
      if (late.nm != 0.0F) late.step();
      return effect.gain *
                 timed_nm(effect.timed, now - play.start, effect.duration_ticks, play.wave_phase) +
             late.nm;
    }
    case Metric::angle: {
      // The hand may be anywhere when a game begins to centre.
      float gain = effect.gain;
      if (play.soft_left != 0) {
        gain *= static_cast<float>(params_.soft_ticks - play.soft_left) /
                static_cast<float>(params_.soft_ticks);
        --play.soft_left;
      }
      return gain * proportional_nm(effect.condition, motion_angle_, share);
    }
    case Metric::speed:
      return effect.gain * proportional_nm(effect.condition, motion.speed_rad_s, share);
    case Metric::acceleration:
      return effect.gain * proportional_nm(effect.condition, motion.acceleration_rad_s2, share);
    case Metric::slip:
      // A softer bristle bends further and holds as much.
      return effect.gain * slip_nm(effect.condition, motion, period_s, share, play.slip_rad);
  }
  return 0.0F;
}

/// Sum of what plays. What has ended stops.
float Forces::effects_nm(const core::Motion& motion, float period_s, std::uint64_t now) {
  float sum_nm = 0.0F;
  for (std::uint8_t i = 0; i < active_;) {
    const std::uint8_t block = order_[i];
    const PreparedEffect& effect = effect_[block];
    Playing& play = play_[block];
    float nm = 0.0F;
    if (!paused_ && pass_delay(effect, play, now)) {
      if (!pass_loops(effect, play, now)) {
        stop(block);  // the next one moves into its place
        continue;
      }
      nm = effect_nm(effect, play, motion, period_s, now);
    }
    block_nm_[block].store(nm * gain_, std::memory_order_relaxed);
    sum_nm += nm;
    ++i;
  }
  return sum_nm;
}

/// A game may ask for more than there is. The monitor reports it.
float Forces::within_cap_nm(float asked_nm) {
  const float nm = core::clamp_symmetric(asked_nm, params_.torque_max_nm);
  const float size_nm = core::absolute(asked_nm);
  if (size_nm > asked_most_nm_.load(std::memory_order_relaxed)) {
    asked_most_nm_.store(size_nm, std::memory_order_relaxed);
  }
  if (nm != asked_nm) {
    clipped_ticks_.store(clipped_ticks() + 1, std::memory_order_relaxed);
  }
  return nm;
}

/// Goes on from the last torque when something has changed.
float Forces::blend_nm(float sum_nm) {
  if (changed_) {
    residual_.begin(last_nm_ - sum_nm, gently_ ? params_.release_ticks : params_.blend_ticks);
    changed_ = false;
    gently_ = false;
  }
  if (fading()) {
    residual_.step();
    // The rounding of the last step is not worth a tick.
    if (core::absolute(residual_.nm) < 1e-3F * residual_.step_nm) residual_.nm = 0.0F;
  }
  return sum_nm + residual_.nm;
}

float Forces::torque_nm(const core::Motion& motion, const core::Resolution& resolution,
                        std::uint64_t tick) {
  if (changed_) share_out();
  motion_angle_ = core::offset_rad(motion.position_counts, {}, resolution.rad_per_count);
  float sum_nm = within_cap_nm(effects_nm(motion, resolution.period_s, time(tick)) * gain_);
  if (walls_ && (params_.end_stiffness != 0.0F || params_.own.is_felt)) {
    sum_nm =
        core::clamp_symmetric(sum_nm + own_nm(motion, resolution.period_s), params_.torque_max_nm);
  }
  last_nm_ = blend_nm(sum_nm);
  shown_nm_.store(last_nm_, std::memory_order_relaxed);
  return last_nm_;
}

}  // namespace torsio::device::game
