#include "device/game/effect_block.hpp"

#include <utility>

#include "core/math.hpp"

namespace torsio::device::game {
namespace {

constexpr std::uint8_t kAxisX = 1 << 0;
constexpr std::uint8_t kDirection = 1 << 1;

core::Waveform waveform(EffectType type) {
  switch (type) {
    case EffectType::square:
      return core::Waveform::square;
    case EffectType::triangle:
      return core::Waveform::triangle;
    case EffectType::sawtooth_up:
      return core::Waveform::sawtooth_up;
    case EffectType::sawtooth_down:
      return core::Waveform::sawtooth_down;
    default:
      return core::Waveform::sine;
  }
}

/// Share of a force that acts along the knob. A direction is where the force comes from, clockwise
/// from north: 90 degrees is a push from the right, to smaller angles. A program that knows of only
/// one axis may leave its direction zero and mean that axis. With a vibration, as Linux does for
/// the rumble of gamepads, the thing in the hand shall shake.
float direction_share(const Block& block) {
  const SetEffect& effect = block.effect;
  const bool has_direction = (effect.enable & kDirection) != 0;
  const bool names_axis = (effect.enable & kAxisX) != 0;
  const bool may_leave_it_zero = names_axis || is_periodic(block.type);
  if (!has_direction || (may_leave_it_zero && effect.direction[0] == 0)) return -1.0F;
  const auto phase = static_cast<std::uint32_t>((std::uint64_t{effect.direction[0]} << 32) / kFull);
  return -core::sin_phase(phase);
}

float per_tick(float change, std::uint32_t ticks) {
  return ticks == 0 ? 0.0F : change / static_cast<float>(ticks);
}

/// A repetition of less than two ticks cannot be told from a slower one; it is held there.
std::uint32_t phase_per_tick(std::uint16_t period_ms, std::uint32_t period_ns) {
  if (period_ms == 0) return 0;
  const std::uint64_t wave_ns = std::uint64_t{period_ms} * 1'000'000;
  if (wave_ns < std::uint64_t{2} * period_ns) return 0x80000000U;
  return static_cast<std::uint32_t>(((std::uint64_t{period_ns} << 32) + wave_ns / 2) / wave_ns);
}

/// Linux 7.2 and 7.3 take the negative saturation for a signed number. Values in the upper half of
/// 0 to 0xFFFF come folded down, so that full comes as 0: a spring that pushes to one side only. A
/// value that is exactly the fold of the positive saturation means the same.
std::uint16_t negative_saturation(const Block& block) {
  const std::uint16_t positive = block.condition.positive_saturation;
  const std::uint16_t negative = block.condition.negative_saturation;
  if (!block.may_be_folded) return negative;
  // Two numbers of the program come as the same level.
  for (const int asked : {2 * positive + 1, 2 * positive + 2}) {
    if (negative == (asked <= kFull ? asked : 2 * kFull + 1 - asked)) return positive;
  }
  return negative;
}

void prepare_condition(const Block& block, const GameScale& scale, PreparedEffect& effect) {
  const SetCondition& set = block.condition;
  float full = scale.half_range_rad;
  float gain = scale.stiffness_nm_per_rad;
  switch (block.type) {
    case EffectType::spring:
      effect.metric = Metric::angle;
      break;
    case EffectType::damper:
      effect.metric = Metric::speed;
      full = scale.speed_rad_s;
      gain = scale.torque_nm / full;
      break;
    case EffectType::inertia:
      effect.metric = Metric::acceleration;
      full = scale.acceleration_rad_s2;
      gain = scale.torque_nm / full;
      break;
    default:
      effect.metric = Metric::slip;
      full = scale.speed_rad_s;
      break;
  }
  // A spring may push away, it gives back what it took. A negative damper, inertia or friction
  // would set the knob in motion by itself.
  const auto coefficient = [&](std::int16_t value) {
    return effect.metric != Metric::angle && value < 0 ? 0.0F : level(value);
  };
  Condition& condition = effect.condition;
  condition.offset = level(set.offset) * full;
  condition.dead_band = level(set.dead_band) * full;
  condition.positive_gain = coefficient(set.positive_coefficient) * gain;
  condition.negative_gain = coefficient(set.negative_coefficient) * gain;
  condition.positive_limit_nm = level(set.positive_saturation) * scale.torque_nm;
  condition.negative_limit_nm = level(negative_saturation(block)) * scale.torque_nm;
  if (effect.metric != Metric::slip) return;

  // Dry friction holds its torque at any speed; the coefficient is a share of the full torque.
  const auto held_nm = [&](float share, float most_nm) {
    return core::smaller(share * scale.torque_nm, most_nm);
  };
  condition.positive_limit_nm =
      held_nm(coefficient(set.positive_coefficient), condition.positive_limit_nm);
  condition.negative_limit_nm =
      held_nm(coefficient(set.negative_coefficient), condition.negative_limit_nm);
  const float most_nm =
      core::larger(condition.positive_limit_nm, condition.negative_limit_nm) * effect.gain;
  condition.positive_gain = 0.0F;
  condition.negative_gain = 0.0F;
  if (most_nm <= 0.0F) return;
  condition.positive_gain = bristle_nm_per_rad(scale.most, most_nm) / effect.gain;
}

/// The same for a knob that goes the other way.
void mirror(PreparedEffect& effect) {
  if (effect.metric == Metric::time) {
    effect.gain = -effect.gain;
    return;
  }
  Condition& condition = effect.condition;
  condition.offset = -condition.offset;
  std::swap(condition.positive_limit_nm, condition.negative_limit_nm);
  // A bristle has one stiffness.
  if (effect.metric != Metric::slip) std::swap(condition.positive_gain, condition.negative_gain);
}

}  // namespace

PreparedEffect prepare_effect(const Block& block, const GameScale& scale, std::uint32_t period_ns) {
  const auto ticks = [period_ns](std::uint16_t ms) {
    return static_cast<std::uint32_t>((std::uint64_t{ms} * 1'000'000 + period_ns / 2) / period_ns);
  };
  const SetEffect& set = block.effect;
  PreparedEffect effect;
  effect.delay_ticks = ticks(set.start_delay_ms);
  effect.duration_ticks = is_endless(block) ? 0 : ticks(set.duration_ms);
  effect.gain = level(set.gain) * scale.gain *
                share_of(scale.gain_percent[static_cast<std::size_t>(block.type)]);
  if (!is_timed(block.type)) {
    prepare_condition(block, scale, effect);
    if (scale.reversed) mirror(effect);
    return effect;
  }
  effect.gain *= direction_share(block);
  if (scale.reversed) mirror(effect);

  TimedForce& force = effect.timed;
  if (block.type == EffectType::constant) {
    force.peak_nm = core::absolute(level(block.constant.magnitude)) * scale.torque_nm;
    force.start = block.constant.magnitude < 0 ? -1.0F : 1.0F;
  } else if (block.type == EffectType::ramp) {
    const float start = level(block.ramp.start);
    const float end = level(block.ramp.end);
    const float peak = core::larger(core::absolute(start), core::absolute(end));
    force.peak_nm = peak * scale.torque_nm;
    force.start = peak > 0.0F ? start / peak : 0.0F;
    // Without an end it never gets anywhere.
    force.slope_per_tick =
        peak > 0.0F ? per_tick((end - start) / peak, effect.duration_ticks) : 0.0F;
  } else {
    force.periodic = true;
    force.waveform = waveform(block.type);
    force.peak_nm = level(block.periodic.magnitude) * scale.torque_nm;
    force.offset_nm = level(block.periodic.offset) * scale.torque_nm;
    force.start_phase =
        static_cast<std::uint32_t>((std::uint64_t{block.periodic.phase} << 32) / kFull);
    force.phase_per_tick = phase_per_tick(block.periodic.period_ms, period_ns);
    if (block.periodic.period_ms == 0) force.peak_nm = 0.0F;
  }
  if (block.has_envelope) {
    const SetEnvelope& envelope = block.envelope;
    force.attack_ticks = ticks(envelope.attack_ms);
    force.attack_nm = level(envelope.attack_level) * scale.torque_nm - force.peak_nm;
    force.attack_fall_per_tick = per_tick(force.attack_nm, force.attack_ticks);
    force.fade_ticks = ticks(envelope.fade_ms);
    force.fade_nm = level(envelope.fade_level) * scale.torque_nm - force.peak_nm;
    force.fade_fall_per_tick = per_tick(force.fade_nm, force.fade_ticks);
  }
  return effect;
}

}  // namespace torsio::device::game
