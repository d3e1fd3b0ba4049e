#include "core/controller.hpp"

namespace torsio::core {
namespace {

/// The part of the sensed torque that the motor may take up.
[[gnu::always_inline]] inline float certain_torque(const ControllerState& state,
                                                   const ControllerParams& params,
                                                   float capacity_nm) {
  return state.bound.trust * (capacity_nm + params.shaft.middle().brake_side.countered_nm);
}

/// Out of line: otherwise every tick keeps its values in registers.
[[gnu::noinline]] void watch_sensor(ControllerState& state, const ControllerParams& params) {
  const float spring_nm = state.sensor.spring_torque_nm;
  const float capacity_nm = sensed_capacity(state.brake, params.brake);
  if (absolute(spring_nm) > certain_torque(state, params, capacity_nm)) {
    judge_ringing(state.bound, spring_nm, state.tick);
  }
}

[[gnu::always_inline]] inline void keep_ledger(ControllerState& state,
                                               const ControllerParams& params,
                                               std::int32_t delta_counts) {
  // Often enough for what takes 5 ms and more from side to side.
  if (state.tick % 16 == 0) [[unlikely]]
    watch_sensor(state, params);
  keep_ledger(state.ledger, state.slew.motor_command_nm, state.sensor.spring_torque_nm,
              delta_counts);
}

/// Bounds what the scene asks.
/// @param in_time_nm the part that follows time or does not come from the scene; the knob's motion
/// does not change it
float bound_torque(ControllerState& state, const ControllerParams& params, float asked_nm,
                   float in_time_nm, std::int32_t delta_counts) {
  BoundState& bound = state.bound;
  float timed_nm = in_time_nm - bound.in_time_nm;
  bound.in_time_nm = in_time_nm;
  if (bound.new_scene) {
    timed_nm = asked_nm - asked_torque(bound);
    bound.params = params.bound;
    set_share(bound, bound.share);
  }
  bound.new_scene = false;
  if (follow_swing(bound, delta_counts)) {
    judge_swing(bound, state.tick);
  }
  return bound_stiffness(bound, asked_nm, timed_nm, delta_counts);
}

/// The same at the end of a swing in an ordinary tick, or in a flicker; out of line, for that is
/// rare.
[[gnu::noinline]] float bound_turn(ControllerState& state, const ControllerParams& params,
                                   float asked_nm, std::int32_t delta_counts) {
  keep_ledger(state, params, delta_counts);
  judge_swing(state.bound, state.tick);
  return bound_stiffness(state.bound, asked_nm, 0.0F, delta_counts);
}

/// The ordinary tick of the law calibrated: nothing beside the scene, and nothing of it plays in
/// time.
[[gnu::always_inline]] inline float bound_scene(ControllerState& state,
                                                const ControllerParams& params, float asked_nm,
                                                std::int32_t delta_counts) {
  if (follow_swing(state.bound, delta_counts)) [[unlikely]] {
    return bound_turn(state, params, asked_nm, delta_counts);
  }
  keep_ledger(state, params, delta_counts);
  return bound_stiffness(state.bound, asked_nm, 0.0F, delta_counts);
}

/// Out of line: otherwise every tick keeps its values in registers.
[[gnu::noinline]] float add_overlay(ControllerState& state, const ControllerParams& params,
                                    const Overlay& overlay, const Scene* scene, float scene_nm,
                                    const Motion& motion) {
  const Resolution& resolution = params.motion.resolution;
  if (overlay.ledger) keep_ledger(state, params, motion.delta_counts);
  float desired_nm = scene_nm;
  if (overlay.local != nullptr) {
    desired_nm += evaluate_local_model(*overlay.local, motion, resolution);
  }
  desired_nm *= overlay.gain;
  if (overlay.extra != nullptr) {
    desired_nm += overlay.extra->torque_nm(motion, resolution, state.tick);
  }
  if (!overlay.bounds || !is_finite(desired_nm)) return desired_nm;
  float in_time_nm = desired_nm - scene_nm;
  if (scene != nullptr) in_time_nm += evaluate_timed(*scene, state.scene, resolution, state.tick);
  return bound_torque(state, params, desired_nm, in_time_nm, motion.delta_counts);
}

/// Where the scene asks for nothing, the law calibrated has a share of its own.
[[gnu::always_inline]] inline bool is_free_air(const Overlay& overlay, float desired_nm,
                                               bool shared) {
  return desired_nm == 0.0F && overlay.bounds && !shared;
}

/// The law's shares, with the scene's impacts on top of the motor's. The brake is too slow for a
/// knock, and only now is the motor's rest known.
[[gnu::noinline]] Shares share_with_impacts(ControllerState& state, const ControllerParams& params,
                                            const Overlay& overlay, const Scene& scene,
                                            const Motion& motion, float desired_nm,
                                            float spring_nm) {
  Shares shares;
  if (is_free_air(overlay, desired_nm, false)) {
    shares.motor_command_nm = share_free_air(params.partition, params.assist, spring_nm,
                                             state.brake.coil_nm, motion.speed_rad_s);
  } else {
    shares = partition(params.partition, desired_nm, spring_nm);
  }
  const float most_nm = params.partition.motor_torque_max_nm;
  const MotorRange range = motor_range(state.slew, params.slew, most_nm);
  shares.motor_command_nm = add_impacts(scene, state.scene, motion, params.motion.resolution,
                                        state.tick, shares.motor_command_nm, overlay.gain, range);
  const float told_nm = absolute(shares.motor_command_nm);
  if (state.scene.knock_nm != 0.0F && told_nm >= most_nm) shares.motor_saturated = true;
  return is_finite(shares.motor_command_nm) ? shares : Shares{};
}

/// Senses the spring's torque with a known brake. Inlined like the next function: a call would cost
/// every tick its registers.
/// @returns the part of the torque that the motor may take up
[[gnu::always_inline]] inline float sense_known_brake(ControllerState& state,
                                                      const ControllerParams& params,
                                                      float delta_rad, bool bent) {
  const float capacity_nm = model_real_brake(state.brake, params.brake, state.brake_command_nm);
  const ShaftPiece& middle = params.shaft.middle();
  float spring_nm = 0.0F;
  if (bent) [[unlikely]] {
    spring_nm = sense_bent_shaft<true>(state.sensor, params.shaft, delta_rad, capacity_nm);
  } else {
    spring_nm = sense_piece<true>(state.sensor, middle, delta_rad, capacity_nm);
  }
  return clamp_number(spring_nm, certain_torque(state, params, capacity_nm));
}

[[gnu::always_inline]] inline float sense_brake(ControllerState& state,
                                                const ControllerParams& params, float delta_rad) {
  const float capacity_nm = model_brake(state.brake, params.brake, state.brake_command_nm);
  return sense_piece<false>(state.sensor, params.shaft.middle(), delta_rad, capacity_nm);
}

/// The same of a bent shaft, by a law that knows no more of the brake.
[[gnu::noinline]] float sense_bent(ControllerState& state, const ControllerParams& params,
                                   float delta_rad) {
  const float capacity_nm = model_brake(state.brake, params.brake, state.brake_command_nm);
  return sense_bent_shaft<false>(state.sensor, params.shaft, delta_rad, capacity_nm);
}

/// The spring's torque. Law and shaft say how it is sensed.
[[gnu::always_inline]] inline float sense(ControllerState& state, const ControllerParams& params,
                                          const Overlay& overlay, float delta_rad) {
  if (overlay.ledger) return sense_known_brake(state, params, delta_rad, overlay.bent);
  if (overlay.bent) return sense_bent(state, params, delta_rad);
  return sense_brake(state, params, delta_rad);
}

}  // namespace

ControllerOutputs control(ControllerState& state, const ControllerParams& params,
                          const ControllerInputs& in) {
  ControllerOutputs out;
  out.motion = track_motion(state.motion, params.motion, in.encoder_count);

  const Resolution& resolution = params.motion.resolution;
  float desired_nm = 0.0F;
  if (in.scene != nullptr) {
    desired_nm = evaluate_scene(*in.scene, state.scene, out.motion, resolution, state.tick);
  }
  // The sensor comes after the scene, which has no need of it: one branch for all that is rare.
  float spring_nm = 0.0F;
  Shares shares;
  bool shared = false;  // already, past the law
  if (in.overlay != nullptr) [[unlikely]] {
    if (in.overlay->only_bounds) {
      spring_nm = sense_known_brake(state, params, out.motion.delta_rad, in.overlay->bent);
      desired_nm = bound_scene(state, params, desired_nm, out.motion.delta_counts);
      if (desired_nm == 0.0F) {
        shares.motor_command_nm = share_free_air(params.partition, params.assist, spring_nm,
                                                 state.brake.coil_nm, out.motion.speed_rad_s);
      } else if (is_finite(desired_nm)) [[likely]] {
        shares = partition_by(Law::calibrated, params.partition, desired_nm, spring_nm);
      }
      shared = true;
    } else {
      spring_nm = sense(state, params, *in.overlay, out.motion.delta_rad);
      // Field by field: a copy as a whole would put the motion into memory in every tick.
      const Motion& now = out.motion;
      const Motion copy{now.position_counts, now.delta_counts, now.delta_rad, now.speed_rad_s,
                        now.acceleration_rad_s2};
      desired_nm = add_overlay(state, params, *in.overlay, in.scene, desired_nm, copy);
      if (in.overlay->excitation != nullptr) {
        shares = excite(*in.overlay->excitation, params.excitation, copy, resolution.rad_per_count);
        desired_nm = shares.motor_command_nm;
        shared = true;
      }
      if (in.overlay->impacts && is_finite(desired_nm)) {
        shares =
            share_with_impacts(state, params, *in.overlay, *in.scene, copy, desired_nm, spring_nm);
        desired_nm += state.scene.knock_nm;
        shared = true;
      }
    }
    if (is_free_air(*in.overlay, desired_nm, shared)) {
      shares.motor_command_nm = share_free_air(params.partition, params.assist, spring_nm,
                                               state.brake.coil_nm, out.motion.speed_rad_s);
      shared = true;
    }
  } else {
    spring_nm = sense_brake(state, params, out.motion.delta_rad);
  }
  out.brake_capacity_nm = state.brake.capacity_nm;
  out.spring_torque_nm = state.sensor.spring_torque_nm;
  out.numeric_error = !is_finite(desired_nm);
  out.desired_torque_nm = out.numeric_error ? 0.0F : desired_nm;

  if (!shared) shares = partition(params.partition, out.desired_torque_nm, spring_nm);
  out.motor_command_nm = limit_motor(state.slew, params.slew, shares.motor_command_nm);
  out.brake_command_nm = shares.brake_command_nm;
  out.motor_saturated = shares.motor_saturated;
  out.brake_saturated = shares.brake_saturated;

  state.brake_command_nm = out.brake_command_nm;
  ++state.tick;
  return out;
}

}  // namespace torsio::core
