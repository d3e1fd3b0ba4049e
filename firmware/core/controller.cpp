#include "core/controller.hpp"

#include <limits>

#include "core/swings.hpp"

namespace torsio::core {
namespace {

/// The sensor's inertia, none while the brake slides. When it is known again it has the knob's
/// speed. A piece of a bent shaft is chosen anew.
void choose_brake_side(SoftSensorState& sensor, const ShaftParams& shaft, bool slides,
                       float delta_rad) {
  const BrakeSideParams& known = shaft.middle().brake_side;
  BrakeSideParams& used = sensor.piece.brake_side;
  if (slides) {
    used = {};
  } else if (used.inertia_ratio == 0.0F && known.inertia_ratio != 0.0F) {
    if (shaft.bent()) {
      sensor.slipped_nm = -sensor.piece.stiffness_nm_per_rad * delta_rad;
      sensor.piece.low_nm = std::numeric_limits<float>::infinity();
    } else {
      sensor.slipped_nm = -shaft.middle().stiffness_nm_per_rad * delta_rad;
      used = known;
    }
  }
}

/// Together dampers give as much as the parts can, and less as the bound falls.
[[gnu::noinline]] void bound_dampers(ControllerState& state) {
  const float asked_nm_s_per_rad = state.scene.damping_nm_s_per_rad;
  const float most_nm_s_per_rad = state.bound.share * state.bound.params.damping_nm_s_per_rad;
  state.scene.damping_share =
      asked_nm_s_per_rad > most_nm_s_per_rad ? most_nm_s_per_rad / asked_nm_s_per_rad : 1.0F;
}

/// Out of line: otherwise every tick keeps its values in registers.
[[gnu::noinline]] void watch_sensor(ControllerState& state, const ControllerParams& params,
                                    float capacity_nm) {
  const float spring_nm = state.sensor.spring_torque_nm;
  const float countered_nm = params.shaft.middle().brake_side.countered_nm;
  if (absolute(spring_nm) > state.bound.trust * (capacity_nm + countered_nm)) {
    judge_ringing(state.bound, spring_nm, state.tick);
  }
  if (state.tick % 32 != 0) return;
  const float way = static_cast<float>(state.bound.way);
  const float speed_counts = state.motion.speed_counts_per_tick;
  judge_slide(state.bound, -way * spring_nm - capacity_nm, way * speed_counts, state.tick);
  // Slower than that is every hand.
  if (state.tick % kLookTicks != 0) return;
  choose_brake_side(state.sensor, params.shaft,
                    state.bound.slides >= kSlides || state.bound.doubt > 0,
                    speed_counts * params.motion.resolution.rad_per_count);
  watch_hand(state.bound, static_cast<std::uint32_t>(state.tick));
  bound_dampers(state);
}

/// Senses the spring's torque with a known brake, and keeps the ledger.
/// @param bent of one who knows it beforehand: then asking costs nothing
[[gnu::always_inline]] inline float sense_known_brake(ControllerState& state,
                                                      const ControllerParams& params,
                                                      const Motion& motion, bool bent) {
  const float capacity_nm = model_real_brake(state.brake, params.brake, state.brake_command_nm);
  float spring_nm = 0.0F;
  if (bent) [[unlikely]] {
    spring_nm = sense_bent_shaft<true>(state.sensor, params.shaft, motion.delta_rad, capacity_nm);
  } else {
    spring_nm =
        sense_piece<true>(state.sensor, params.shaft.middle(), motion.delta_rad, capacity_nm);
  }
  // Often enough for what takes 5 ms and more from side to side.
  if (state.tick % 16 == 0) [[unlikely]]
    watch_sensor(state, params, capacity_nm);
  keep_ledger(state.ledger, state.slew.motor_command_nm, state.sensor.spring_torque_nm,
              motion.delta_counts);
  return spring_nm;
}

/// The same by a law that knows no more of the brake than its capacity.
[[gnu::always_inline]] inline float sense_brake(ControllerState& state,
                                                const ControllerParams& params,
                                                const Motion& motion) {
  const float capacity_nm = model_brake(state.brake, params.brake, state.brake_command_nm);
  if (params.shaft.bent()) [[unlikely]] {
    return sense_bent_shaft<false>(state.sensor, params.shaft, motion.delta_rad, capacity_nm);
  }
  return sense_piece<false>(state.sensor, params.shaft.middle(), motion.delta_rad, capacity_nm);
}

/// The end of a swing; out of line, for that is rare. A knob that flickers beyond a held count, and
/// faster than a hand, may have half the friction that was believed.
[[gnu::noinline]] float bound_turn(ControllerState& state, float asked_nm, float timed_nm,
                                   std::int32_t delta_counts) {
  BoundState& bound = state.bound;
  if (judge_swing(bound, state.tick) && hold_count(state.motion) &&
      static_cast<std::uint32_t>(state.tick) - bound.flicker_begin < bound.params.slow_ticks) {
    soften(bound, 0.5F * bound.params.quiet_share);
  }
  return bound_stiffness(state.bound, asked_nm, timed_nm, delta_counts);
}

/// Bounds what the scene asks.
/// @param timed_nm how much of its change does not come from the knob's motion
[[gnu::always_inline]] inline float bound_torque(ControllerState& state, float asked_nm,
                                                 float timed_nm, std::int32_t delta_counts) {
  if (follow_swing(state.bound, delta_counts)) [[unlikely]] {
    return bound_turn(state, asked_nm, timed_nm, delta_counts);
  }
  return bound_stiffness(state.bound, asked_nm, timed_nm, delta_counts);
}

/// Share of virtual inertia. One count switches no more than half the motor, as in a wall. More
/// shakes a knob with few counts, and drives it on.
float inertia_share(const ControllerParams& params, float inertia_kg_m2) {
  const float one_count = params.motion.speed_gain * params.motion.acceleration_scale;
  const float most_kg_m2 = 0.5F * params.partition.motor_torque_max_nm / one_count;
  return inertia_kg_m2 > most_kg_m2 ? most_kg_m2 / inertia_kg_m2 : 1.0F;
}

/// The same of all that plays.
/// @param in_time_nm the part that does not come from the knob's motion
float bound_all(ControllerState& state, const ControllerParams& params, const Plan& plan,
                float asked_nm, float in_time_nm, std::int32_t delta_counts) {
  BoundState& bound = state.bound;
  float timed_nm = in_time_nm - bound.in_time_nm;
  bound.in_time_nm = in_time_nm;
  // Where time takes the scene's torque away, the knob has not moved.
  if (timed_nm != 0.0F) {
    bound.drag_nm = smaller(bound.drag_nm, absolute(asked_nm));
    bound.timed_tick = static_cast<std::uint32_t>(state.tick);
  }
  if (bound.new_scene) {
    bound.drag_nm = timed_nm = 0.0F;
    bound.params = params.bound;
    if (plan.inertia_kg_m2 != 0.0F) {
      const float given = inertia_share(params, plan.inertia_kg_m2);
      add_inertia(bound.params, params.motion.resolution, given * plan.inertia_kg_m2);
    }
    set_share(bound, bound.share);
    begin_scene(bound, asked_nm);
    state.scene.damping_nm_s_per_rad = damping_nm_s_per_rad(plan.scene);
    if (plan.local != nullptr) {
      state.scene.damping_nm_s_per_rad += plan.local->damping_nm_s_per_rad;
    }
    bound_dampers(state);
  }
  return bound_torque(state, asked_nm, timed_nm, delta_counts);
}

/// The shares of the law calibrated, with the drag that is cancelled by now.
[[gnu::always_inline]] inline Shares share_sensed(const ControllerState& state,
                                                  const PartitionParams& params, float desired_nm,
                                                  float spring_nm) {
  const float most_nm = state.bound.trust * (state.brake.coil_nm + state.bound.drag_nm);
  return partition_by(Law::calibrated, params, desired_nm, clamp_number(spring_nm, most_nm));
}

/// The same in free air. Out of line, for a wall's tick shall not pay for it.
[[gnu::noinline]] Shares share_free(ControllerState& state, const ControllerParams& params,
                                    const Motion& motion, float spring_nm) {
  state.bound.drag_nm = end_drag(state.bound.drag_nm, params.assist, motion.delta_rad);
  Shares shares = share_sensed(state, params.partition, 0.0F, spring_nm);
  shares.motor_command_nm =
      clamp_number(shares.motor_command_nm +
                       help_share(state.bound) * assist_torque(params.assist, motion.speed_rad_s),
                   params.partition.motor_torque_max_nm);
  return shares;
}

/// The shares of the law calibrated.
/// @param steady whether the drag follows what is asked; with virtual inertia it does not
[[gnu::always_inline]] inline Shares share_bounded(ControllerState& state,
                                                   const ControllerParams& params,
                                                   const Motion& motion, float desired_nm,
                                                   bool steady, float spring_nm) {
  if (desired_nm == 0.0F) [[unlikely]]
    return share_free(state, params, motion, spring_nm);
  float& drag_nm = state.bound.drag_nm;
  drag_nm = steady ? follow_drag(drag_nm, params.assist, desired_nm, motion.delta_rad)
                   : end_drag(drag_nm, params.assist, motion.delta_rad);
  return share_sensed(state, params.partition, desired_nm, spring_nm);
}

/// Adds the scene's impacts to the motor's share. The brake is too slow for a knock, and only now
/// is the motor's rest known.
Shares share_impacts(ControllerState& state, const ControllerParams& params, const Plan& plan,
                     const Motion& motion, Shares shares) {
  const float most_nm = params.partition.motor_torque_max_nm;
  const MotorRange range = motor_range(state.slew, params.slew, most_nm);
  shares.motor_command_nm =
      add_impacts(*plan.scene, state.scene, motion, params.motion.resolution, state.tick,
                  shares.motor_command_nm, plan.gain, range, params.motor_lag);
  const float told_nm = absolute(shares.motor_command_nm);
  if (state.scene.knock_nm != 0.0F && told_nm >= most_nm) shares.motor_saturated = true;
  return shares;
}

/// What a pipeline makes of the scene's torque.
struct Outcome {
  float desired_nm = 0;
  Shares shares;
};

[[gnu::always_inline]] inline Outcome run_plain(ControllerState& state,
                                                const ControllerParams& params,
                                                const Motion& motion, float scene_nm) {
  const float capacity_nm = model_brake(state.brake, params.brake, state.brake_command_nm);
  const float spring_nm =
      sense_piece<false>(state.sensor, params.shaft.middle(), motion.delta_rad, capacity_nm);
  return {scene_nm, partition(params.partition, scene_nm, spring_nm)};
}

[[gnu::always_inline]] inline Outcome run_bounded(ControllerState& state,
                                                  const ControllerParams& params,
                                                  const Motion& motion, float scene_nm, bool bent) {
  const float spring_nm = sense_known_brake(state, params, motion, bent);
  const float desired_nm = bound_torque(state, scene_nm, 0.0F, motion.delta_counts);
  return {desired_nm, share_bounded(state, params, motion, desired_nm, true, spring_nm)};
}

[[gnu::noinline]] Outcome run_full(ControllerState& state, const ControllerParams& params,
                                   const Plan& plan, const Motion& motion, float scene_nm) {
  const Resolution& resolution = params.motion.resolution;
  const float spring_nm = traits(params.partition.law).knows_brake
                              ? sense_known_brake(state, params, motion, params.shaft.bent())
                              : sense_brake(state, params, motion);
  if (plan.excitation != nullptr) {
    const Shares shares =
        excite(*plan.excitation, params.excitation, motion, resolution.rad_per_count);
    return {shares.motor_command_nm, shares};
  }
  float of_angle_nm = scene_nm;
  float desired_nm = scene_nm;
  if (plan.local != nullptr) {
    const float local_nm = evaluate_local_model(*plan.local, state.scene, motion, resolution);
    desired_nm += local_nm;
    of_angle_nm += local_nm - plan.local->torque_nm;
  }
  desired_nm *= plan.gain;
  if (plan.extra != nullptr) desired_nm += plan.extra->torque_nm(motion, resolution, state.tick);
  if (!is_finite(desired_nm)) return {desired_nm, {}};
  Shares shares;
  if (plan.bounds) {
    float in_time_nm = desired_nm - of_angle_nm;
    if (plan.scene != nullptr) {
      in_time_nm += evaluate_timed(*plan.scene, state.scene, resolution, state.tick);
    }
    // Virtual inertia follows the acceleration, not the angle. So it is not bounded.
    float inertia_nm = 0.0F;
    if (plan.inertia_kg_m2 != 0.0F) {
      inertia_nm =
          plan.gain * evaluate_inertia(*plan.scene, state.scene, motion, resolution, state.tick);
      state.scene.inertia_nm = inertia_nm;
    }
    desired_nm = inertia_nm + bound_all(state, params, plan, desired_nm - inertia_nm, in_time_nm,
                                        motion.delta_counts);
    shares =
        share_bounded(state, params, motion, desired_nm, plan.inertia_kg_m2 == 0.0F, spring_nm);
    state.scene.inertia_share =
        state.bound.trust * state.bound.calm * inertia_share(params, plan.inertia_kg_m2);
  } else {
    shares = partition(params.partition, desired_nm, spring_nm);
  }
  if (plan.impacts) {
    shares = share_impacts(state, params, plan, motion, shares);
    desired_nm += state.scene.knock_nm;
  }
  return {desired_nm, shares};
}

}  // namespace

void change_local_model(ControllerState& state, const ControllerParams& params,
                        const LocalModel* from, const LocalModel* to) {
  BoundState& bound = state.bound;
  if (from == nullptr || to == nullptr) {
    bound.new_scene = true;
    return;
  }
  if (!traits(params.partition.law).bounds || *from == *to) return;
  const Motion here{.position_counts = state.motion.position_counts};
  const auto spring_nm = [&](const LocalModel& model) {
    return evaluate_local_model(model, state.scene, here, params.motion.resolution) -
           model.torque_nm;
  };
  const float change_nm = spring_nm(*to) - spring_nm(*from);
  bound.timed_tick = bound.streamed_tick = static_cast<std::uint32_t>(state.tick);
  if (!bound.bounded) {
    bound.in_time_nm -= change_nm;  // then the next tick sees it as a change in time
  } else if (absolute(change_nm) >= kNearly * absolute(asked_torque(bound))) {
    bound.new_scene = true;
  }
  state.scene.damping_nm_s_per_rad += to->damping_nm_s_per_rad - from->damping_nm_s_per_rad;
  bound_dampers(state);
}

ControllerOutputs control(ControllerState& state, const ControllerParams& params, const Plan& plan,
                          std::uint32_t encoder_count) {
  ControllerOutputs out;
  out.motion = track_motion(state.motion, params.motion, encoder_count);
  float scene_nm = 0.0F;
  if (plan.scene != nullptr) {
    scene_nm =
        evaluate_scene(*plan.scene, state.scene, out.motion, params.motion.resolution, state.tick);
  }
  Outcome outcome;
  if (plan.pipeline == Pipeline::plain) [[likely]] {
    outcome = run_plain(state, params, out.motion, scene_nm);
  } else if (plan.pipeline == Pipeline::bent) {
    outcome = run_bounded(state, params, out.motion, scene_nm, true);
  } else if (plan.pipeline == Pipeline::bounded) {
    outcome = run_bounded(state, params, out.motion, scene_nm, false);
  } else {
    // Field by field: a copy as a whole would put the motion into memory in every tick.
    const Motion& now = out.motion;
    const Motion copy{now.position_counts, now.delta_counts, now.delta_rad, now.speed_rad_s,
                      now.acceleration_rad_s2};
    outcome = run_full(state, params, plan, copy, scene_nm);
  }
  out.brake_capacity_nm = state.brake.capacity_nm;
  out.spring_torque_nm = state.sensor.spring_torque_nm;
  out.numeric_error = !is_finite(outcome.desired_nm);
  out.desired_torque_nm = out.numeric_error ? 0.0F : outcome.desired_nm;
  const Shares shares = out.numeric_error ? Shares{} : outcome.shares;
  out.motor_command_nm = limit_motor(state.slew, params.slew, shares.motor_command_nm);
  out.brake_command_nm = shares.brake_command_nm;
  out.motor_saturated = shares.motor_saturated;
  out.brake_saturated = shares.brake_saturated;

  state.brake_command_nm = out.brake_command_nm;
  ++state.tick;
  return out;
}

}  // namespace torsio::core
