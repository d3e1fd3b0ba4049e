#include "actuators/machine.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "emulator/plant/require.hpp"
#include "steppers/contacts.hpp"

namespace torsio::studies::actuators {
namespace {

/// Bearing and brake on one shaft share the torque by their limits.
double of_brake(double torque_nm, double bearing_nm, double lowest_nm, double highest_nm) {
  const double bound = torque_nm < 0.0 ? -lowest_nm : highest_nm;
  return (bound > 0.0 ? 1.0 - bearing_nm / bound : 0.0) * torque_nm;
}

constexpr double kTheta = 0.5;

void require_shaft(const Shaft& shaft) {
  require(std::isfinite(shaft.inertia_kg_m2) && shaft.inertia_kg_m2 > 0.0,
          "actuator: every inertia must be finite and > 0");
  require(std::isfinite(shaft.viscous_nm_s_per_rad) && shaft.viscous_nm_s_per_rad >= 0.0 &&
              std::isfinite(shaft.coulomb_nm) && shaft.coulomb_nm >= 0.0,
          "actuator: every friction must be finite and >= 0");
}

/// Takes `value` towards `target` over a step; gives its mean on the way.
double follow(const Lag& lag, double& value, double target) {
  const double gap = value - target;
  value = target + gap * lag.end;
  return target + gap * lag.mean;
}

}  // namespace

Machine::Machine(const MachineParams& params, const emulator::Hand& hand, std::int64_t step_ns)
    : params_(params),
      hand_(hand),
      step_ns_(step_ns),
      step_s_(1e-9 * static_cast<double>(step_ns)) {
  require(step_ns > 0, "actuator: the step must be > 0");
  validate(hand);
  require(!std::holds_alternative<emulator::FeedbackHand>(hand),
          "actuator: a hand that is a function is not possible here");
  require(!std::holds_alternative<emulator::PrescribedMotion>(hand),
          "actuator: a hand must have some give; prescribed motion is not possible here");
  if (const auto* held = std::get_if<emulator::ImpedanceHand>(&hand_)) {
    hand_stiffness_ = held->stiffness_nm_per_rad;
    hand_damping_ = held->damping_nm_s_per_rad;
    params_.knob.inertia_kg_m2 += held->inertia_kg_m2;
  }
  require_shaft(params_.knob);
  if (params_.has_far_shaft) require_shaft(params_.far_shaft);
  for (const double value :
       {params_.stiffness_nm_per_rad, params_.damping_nm_s_per_rad, params_.brake_drag_nm,
        params_.motor_time_constant_s, params_.brake_time_constant_s, params_.motor_limit_nm,
        params_.brake_limit_nm, params_.source_acceleration_rad_s2}) {
    require(std::isfinite(value) && value >= 0.0,
            "actuator: stiffness, damping, drag, lags and limits must be finite and >= 0");
  }
  motor_lag_ = Lag::over(step_s_, params_.motor_time_constant_s);
  brake_lag_ = Lag::over(step_s_, params_.brake_time_constant_s);
  refresh_matrix();
}

void Machine::set_command(const MachineCommand& command) {
  const double brake_limit = params_.brake_limit_nm;
  command_.motor_command_nm =
      std::clamp(command.motor_command_nm, -params_.motor_limit_nm, params_.motor_limit_nm);
  command_.brake_forward_command_nm =
      std::clamp(command.brake_forward_command_nm, 0.0, brake_limit);
  command_.brake_backward_command_nm =
      std::clamp(command.brake_backward_command_nm, 0.0, brake_limit);
  command_.source_speed_rad_s = command.source_speed_rad_s;
}

double Machine::intended_rad(double ahead_s) const {
  const auto* held = std::get_if<emulator::ImpedanceHand>(&hand_);
  if (held == nullptr) return 0.0;
  return held->intended_angle_rad.value(state_.time_ns) +
         ahead_s * held->intended_angle_rad.slope_per_s(state_.time_ns);
}

double Machine::hand_torque_nm() const {
  if (const auto* torque = std::get_if<emulator::TorqueHand>(&hand_)) {
    return torque->torque_nm.value(state_.time_ns);
  }
  const auto* held = std::get_if<emulator::ImpedanceHand>(&hand_);
  if (held == nullptr) return 0.0;
  return hand_stiffness_ * (intended_rad(0.0) - state_.angle_rad[0]) +
         hand_damping_ *
             (held->intended_angle_rad.slope_per_s(state_.time_ns) - state_.speed_rad_s[0]);
}

double Machine::spring_torque_nm() const {
  if (!params_.has_far_shaft) return 0.0;
  return -params_.stiffness_nm_per_rad * (state_.angle_rad[0] - state_.angle_rad[1]) -
         params_.damping_nm_s_per_rad * (state_.speed_rad_s[0] - state_.speed_rad_s[1]);
}

double Machine::rendered_torque_nm() const {
  double torque = spring_torque_nm();
  if (params_.motor == Seat::knob) torque += state_.motor_torque_nm;
  if (params_.brake == Seat::knob) torque += state_.brake_torque_nm;
  return torque;
}

void Machine::refresh_matrix() {
  const double link =
      params_.damping_nm_s_per_rad + kTheta * step_s_ * params_.stiffness_nm_per_rad;
  damping_[0] = {
      params_.knob.viscous_nm_s_per_rad + hand_damping_ + kTheta * step_s_ * hand_stiffness_, 0.0};
  damping_[1] = {0.0, 0.0};
  if (params_.has_far_shaft) {
    damping_[0][0] += link;
    damping_[0][1] -= link;
    damping_[1] = {-link, params_.far_shaft.viscous_nm_s_per_rad + link};
  }
  // Without a far shaft its row stands for a body that nothing touches.
  const double far_inertia = params_.has_far_shaft ? params_.far_shaft.inertia_kg_m2 : 1.0;
  const double a = params_.knob.inertia_kg_m2 / step_s_ + kTheta * damping_[0][0];
  const double b = kTheta * damping_[0][1];
  const double d = far_inertia / step_s_ + kTheta * damping_[1][1];
  const double determinant = a * d - b * b;
  inverse_[0] = {d / determinant, -b / determinant};
  inverse_[1] = {-b / determinant, a / determinant};
}

/// Friction torques on both shafts. `speed` is relative to the part that each friction acts
/// against: before friction on entry, after it on return.
Machine::Pair Machine::solve_friction(Pair& speed, const Pair& lowest, const Pair& highest) const {
  const auto& gain = inverse_;
  const Contact knob{gain[0][0], speed[0], lowest[0], highest[0]};
  const Contact far_shaft{gain[1][1], speed[1], lowest[1], highest[1]};
  const auto [knob_nm, far_nm] = solve_contacts(knob, far_shaft, gain[0][1]);
  for (std::size_t i = 0; i < 2; ++i) speed[i] += gain[i][0] * knob_nm + gain[i][1] * far_nm;
  return {knob_nm, far_nm};
}

/// Torques of spring, hand and motor.
Machine::Pair Machine::push() {
  const double spring = params_.has_far_shaft ? params_.stiffness_nm_per_rad *
                                                    (state_.angle_rad[0] - state_.angle_rad[1])
                                              : 0.0;
  Pair rhs{-spring, spring};
  // The hand's own stiffness and damping against motion are in the matrix.
  if (std::holds_alternative<emulator::TorqueHand>(hand_)) {
    rhs[0] += hand_torque_nm();
  } else if (const auto* held = std::get_if<emulator::ImpedanceHand>(&hand_)) {
    rhs[0] += hand_stiffness_ * (intended_rad(0.5 * step_s_) - state_.angle_rad[0]) +
              hand_damping_ * held->intended_angle_rad.slope_per_s(state_.time_ns);
  }
  const double motor = follow(motor_lag_, state_.motor_torque_nm, command_.motor_command_nm);
  if (params_.motor != Seat::nowhere) rhs[params_.motor == Seat::knob ? 0 : 1] += motor;
  return rhs;
}

void Machine::step() {
  Pair rhs = push();
  const double most = params_.source_acceleration_rad_s2 * step_s_;
  state_.source_speed_rad_s +=
      std::clamp(command_.source_speed_rad_s - state_.source_speed_rad_s, -most, most);
  const double forward =
      follow(brake_lag_, state_.brake_forward_capacity_nm, command_.brake_forward_command_nm);
  const double backward =
      follow(brake_lag_, state_.brake_backward_capacity_nm, command_.brake_backward_command_nm);

  const Pair old = state_.speed_rad_s;
  const double far_inertia = params_.has_far_shaft ? params_.far_shaft.inertia_kg_m2 : 1.0;
  rhs[0] += params_.knob.inertia_kg_m2 / step_s_ * old[0];
  rhs[1] += far_inertia / step_s_ * old[1];
  for (std::size_t i = 0; i < 2; ++i) {
    rhs[i] -= (1.0 - kTheta) * (damping_[i][0] * old[0] + damping_[i][1] * old[1]);
  }
  Pair speed{};
  for (std::size_t i = 0; i < 2; ++i) {
    speed[i] = inverse_[i][0] * rhs[0] + inverse_[i][1] * rhs[1];
  }

  Pair coulomb{params_.knob.coulomb_nm, params_.has_far_shaft ? params_.far_shaft.coulomb_nm : 0.0};
  Pair lowest{-coulomb[0], -coulomb[1]};
  Pair highest = coulomb;
  Pair ground{};
  const std::size_t braked = params_.brake == Seat::knob ? 0 : 1;
  if (params_.brake != Seat::nowhere) {
    lowest[braked] -= params_.brake_drag_nm + forward;
    highest[braked] += params_.brake_drag_nm + backward;
    ground[braked] = state_.source_speed_rad_s;
  }
  Pair relative{speed[0] - ground[0], speed[1] - ground[1]};
  const Pair force = solve_friction(relative, lowest, highest);
  for (std::size_t i = 0; i < 2; ++i) {
    // A friction inside its bounds is one that holds: the speed is 0 by its very definition.
    if (force[i] > lowest[i] && force[i] < highest[i]) relative[i] = 0.0;
    state_.speed_rad_s[i] = relative[i] + ground[i];
    state_.angle_rad[i] += step_s_ * (kTheta * state_.speed_rad_s[i] + (1.0 - kTheta) * old[i]);
  }
  if (params_.brake != Seat::nowhere) {
    state_.brake_torque_nm =
        of_brake(force[braked], coulomb[braked], lowest[braked], highest[braked]);
  }
  if (!params_.has_far_shaft) {
    state_.angle_rad[1] = state_.angle_rad[0];
    state_.speed_rad_s[1] = state_.speed_rad_s[0];
  }
  state_.time_ns += step_ns_;
}

}  // namespace torsio::studies::actuators
