#include "device/game/effect_torque.hpp"

#include "core/math.hpp"

namespace torsio::device::game {
namespace {

/// Amplitude of a timed force: attack and fade are lines that end at the peak. Where they overlap
/// their distances from the peak add up, so that nothing jumps.
float amplitude_nm(const TimedForce& force, std::uint64_t elapsed, std::uint32_t duration_ticks) {
  const auto ticks = static_cast<std::uint32_t>(elapsed);
  float level_nm = force.peak_nm;
  if (elapsed < force.attack_ticks) {
    level_nm += force.attack_nm - force.attack_fall_per_tick * static_cast<float>(ticks);
  }
  if (duration_ticks != 0) {
    const std::uint32_t left = duration_ticks - ticks;
    if (left < force.fade_ticks) {
      level_nm += force.fade_nm - force.fade_fall_per_tick * static_cast<float>(left);
    }
  }
  return level_nm > 0.0F ? level_nm : 0.0F;
}

}  // namespace

float timed_nm(const TimedForce& force, std::uint64_t elapsed, std::uint32_t duration_ticks,
               std::uint32_t wave_phase) {
  const auto ticks = static_cast<std::uint32_t>(elapsed);  // an endless wave's phase wraps with it
  float shape = 0.0F;
  if (force.periodic) {
    const std::uint32_t phase = force.start_phase + force.phase_per_tick * ticks + wave_phase;
    shape = core::waveform_value(force.waveform, phase);
  } else {
    shape = force.start;
    if (force.slope_per_tick != 0.0F) shape += force.slope_per_tick * static_cast<float>(ticks);
  }
  return amplitude_nm(force, elapsed, duration_ticks) * shape + force.offset_nm;
}

float proportional_nm(const Condition& condition, float value, float share) {
  const float beyond = value - condition.offset;
  if (beyond > condition.dead_band) {
    const float nm = share * condition.positive_gain * (beyond - condition.dead_band);
    return -core::clamp_symmetric(nm, condition.positive_limit_nm);
  }
  if (beyond < -condition.dead_band) {
    const float nm = share * condition.negative_gain * (beyond + condition.dead_band);
    return -core::clamp_symmetric(nm, condition.negative_limit_nm);
  }
  return 0.0F;
}

float slip_nm(const Condition& condition, const core::Motion& motion, float period_s, float share,
              float& slip_rad) {
  const float speed = motion.speed_rad_s - condition.offset;
  if (condition.dead_band > 0.0F && core::absolute(speed) <= condition.dead_band) {
    slip_rad = 0.0F;
    return 0.0F;
  }
  slip_rad += motion.delta_rad;
  if (condition.offset != 0.0F) slip_rad -= condition.offset * period_s;
  const float gain = condition.positive_gain * share;
  if (gain <= 0.0F) return 0.0F;
  const float forward_rad = condition.positive_limit_nm / gain;
  const float backward_rad = condition.negative_limit_nm / gain;
  if (slip_rad > forward_rad) slip_rad = forward_rad;
  if (slip_rad < -backward_rad) slip_rad = -backward_rad;
  return -gain * slip_rad;
}

}  // namespace torsio::device::game
