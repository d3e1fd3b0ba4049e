#include "device/prepare.hpp"

#include <cstdint>
#include <tuple>

#include "core/angle.hpp"
#include "protocol/registry.hpp"

namespace torsio::device {
namespace {

using core::Resolution;
using protocol::field_index;
using protocol::Status;
using protocol::Verdict;

static_assert(protocol::max_effects == core::kMaxEffects);
static_assert(protocol::curve_pool_points == core::kCurvePoolPoints);

// After so many time constants a thousandth is left of an impact's sine.
constexpr float kDecays = 7.0F;
// A knob that passes a count in this time at most has a speed that is worth a knock.
constexpr float kSlowestCountS = 2e-3F;
// Faster than a hand taps. A sooner one is no impact but a chattering knob.
constexpr float kBetweenImpactsS = 0.05F;

float per_tick(float change, std::uint32_t ticks) {
  return ticks == 0 ? 0.0F : change / static_cast<float>(ticks);
}

/// The nearest float, as static_cast gives it. The compiler's library takes the way over double
/// precision, which the microcontroller does not have.
float to_float(std::uint64_t value) {
  if (value <= 0xFFFFFFFFU) return static_cast<float>(static_cast<std::uint32_t>(value));
  // Up to 40 bits: the last eight only decide whether there is anything behind the others.
  const auto upper = static_cast<std::uint32_t>(value >> 8);
  return static_cast<float>(upper | ((value & 0xFFU) != 0 ? 1U : 0U)) * 256.0F;
}

/// Within an endless effect nothing fades; within a finite one attack and fade must have room.
/// @param duration, fade the report's fields, to name
[[gnu::noinline]] Verdict prepare_timing(const protocol::Timing& in, const Resolution& r,
                                         core::Timing& timing, std::uint8_t duration,
                                         std::uint8_t fade) {
  timing.delay_ticks = core::round_to_u32(in.delay_s / r.period_s);
  timing.duration_ticks = core::round_to_u32(in.duration_s / r.period_s);
  timing.attack_ticks = core::round_to_u32(in.attack_s / r.period_s);
  timing.fade_ticks = core::round_to_u32(in.fade_s / r.period_s);
  if (in.duration_s > 0.0F) {
    // Shorter than half a tick would round to "endless".
    if (timing.duration_ticks == 0) timing.duration_ticks = 1;
    const std::uint64_t envelope =
        static_cast<std::uint64_t>(timing.attack_ticks) + timing.fade_ticks;
    if (envelope > timing.duration_ticks) {
      return {Status::inconsistent, duration};
    }
  } else if (in.fade_s > 0.0F) {
    return {Status::inconsistent, fade};
  }
  timing.attack_level = in.attack_level;
  timing.attack_rise_per_tick = per_tick(1.0F - in.attack_level, timing.attack_ticks);
  timing.fade_level = in.fade_level;
  timing.fade_fall_per_tick = per_tick(1.0F - in.fade_level, timing.fade_ticks);
  return {};
}

template <class Report>
Verdict prepare_timing(const protocol::Timing& in, const Resolution& r, core::Timing& timing) {
  return prepare_timing(in, r, timing, field_index<Report>("duration_s"),
                        field_index<Report>("fade_s"));
}

core::Wall make_wall(std::int64_t angle_turns_q32, bool solid_above, float stiffness, float damping,
                     const Resolution& r) {
  return {core::make_origin(angle_turns_q32, r.counts_per_rev), solid_above ? -1.0F : 1.0F,
          stiffness, damping};
}

// One for each effect of protocol::EffectReports.

Verdict prepare_effect(const protocol::Wall& in, const Resolution& r, core::Effect& effect) {
  effect = make_wall(in.angle_turns_q32, in.side == protocol::Side::above, in.stiffness_nm_per_rad,
                     in.damping_nm_s_per_rad, r);
  return {};
}

Verdict prepare_effect(const protocol::Spring& in, const Resolution& r, core::Effect& effect) {
  effect = core::Spring{core::make_origin(in.angle_turns_q32, r.counts_per_rev),
                        in.stiffness_nm_per_rad, in.deadband_rad, in.torque_limit_nm};
  return {};
}

Verdict prepare_effect(const protocol::Damper& in, const Resolution&, core::Effect& effect) {
  effect = core::Damper{in.damping_nm_s_per_rad, in.torque_limit_nm};
  return {};
}

Verdict prepare_effect(const protocol::Friction& in, const Resolution&, core::Effect& effect) {
  effect = core::Friction{in.stiffness_nm_per_rad, in.torque_nm / in.stiffness_nm_per_rad};
  return {};
}

Verdict prepare_effect(const protocol::Inertia& in, const Resolution&, core::Effect& effect) {
  effect = core::Inertia{in.inertia_kg_m2, in.torque_limit_nm};
  return {};
}

Verdict prepare_effect(const protocol::Constant& in, const Resolution& r, core::Effect& effect) {
  core::Constant constant{in.torque_nm, {}};
  const Verdict verdict = prepare_timing<protocol::Constant>(in.timing, r, constant.timing);
  if (verdict.ok()) effect = constant;
  return verdict;
}

Verdict prepare_effect(const protocol::Ramp& in, const Resolution& r, core::Effect& effect) {
  if (in.timing.duration_s <= 0.0F) {
    return {Status::inconsistent, field_index<protocol::Ramp>("duration_s")};
  }
  core::Ramp ramp{in.start_torque_nm, 0.0F, {}};
  const Verdict verdict = prepare_timing<protocol::Ramp>(in.timing, r, ramp.timing);
  if (!verdict.ok()) return verdict;
  ramp.rise_nm_per_tick =
      per_tick(in.end_torque_nm - in.start_torque_nm, ramp.timing.duration_ticks);
  effect = ramp;
  return {};
}

Verdict prepare_effect(const protocol::Periodic& in, const Resolution& r, core::Effect& effect) {
  const float cycles_per_tick = in.frequency_hz * r.period_s;
  if (cycles_per_tick > 0.5F) {
    return {Status::out_of_range, field_index<protocol::Periodic>("frequency_hz")};
  }
  core::Periodic periodic;
  const Verdict verdict = prepare_timing<protocol::Periodic>(in.timing, r, periodic.timing);
  if (!verdict.ok()) return verdict;
  periodic.waveform = static_cast<core::Waveform>(in.waveform);
  periodic.amplitude_nm = in.amplitude_nm;
  periodic.offset_nm = in.offset_nm;
  // A whole turn is no phase at all, and 2^32 does not fit.
  periodic.start_phase = in.phase_turns < 1.0F ? core::round_to_u32(in.phase_turns * 0x1p32F) : 0;
  periodic.phase_per_tick = core::round_to_u32(cycles_per_tick * 0x1p32F);
  effect = periodic;
  return {};
}

Verdict prepare_effect(const protocol::Detents& in, const Resolution& r, core::Effect& effect) {
  if (in.per_turn_q32 > static_cast<std::uint64_t>(r.counts_per_rev) << 31) {
    return {Status::out_of_range, field_index<protocol::Detents>("per_turn_q32")};
  }
  effect =
      core::Detents{core::make_pattern(in.angle_turns_q32, in.per_turn_q32, r.counts_per_rev),
                    in.torque_nm, static_cast<core::DetentProfile>(in.profile), 2.0F / in.width};
  return {};
}

Verdict prepare_effect(const protocol::EndStops& in, const Resolution& r, core::Effect& effect) {
  if (in.upper_turns_q32 < in.lower_turns_q32) {
    return {Status::inconsistent, field_index<protocol::EndStops>("upper_turns_q32")};
  }
  effect = core::EndStops{
      make_wall(in.lower_turns_q32, false, in.stiffness_nm_per_rad, in.damping_nm_s_per_rad, r),
      make_wall(in.upper_turns_q32, true, in.stiffness_nm_per_rad, in.damping_nm_s_per_rad, r)};
  return {};
}

Verdict prepare_effect(const protocol::Texture& in, const Resolution& r, core::Effect& effect) {
  if (in.grains_per_turn > r.counts_per_rev / 2) {
    return {Status::out_of_range, field_index<protocol::Texture>("grains_per_turn")};
  }
  core::Texture texture;
  texture.turns_per_count_q64 =
      core::make_pattern(0, std::uint64_t{1} << 32, r.counts_per_rev).cycles_per_count_q64;
  texture.grains_per_turn = in.grains_per_turn;
  texture.torque_nm = in.torque_nm;
  texture.grain = static_cast<core::Grain>(in.grain);
  texture.seed = in.seed;
  effect = texture;
  return {};
}

Verdict prepare_effect(const protocol::Curve& in, const Resolution& r, core::Effect& effect) {
  if (in.first_point + in.points > protocol::curve_pool_points) {
    return {Status::inconsistent, field_index<protocol::Curve>("points")};
  }
  if (in.span_turns_q32 * r.counts_per_rev < std::uint64_t{1} << 33) {
    return {Status::out_of_range, field_index<protocol::Curve>("span_turns_q32")};
  }
  core::Curve curve;
  curve.pattern =
      core::make_pattern_of_span(in.angle_turns_q32, in.span_turns_q32, r.counts_per_rev);
  curve.intervals = static_cast<std::uint16_t>(in.points - 1);
  const float span_rad = to_float(in.span_turns_q32) * (core::kTwoPi * 0x1p-32F);
  curve.intervals_per_rad = static_cast<float>(curve.intervals) / span_rad;
  curve.first_point = in.first_point;
  curve.repeats = in.ends == protocol::Ends::repeat;
  effect = curve;
  return {};
}

Verdict prepare_effect(const protocol::Impact& in, const Resolution& r, core::Effect& effect) {
  const float cycles_per_tick = in.frequency_hz * r.period_s;
  if (cycles_per_tick > 0.5F) {
    return {Status::out_of_range, field_index<protocol::Impact>("frequency_hz")};
  }
  core::Impact impact;
  impact.surface = core::make_origin(in.angle_turns_q32, r.counts_per_rev);
  impact.outward = in.side == protocol::Side::above ? -1.0F : 1.0F;
  impact.strength_nm_s_per_rad = in.strength_nm_s_per_rad;
  impact.phase_per_tick = core::round_to_u32(cycles_per_tick * 0x1p32F);
  impact.decay_per_tick = core::exp_negative(r.period_s / in.decay_s);
  impact.sine_ticks = core::round_to_u32(kDecays * in.decay_s / r.period_s);
  impact.pulse_nm_s_per_rad = in.pulse_nm_s_per_rad;
  impact.pulse_ticks = core::round_to_u32(in.pulse_s / r.period_s);
  impact.torque_limit_nm = in.torque_limit_nm;
  impact.least_speed_rad_s = r.rad_per_count / kSlowestCountS;
  impact.rest_ticks = core::round_to_u32(kBetweenImpactsS / r.period_s);
  effect = impact;
  return {};
}

}  // namespace

template <class EffectReport>
Verdict prepare(const EffectReport& in, const Resolution& r, core::Effect& effect) {
  return prepare_effect(in, r, effect);
}

/// Makes the compiler generate prepare() for every effect of a list here, because this file is
/// compiled by the microcontroller's rules. Nobody calls all().
template <class List>
struct Prepared;
template <class... EffectReport>
struct Prepared<std::tuple<EffectReport...>> {
  static auto all() { return std::tuple{&prepare<EffectReport>...}; }
};
template struct Prepared<protocol::EffectReports>;

core::LocalModel prepare(const protocol::LocalModel& in, const Resolution& r) {
  return {in.torque_nm, core::make_origin(in.angle_turns_q32, r.counts_per_rev),
          in.stiffness_nm_per_rad, in.damping_nm_s_per_rad};
}

core::Excitation prepare(const protocol::Excitation& in, const Resolution& r) {
  core::Excitation out;
  out.duration_ticks = core::round_to_u32(in.duration_s / r.period_s);
  out.travel_counts = core::round_to_u32(in.travel_rad / r.rad_per_count);
  out.speed_limit_rad_s = in.speed_limit_rad_s;
  out.torque_limit_nm = in.torque_limit_nm;
  out.motor_command_nm = in.motor_command_nm;
  out.brake_command_nm = in.brake_command_nm;
  out.ramp_ticks = core::round_to_u32(in.ramp_s / r.period_s);
  out.share_per_tick = per_tick(1.0F, out.ramp_ticks);
  out.sine_nm = in.sine_nm;
  const auto step = [&](float frequency_hz) {
    return core::round_to_u32(frequency_hz * r.period_s * 0x1p32F);
  };
  const std::uint32_t begin = step(in.sine_begin_hz);
  const auto growth = static_cast<std::int64_t>(step(in.sine_end_hz)) - begin;
  out.sine_step_q64 = static_cast<std::uint64_t>(begin) << 32;
  // A frequency that stands as it is divides nothing. Phases count modulo a turn, and so does what
  // grows by more than half a turn in a single tick.
  if (growth != 0 && out.duration_ticks != 0) {
    const std::int64_t half = growth * (std::int64_t{1} << 31) / out.duration_ticks;
    out.sine_growth_q64 = static_cast<std::int64_t>(static_cast<std::uint64_t>(half) * 2);
  }
  out.still_ticks = core::round_to_u32(protocol::excitation_still_s / r.period_s);
  out.servo_stiffness_nm_per_rad = in.stiffness_nm_per_rad;
  out.servo_damping_nm_s_per_rad = in.damping_nm_s_per_rad;
  out.servo_rad_s = in.servo_rad_s;
  // In two parts of 32 bits: the boards have no conversion to 64 that is not made of doubles.
  const float counts = in.servo_rad_s * r.period_s / r.rad_per_count;
  const auto whole = static_cast<std::int32_t>(counts);
  const auto rest_q30 = static_cast<std::int32_t>((counts - static_cast<float>(whole)) * 0x1p30F);
  out.servo_counts_q32 = std::int64_t{whole} * (std::int64_t{1} << 32) + std::int64_t{rest_q30} * 4;
  return out;
}

}  // namespace torsio::device
