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
  float desired_nm = 0.0F;
  if (in.scene != nullptr) {
    desired_nm = evaluate_scene(*in.scene, state.scene, out.motion, resolution, state.tick);
  }
  if (in.overlay != nullptr) [[unlikely]] {
    // Field by field: a copy as a whole would put the motion into memory in every tick.
    const Motion& now = out.motion;
    const Motion copy{now.position_counts, now.delta_counts, now.delta_rad, now.speed_rad_s,
                      now.acceleration_rad_s2};
    desired_nm = add_overlay(*in.overlay, desired_nm, copy, resolution, state.tick);
  }
  out.numeric_error = !is_finite(desired_nm);
  out.desired_torque_nm = out.numeric_error ? 0.0F : desired_nm;

  Shares shares = partition(params.partition, out.desired_torque_nm, out.spring_torque_nm);
  if (in.overlay != nullptr && in.overlay->excitation != nullptr) [[unlikely]] {
    const Motion copy{out.motion};
    shares = excite(*in.overlay->excitation, params.partition, copy, resolution.rad_per_count);
    out.desired_torque_nm = shares.motor_command_nm;
  }
  out.motor_command_nm = limit_motor(state.limits, params.limits, shares.motor_command_nm);
  out.brake_command_nm = shares.brake_command_nm;
  out.motor_saturated = shares.motor_saturated;
  out.brake_saturated = shares.brake_saturated;

  state.brake_command_nm = out.brake_command_nm;
  ++state.tick;
  return out;
}

}  // namespace torsio::core
