#include "core/controller.hpp"

namespace torsio::core {

ControllerOutputs control(ControllerState& state, const ControllerParams& params,
                          const ControllerInputs& in) {
  ControllerOutputs out;
  out.motion = track_motion(state.motion, params.motion, in.encoder_count);
  const float capacity_nm = model_brake(state.brake, params.brake, state.brake_command_nm);
  out.brake_torque_nm = state.brake.torque_nm;
  out.spring_torque_nm = sense_spring(state.sensor, params.spring_stiffness_nm_per_rad,
                                      out.motion.delta_rad, capacity_nm);

  const Resolution& resolution = params.motion.resolution;
  float desired_nm = 0.0F;
  if (in.scene != nullptr) {
    desired_nm = evaluate_scene(*in.scene, state.scene, out.motion, resolution, state.tick);
  }
  if (in.local != nullptr) {
    desired_nm += evaluate_local_model(*in.local, out.motion, resolution);
  }
  desired_nm *= in.scene_gain;
  if (in.extra != nullptr) [[unlikely]] {
    // Field by field: a copy as a whole would put the motion into memory in every tick.
    const Motion& now = out.motion;
    const Motion copy{now.position_counts, now.delta_counts, now.delta_rad, now.speed_rad_s,
                      now.acceleration_rad_s2};
    desired_nm += in.extra->torque_nm(copy, resolution, state.tick);
  }
  out.numeric_error = !is_finite(desired_nm);
  out.desired_torque_nm = out.numeric_error ? 0.0F : desired_nm;

  const Shares shares = partition(params.partition, out.desired_torque_nm, out.spring_torque_nm);
  out.motor_torque_nm = limit_motor(state.limits, params.limits, shares.motor_torque_nm);
  out.brake_command_nm = shares.brake_torque_nm;
  out.motor_saturated = shares.motor_saturated;
  out.brake_saturated = shares.brake_saturated;

  state.brake_command_nm = out.brake_command_nm;
  ++state.tick;
  return out;
}

}  // namespace torsio::core
