#include "core/controller.hpp"

namespace torsio::core {
namespace {

/// Out of line: what it needs would otherwise be kept in registers in every tick.
[[gnu::noinline]] float add_overlay(const Overlay& overlay, float scene_nm, const Motion& motion,
                                    const Resolution& resolution, std::uint64_t tick) {
  float desired_nm = scene_nm;
  if (overlay.local != nullptr) {
    desired_nm += evaluate_local_model(*overlay.local, motion, resolution);
  }
  desired_nm *= overlay.gain;
  if (overlay.extra != nullptr) desired_nm += overlay.extra->torque_nm(motion, resolution, tick);
  return desired_nm;
}

/// Keeps the ledger, and bounds what the scene asks. What comes from beside the scene is not the
/// knob's motion.
float bound_torque(ControllerState& state, const ControllerParams& params,
                   const ControllerOutputs& out, float beside_nm) {
  const std::int32_t delta_counts = out.motion.delta_counts;
  keep_ledger(state.ledger, state.limits.motor_command_nm, out.spring_torque_nm, delta_counts);
  float timed_nm = state.scene.timed_change_nm + (beside_nm - state.bound.beside_nm);
  if (state.bound.new_scene) timed_nm = out.desired_torque_nm - state.bound.asked_nm;
  state.bound.new_scene = false;
  state.scene.timed_change_nm = 0.0F;
  state.bound.beside_nm = beside_nm;
  return bound_stiffness(state.bound, params.bound, out.desired_torque_nm, timed_nm, delta_counts,
                         out.motion.delta_rad, static_cast<std::uint32_t>(state.tick));
}

}  // namespace

ControllerOutputs control(ControllerState& state, const ControllerParams& params,
                          const ControllerInputs& in) {
  ControllerOutputs out;
  out.motion = track_motion(state.motion, params.motion, in.encoder_count);
  const float capacity_nm = model_brake(state.brake, params.brake, state.brake_command_nm);
  out.brake_capacity_nm = state.brake.capacity_nm;
  out.spring_torque_nm = sense_spring(state.sensor, params.spring_stiffness_nm_per_rad,
                                      out.motion.delta_rad, capacity_nm);

  const Resolution& resolution = params.motion.resolution;
  float scene_nm = 0.0F;
  if (in.scene != nullptr) {
    scene_nm = evaluate_scene(*in.scene, state.scene, out.motion, resolution, state.tick);
  }
  float desired_nm = scene_nm;
  if (in.overlay != nullptr) [[unlikely]] {
    // Field by field: a copy as a whole would put the motion into memory in every tick.
    const Motion& now = out.motion;
    const Motion copy{now.position_counts, now.delta_counts, now.delta_rad, now.speed_rad_s,
                      now.acceleration_rad_s2};
    desired_nm = add_overlay(*in.overlay, desired_nm, copy, resolution, state.tick);
  }
  out.numeric_error = !is_finite(desired_nm);
  out.desired_torque_nm = out.numeric_error ? 0.0F : desired_nm;

  float given_nm = out.desired_torque_nm;
  if (params.partition.law == Law::calibrated) {
    given_nm =
        bound_torque(state, params, out, out.numeric_error ? 0.0F : desired_nm - scene_nm);
    out.bounded = given_nm != out.desired_torque_nm;
  }
  const Shares shares = partition(params.partition, given_nm, out.spring_torque_nm);
  out.motor_command_nm = limit_motor(state.limits, params.limits, shares.motor_command_nm);
  out.brake_command_nm = shares.brake_command_nm;
  out.motor_saturated = shares.motor_saturated;
  out.brake_saturated = shares.brake_saturated;

  state.brake_command_nm = out.brake_command_nm;
  ++state.tick;
  return out;
}

}  // namespace torsio::core
