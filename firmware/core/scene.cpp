#include "core/scene.hpp"

#include <utility>
#include <variant>

namespace torsio::core {
namespace {

// A knob that trembles at a surface has not been away from it.
constexpr float kAwayCounts = 4.0F;

/// Inputs of every effect.
struct Moment {
  const Scene& scene;
  const Motion& motion;
  const Resolution& resolution;
  const std::uint64_t& tick;
  SceneState& state;
  std::uint32_t slot;
};

// Code that several effects use is inlined nevertheless: a call would put the moment and the motion
// into memory in every tick.
[[gnu::always_inline]] inline float distance_rad(const Origin& origin, const Moment& now) {
  return offset_rad(now.motion.position_counts, origin, now.resolution.rad_per_count);
}

[[gnu::always_inline]] inline std::uint64_t elapsed_ticks(const Moment& now) {
  return now.tick - now.state.start_tick[now.slot];
}

/// Ticks that a timed effect has played, and its envelope.
struct Playing {
  bool on;
  std::uint32_t ticks;
  float level;
};

Playing playing(const Timing& timing, std::uint64_t elapsed_ticks) {
  if (elapsed_ticks < timing.delay_ticks) return {false, 0, 0.0F};
  const std::uint64_t played = elapsed_ticks - timing.delay_ticks;
  const bool ends = timing.duration_ticks != 0;
  if (ends && played >= timing.duration_ticks) return {false, 0, 0.0F};

  // An endless effect runs on modulo 2^32: phases wrap with it, and its attack is long over.
  const auto ticks = static_cast<std::uint32_t>(played);
  float level = 1.0F;
  if (played < timing.attack_ticks) {
    level = timing.attack_level + timing.attack_rise_per_tick * static_cast<float>(ticks);
  } else if (ends) {
    const std::uint32_t left = timing.duration_ticks - ticks;
    if (left < timing.fade_ticks) {
      level = timing.fade_level + timing.fade_fall_per_tick * static_cast<float>(left);
    }
  }
  return {true, ticks, level};
}

[[gnu::always_inline]] inline float torque_nm(const Wall& wall, const Moment& now) {
  const float depth_rad = -wall.outward * distance_rad(wall.surface, now);
  if (depth_rad <= 0.0F) return 0.0F;
  const float inward_speed_rad_s = -wall.outward * now.motion.speed_rad_s;
  const float push_nm =
      wall.stiffness_nm_per_rad * depth_rad + wall.damping_nm_s_per_rad * inward_speed_rad_s;
  return push_nm > 0.0F ? wall.outward * push_nm : 0.0F;
}

float torque_nm(const EndStops& stops, const Moment& now) {
  return torque_nm(stops.lower, now) + torque_nm(stops.upper, now);
}

float torque_nm(const Spring& spring, const Moment& now) {
  float stretch_rad = distance_rad(spring.rest, now);
  stretch_rad -= clamp_symmetric(stretch_rad, spring.deadband_rad);
  return clamp_symmetric(-spring.stiffness_nm_per_rad * stretch_rad, spring.torque_limit_nm);
}

float torque_nm(const Damper& damper, const Moment& now) {
  const float given_nm_s_per_rad = now.state.damping_share * damper.damping_nm_s_per_rad;
  return clamp_symmetric(-given_nm_s_per_rad * now.motion.speed_rad_s, damper.torque_limit_nm);
}

float torque_nm(const Friction& friction, const Moment& now) {
  float& twist_rad = now.state.twist_rad[now.slot];
  twist_rad = clamp_symmetric(twist_rad + now.motion.delta_rad, friction.reach_rad);
  return -friction.stiffness_nm_per_rad * twist_rad;
}

float torque_nm(const Inertia& inertia, const Moment& now) {
  const float given_kg_m2 = now.state.inertia_share * inertia.inertia_kg_m2;
  return clamp_symmetric(-given_kg_m2 * now.motion.acceleration_rad_s2, inertia.torque_limit_nm);
}

[[gnu::always_inline]] inline float torque_nm(const Constant& constant, const Moment& now) {
  const Playing play = playing(constant.timing, elapsed_ticks(now));
  return play.on ? constant.torque_nm * play.level : 0.0F;
}

[[gnu::always_inline]] inline float torque_nm(const Ramp& ramp, const Moment& now) {
  const Playing play = playing(ramp.timing, elapsed_ticks(now));
  if (!play.on) return 0.0F;
  return (ramp.start_torque_nm + ramp.rise_nm_per_tick * static_cast<float>(play.ticks)) *
         play.level;
}

[[gnu::always_inline]] inline float torque_nm(const Periodic& periodic, const Moment& now) {
  const Playing play = playing(periodic.timing, elapsed_ticks(now));
  if (!play.on) return 0.0F;
  const std::uint32_t phase = periodic.start_phase + periodic.phase_per_tick * play.ticks;
  return periodic.offset_nm +
         periodic.amplitude_nm * play.level * waveform_value(periodic.waveform, phase);
}

float torque_nm(const Detents& detents, const Moment& now) {
  const std::uint32_t phase = pattern_phase(now.motion.position_counts, detents.pattern);
  // From -1/2 to 1/2 of the pitch, 0 in the notch.
  const float pitches = static_cast<float>(static_cast<std::int32_t>(phase)) * 0x1p-32F;
  switch (detents.profile) {
    case DetentProfile::sine:
      return -detents.torque_nm * sin_phase(phase);
    case DetentProfile::linear:
      return -2.0F * detents.torque_nm * pitches;
    case DetentProfile::click:
      return -detents.torque_nm * clamp_symmetric(detents.slope * pitches, 1.0F);
  }
  return 0.0F;
}

/// A value in [-1, 1) for a grain: the finaliser of MurmurHash3, which spreads every input bit.
float grain_value(std::uint32_t grain, std::uint32_t seed) {
  std::uint32_t h = grain * 0x9E3779B9U ^ seed;
  h = (h ^ (h >> 16)) * 0x85EBCA6BU;
  h = (h ^ (h >> 13)) * 0xC2B2AE35U;
  h ^= h >> 16;
  return static_cast<float>(static_cast<std::int32_t>(h)) * 0x1p-31F;
}

float torque_nm(const Texture& texture, const Moment& now) {
  // The middle of the count: a grain's edge must not fall on a rounding error.
  const auto half_counts = static_cast<std::uint64_t>(now.motion.position_counts) * 2 + 1;
  const std::uint64_t turn = (half_counts * (texture.turns_per_count_q64 >> 1)) >> 32;
  const std::uint64_t place = turn * texture.grains_per_turn;
  const auto grain = static_cast<std::uint32_t>(place >> 32);
  const auto phase = static_cast<std::uint32_t>(place);
  switch (texture.grain) {
    case Grain::sine:
      return texture.torque_nm * waveform_value(Waveform::sine, phase);
    case Grain::square:
      return texture.torque_nm * waveform_value(Waveform::square, phase);
    case Grain::triangle:
      return texture.torque_nm * waveform_value(Waveform::triangle, phase);
    case Grain::noise: {
      const std::uint32_t next = grain + 1 == texture.grains_per_turn ? 0 : grain + 1;
      const float here = grain_value(grain, texture.seed);
      const float there = grain_value(next, texture.seed);
      const float share = static_cast<float>(phase >> 8) * 0x1p-24F;
      const float smooth = share * share * (3.0F - 2.0F * share);
      return texture.torque_nm * (here + (there - here) * smooth);
    }
  }
  return 0.0F;
}

float torque_nm(const Curve& curve, const Moment& now) {
  const float last = static_cast<float>(curve.intervals);
  float place = 0.0F;
  if (curve.repeats) {
    const std::uint32_t phase = pattern_phase(now.motion.position_counts, curve.pattern);
    place = static_cast<float>(phase >> 8) * 0x1p-24F * last;
  } else {
    place = distance_rad(curve.pattern.origin, now) * curve.intervals_per_rad;
    place = place < 0.0F ? 0.0F : place > last ? last : place;
  }
  auto interval = static_cast<std::uint32_t>(place);
  if (interval == curve.intervals) --interval;
  const float* point = &now.scene.curve_torque_nm[curve.first_point + interval];
  return point[0] + (point[1] - point[0]) * (place - static_cast<float>(interval));
}

void begin_impact(ImpactState& state, const Impact& impact, float inward_rad_s,
                  std::uint64_t tick) {
  state = {};
  state.ready_tick = tick + impact.rest_ticks;
  if (inward_rad_s < impact.least_speed_rad_s) return;
  state.sine_nm = impact.strength_nm_s_per_rad * inward_rad_s;
  state.pulse_nm = impact.pulse_nm_s_per_rad * inward_rad_s;
}

/// Torque of sine and pulse now, outward.
float knock(ImpactState& state, const Impact& impact, float inward_rad_s) {
  if (state.ticks != 0) {
    state.phase += impact.phase_per_tick;
    state.sine_nm *= impact.decay_per_tick;
  }
  if (state.ticks >= impact.sine_ticks) state.sine_nm = 0.0F;
  if (state.ticks >= impact.pulse_ticks || inward_rad_s <= 0.0F) state.pulse_nm = 0.0F;
  ++state.ticks;
  return clamp_symmetric(state.sine_nm * sin_phase(state.phase) + state.pulse_nm,
                         impact.torque_limit_nm);
}

/// Counts the energy of the last tick, of the torque that the motor certainly gave.
void count_energy(ImpactState& state, const MotorLag& lag, float inward_rad) {
  const float behind_nm = state.push_nm - state.late_nm;
  state.taken_j +=
      state.push_nm * inward_rad - larger(lag.behind_in_tick * behind_nm * inward_rad, 0.0F);
  state.late_nm = state.push_nm - lag.decay * behind_nm;
  if (inward_rad != 0.0F) state.way_rad = inward_rad;
}

/// Allowed part of a push outward: the energy that it has taken, less what the motor still gives
/// after it, if the knob moves on as in the last tick, and a count more.
float bound_push(const ImpactState& state, const MotorLag& lag, float inward_rad,
                 float inward_rad_s, float rad_per_count, float push_nm) {
  if (push_nm * state.way_rad >= 0.0F) return push_nm;  // it takes
  const float tail_j = lag.tail_s * absolute(state.late_nm * inward_rad_s);
  const float motion_rad = absolute(inward_rad) + rad_per_count;
  return clamp_symmetric(push_nm, larger(state.taken_j - tail_j, 0.0F) / motion_rad);
}

/// Its torque, outward. It takes energy from a knob that comes in, and gives some of that back. So
/// nothing can bounce on it for ever.
float ask_push(ImpactState& state, const Impact& impact, const Moment& now, const MotorLag& lag) {
  const float depth_rad = -impact.outward * distance_rad(impact.surface, now);
  const float rad_per_count = now.resolution.rad_per_count;
  if (depth_rad <= 0.0F) {
    const float away_rad = kAwayCounts * rad_per_count;
    if (depth_rad < -away_rad && now.tick >= state.ready_tick) state.ready = true;
    state.sine_nm = state.pulse_nm = 0.0F;
    return 0.0F;
  }
  const float inward_rad_s = -impact.outward * now.motion.speed_rad_s;
  if (state.ready) begin_impact(state, impact, inward_rad_s, now.tick);
  if (state.sine_nm == 0.0F && state.pulse_nm == 0.0F) return 0.0F;
  const float inward_rad = -impact.outward * now.motion.delta_rad;
  count_energy(state, lag, inward_rad);
  return bound_push(state, lag, inward_rad, inward_rad_s, rad_per_count,
                    knock(state, impact, inward_rad_s));
}

/// A switch instead of std::visit: no table of pointers, and the compiler may inline. An empty slot
/// is the variant's first alternative, which no kind matches.
template <std::size_t... Index>
float dispatch(const Effect& effect, const Moment& now, std::index_sequence<Index...>) {
  float result = 0.0F;
  (void)((effect.index() == Index + 1 &&
          (result = torque_nm(*std::get_if<Index + 1>(&effect), now), true)) ||
         ...);
  return result;
}

/// Over all that play of a kind.
template <class Kind>
float sum_of(const Scene* scene, float Kind::* number) {
  float sum = 0.0F;
  for (std::uint32_t i = 0; scene != nullptr && i < scene->active; ++i) {
    const auto* effect = std::get_if<Kind>(&scene->effect[scene->order[i]]);
    if (effect != nullptr) sum += effect->*number;
  }
  return sum;
}

}  // namespace

void restart_effects(SceneState& state, std::uint16_t slots, std::uint64_t tick) {
  for (std::uint8_t slot = 0; slot < kMaxEffects; ++slot) {
    if ((slots >> slot & 1U) == 0) continue;
    state.start_tick[slot] = tick;
    state.twist_rad[slot] = 0.0F;
    state.impact[slot] = {};
  }
}

// All effects but the empty slot and Impact, which is the last.
constexpr auto kSteady = std::make_index_sequence<std::variant_size_v<Effect> - 2>{};

float evaluate_scene(const Scene& scene, SceneState& state, const Motion& motion,
                     const Resolution& resolution, const std::uint64_t& tick) {
  float sum_nm = 0.0F;
  const std::uint8_t* next = scene.order.data();
  for (std::uint32_t left = scene.active; left != 0; --left) {
    const std::uint32_t slot = *next++;
    const Effect* const effect = scene.effect.data() + slot;
    const Moment now{scene, motion, resolution, tick, state, slot};
    sum_nm += dispatch(*effect, now, kSteady);
  }
  return sum_nm;
}

[[gnu::noinline]] std::uint32_t kinds_that_play(const Scene& scene) {
  std::uint32_t kinds = 0;
  for (std::uint32_t i = 0; i < scene.active; ++i) {
    kinds |= 1U << scene.effect[scene.order[i]].index();
  }
  return kinds;
}

float inertia_kg_m2(const Scene* scene) { return sum_of(scene, &Inertia::inertia_kg_m2); }

float damping_nm_s_per_rad(const Scene* scene) {
  return sum_of(scene, &Damper::damping_nm_s_per_rad);
}

float add_impacts(const Scene& scene, SceneState& state, const Motion& motion,
                  const Resolution& resolution, const std::uint64_t& tick, float motor_nm,
                  float gain, const MotorRange& range, const MotorLag& lag) {
  const bool went_on = state.impacts_tick + 1 == tick;
  const auto limited = [&](float asked_nm) {
    return asked_nm < range.low_nm ? range.low_nm : smaller(asked_nm, range.high_nm);
  };
  float told_nm = limited(motor_nm);
  state.knock_nm = 0.0F;
  for (std::uint32_t i = 0; i < scene.active; ++i) {
    const std::uint32_t slot = scene.order[i];
    const auto* impact = std::get_if<Impact>(&scene.effect[slot]);
    if (impact == nullptr) continue;
    ImpactState& own = state.impact[slot];
    if (!went_on) {
      // Meanwhile the knob may have come in: where it begins is no impact.
      own.ready = false;
      own.sine_nm = own.pulse_nm = own.push_nm = 0.0F;
    }
    const Moment now{scene, motion, resolution, tick, state, slot};
    const float push_nm = ask_push(own, *impact, now, lag);
    const float with_it_nm = limited(told_nm + gain * (impact->outward * push_nm));
    const float given_nm = with_it_nm - told_nm;
    own.push_nm = impact->outward * given_nm;
    state.knock_nm += given_nm;
    told_nm = with_it_nm;
  }
  state.impacts_tick = tick;
  return told_nm;
}

float evaluate_inertia(const Scene& scene, SceneState& state, const Motion& motion,
                       const Resolution& resolution, const std::uint64_t& tick) {
  float sum_nm = 0.0F;
  for (std::uint32_t i = 0; i < scene.active; ++i) {
    const std::uint32_t slot = scene.order[i];
    const Moment now{scene, motion, resolution, tick, state, slot};
    if (const auto* inertia = std::get_if<Inertia>(&scene.effect[slot]))
      sum_nm += torque_nm(*inertia, now);
  }
  return sum_nm;
}

float evaluate_timed(const Scene& scene, SceneState& state, const Resolution& resolution,
                     const std::uint64_t& tick) {
  const Motion still{};
  float sum_nm = 0.0F;
  for (std::uint32_t i = 0; i < scene.active; ++i) {
    const std::uint32_t slot = scene.order[i];
    const Effect& effect = scene.effect[slot];
    const Moment now{scene, still, resolution, tick, state, slot};
    if (const auto* constant = std::get_if<Constant>(&effect)) sum_nm += torque_nm(*constant, now);
    if (const auto* ramp = std::get_if<Ramp>(&effect)) sum_nm += torque_nm(*ramp, now);
    if (const auto* periodic = std::get_if<Periodic>(&effect)) sum_nm += torque_nm(*periodic, now);
  }
  return sum_nm;
}

float evaluate_local_model(const LocalModel& model, const SceneState& state, const Motion& motion,
                           const Resolution& resolution) {
  const float stretch_rad =
      offset_rad(motion.position_counts, model.reference, resolution.rad_per_count);
  return model.torque_nm - model.stiffness_nm_per_rad * stretch_rad -
         state.damping_share * model.damping_nm_s_per_rad * motion.speed_rad_s;
}

}  // namespace torsio::core
