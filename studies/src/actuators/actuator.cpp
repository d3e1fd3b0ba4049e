#include "actuators/actuator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

namespace torsio::studies::actuators {
namespace {

constexpr std::array<std::string_view, kKinds> kNames{"motor_only",
                                                      "brake_only",
                                                      "parallel",
                                                      "parallel_torque_sensor",
                                                      "series_elastic_motor",
                                                      "series_elastic_brake",
                                                      "differential_clutch",
                                                      "soft_spring",
                                                      "soft_sensor_paper",
                                                      "soft_sensor_compensated",
                                                      "soft_sensor_calibrated",
                                                      "one_way_brakes",
                                                      "transfer_function"};

double sign(double value) { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0; }

MachineCommand both_ways(double motor_nm, double brake_nm) {
  return {.motor_command_nm = motor_nm,
          .brake_forward_command_nm = brake_nm,
          .brake_backward_command_nm = brake_nm};
}

/// A brake alone, which cannot push.
MachineCommand resist(double desired_nm, bool helps) {
  return both_ways(0.0, helps ? std::abs(desired_nm) : 0.0);
}

/// The motor gives what the spring does not. With nothing wanted it cancels the drag that the
/// spring shows.
MachineCommand fill_in(double desired_nm, double spring_nm) {
  return desired_nm * spring_nm >= 0.0 ? both_ways(desired_nm - spring_nm, std::abs(desired_nm))
                                       : both_ways(desired_nm, 0.0);
}

/// Of two brakes the one that resists.
MachineCommand one_way(MachineCommand command, double desired_nm) {
  (desired_nm < 0.0 ? command.brake_backward_command_nm : command.brake_forward_command_nm) = 0.0;
  return command;
}

std::optional<protocol::Law> device_law(Kind kind) {
  switch (kind) {
    case Kind::soft_sensor_paper:
      return protocol::Law::paper;
    case Kind::soft_sensor_compensated:
      return protocol::Law::compensated;
    case Kind::soft_sensor_calibrated:
      return protocol::Law::calibrated;
    default:
      return std::nullopt;
  }
}

emulator::ControlSetup make_device(protocol::Law law, const Parts& parts,
                                   const Environment& environment, std::uint32_t counts_per_rev,
                                   std::int64_t period_ns) {
  const auto narrow = [](double value) { return static_cast<float>(value); };
  emulator::ClosedLoopOptions options;
  options.control_period_ns = period_ns;
  protocol::ActuatorConfig& actuator = options.actuator;
  actuator.motor_torque_max_nm = narrow(parts.motor_limit_nm);
  actuator.brake_torque_max_nm = narrow(parts.brake_limit_nm);
  actuator.brake_drag_nm = narrow(parts.brake_drag_nm);
  actuator.brake_time_constant_s = narrow(parts.brake_time_constant_s);
  actuator.spring_stiffness_nm_per_rad = narrow(parts.stiff_spring_nm_per_rad);
  actuator.counts_per_rev = counts_per_rev;
  actuator.knob_inertia_kg_m2 = narrow(parts.knob_inertia_kg_m2 + parts.rotor_inertia_kg_m2);
  actuator.knob_coulomb_nm = narrow(parts.knob_coulomb_nm + parts.rotor_coulomb_nm);
  actuator.knob_viscous_nm_s_per_rad = narrow(parts.rotor_viscous_nm_s_per_rad);
  actuator.motor_time_constant_s = narrow(parts.motor_time_constant_s);
  actuator.brake_inertia_kg_m2 = narrow(parts.brake_inertia_kg_m2);
  options.control.law = law;
  options.control.beta = narrow(parts.beta);
  options.control.free_assist_nm = narrow(parts.free_assist_nm);
  const std::int64_t turns_q32 =
      std::llround(environment.angle_rad * (0x1p32 / (2.0 * std::numbers::pi)));
  const float stiffness = narrow(environment.stiffness_nm_per_rad);
  if (environment.both_ways) {
    protocol::Spring spring;
    spring.angle_turns_q32 = turns_q32;
    spring.stiffness_nm_per_rad = stiffness;
    options.scene.emplace_back(spring);
  } else {
    protocol::Wall wall;
    wall.angle_turns_q32 = turns_q32;
    wall.stiffness_nm_per_rad = stiffness;
    options.scene.emplace_back(wall);
  }
  return emulator::make_control_setup(options);
}

}  // namespace

std::string_view name_of(Kind kind) { return kNames[static_cast<std::size_t>(kind)]; }

Kind kind_from_name(std::string_view name) {
  const auto* found = std::find(kNames.begin(), kNames.end(), name);
  if (found != kNames.end()) return static_cast<Kind>(found - kNames.begin());
  std::string message = "actuator must be one of";
  for (const std::string_view known : kNames) message.append(" ").append(known);
  throw std::invalid_argument(message.append("; is '").append(name).append("'"));
}

MachineParams machine_params(Kind kind, const Parts& parts) {
  const Shaft knob{parts.knob_inertia_kg_m2, 0.0, parts.knob_coulomb_nm};
  const Shaft rotor{parts.rotor_inertia_kg_m2, parts.rotor_viscous_nm_s_per_rad,
                    parts.rotor_coulomb_nm};
  const Shaft brake{parts.brake_inertia_kg_m2, parts.brake_viscous_nm_s_per_rad, 0.0};
  const auto together = [](const Shaft& a, const Shaft& b) {
    return Shaft{a.inertia_kg_m2 + b.inertia_kg_m2, a.viscous_nm_s_per_rad + b.viscous_nm_s_per_rad,
                 a.coulomb_nm + b.coulomb_nm};
  };

  MachineParams machine;
  machine.damping_nm_s_per_rad = parts.spring_damping_nm_s_per_rad;
  machine.brake_drag_nm = parts.brake_drag_nm;
  machine.motor_time_constant_s = parts.motor_time_constant_s;
  machine.brake_time_constant_s = parts.brake_time_constant_s;
  machine.motor_limit_nm = parts.motor_limit_nm;
  machine.brake_limit_nm = parts.brake_limit_nm;
  machine.source_acceleration_rad_s2 = parts.source_acceleration_rad_s2;
  const auto behind_spring = [&](const Shaft& far_shaft, double stiffness_nm_per_rad) {
    machine.far_shaft = far_shaft;
    machine.has_far_shaft = true;
    machine.stiffness_nm_per_rad = stiffness_nm_per_rad;
  };
  switch (kind) {
    case Kind::motor_only:
      machine.knob = together(knob, rotor);
      machine.motor = Seat::knob;
      break;
    case Kind::brake_only:
      machine.knob = together(knob, brake);
      machine.brake = Seat::knob;
      break;
    case Kind::parallel:
    case Kind::parallel_torque_sensor:
    case Kind::one_way_brakes:
    case Kind::transfer_function:
      machine.knob = together(together(knob, rotor), brake);
      machine.motor = Seat::knob;
      machine.brake = Seat::knob;
      break;
    case Kind::series_elastic_motor:
      machine.knob = knob;
      behind_spring(rotor, parts.soft_spring_nm_per_rad);
      machine.motor = Seat::far_shaft;
      break;
    case Kind::series_elastic_brake:
      machine.knob = knob;
      behind_spring(brake, parts.soft_spring_nm_per_rad);
      machine.brake = Seat::far_shaft;
      break;
    case Kind::differential_clutch:
      machine.knob = knob;
      behind_spring(brake, parts.stiff_spring_nm_per_rad);
      machine.brake = Seat::far_shaft;
      machine.brake_time_constant_s = parts.clutch_time_constant_s;
      break;
    case Kind::soft_spring:
    case Kind::soft_sensor_paper:
    case Kind::soft_sensor_compensated:
    case Kind::soft_sensor_calibrated:
      machine.knob = together(knob, rotor);
      behind_spring(brake, kind == Kind::soft_spring ? parts.soft_spring_nm_per_rad
                                                     : parts.stiff_spring_nm_per_rad);
      machine.motor = Seat::knob;
      machine.brake = Seat::far_shaft;
      break;
  }
  return machine;
}

LawOf::LawOf(Kind kind, const Parts& parts, const Environment& environment,
             std::uint32_t counts_per_rev, std::int64_t period_ns)
    : kind_(kind),
      parts_(parts),
      rad_per_count_(2.0 * std::numbers::pi / counts_per_rev),
      period_s_(1e-9 * static_cast<double>(period_ns)) {
  brake_params_ = core::make_brake_params(static_cast<float>(parts.brake_time_constant_s),
                                          static_cast<float>(period_s_), 0.0F, 0.0F);
  if (const std::optional<protocol::Law> law = device_law(kind)) {
    setup_ = make_device(*law, parts, environment, counts_per_rev, period_ns);
  }
}

/// Two counts, so that a hand at rest on the border between two counts is no motion.
void LawOf::notice_direction(std::int64_t counts) {
  constexpr std::int64_t least_counts = 2;
  if (!primed_) extreme_counts_ = counts;
  primed_ = true;
  const std::int64_t moved = counts - extreme_counts_;
  if (moved * direction_ <= 0) {
    if (std::abs(moved) < least_counts) return;
    direction_ = moved > 0 ? 1 : -1;
  }
  extreme_counts_ = counts;
}

/// The brake's capacity now, after the last command was held for a period.
double LawOf::model_brake(double command_nm) {
  const double now =
      core::model_brake(brake_state_, brake_params_, static_cast<float>(held_brake_nm_));
  held_brake_nm_ = std::min(command_nm, parts_.brake_limit_nm);
  return now;
}

/// Brake and motor on one shaft. While the hand presses against the torque, the brake takes beta of
/// it and the motor gives the rest. Otherwise the motor gives all.
MachineCommand LawOf::share(double desired_nm, bool pressing) {
  const double brake_nm = pressing ? parts_.beta * std::abs(desired_nm) : 0.0;
  const double available_nm = model_brake(brake_nm);
  double motor_nm = desired_nm;
  if (pressing) motor_nm -= sign(desired_nm) * std::min(available_nm, std::abs(desired_nm));
  return both_ways(motor_nm, brake_nm);
}

/// A tick of this device.
MachineCommand LawOf::control(std::int64_t counts) {
  const core::ControllerParams& params = setup_->config.controller;
  const core::Plan plan = core::plan_of(params, controller_.bound, {&setup_->scene});
  const core::ControllerOutputs out =
      core::control(controller_, params, plan, static_cast<std::uint32_t>(counts));
  return both_ways(out.motor_command_nm, out.brake_command_nm);
}

/// The hand presses harder than the torque that is wanted: the knob is about to go in.
bool LawOf::goes_in(const Senses& senses) const {
  const double desired_nm = senses.desired_torque_nm;
  return -sign(desired_nm) * senses.hand_torque_nm >
         std::abs(desired_nm) + parts_.sensor_threshold_nm;
}

/// A clutch on a source that turns.
MachineCommand LawOf::drive(double desired_nm) const {
  MachineCommand command = both_ways(0.0, std::abs(desired_nm));
  command.source_speed_rad_s = sign(desired_nm) * parts_.source_speed_rad_s;
  return command;
}

/// While the hand presses, the brake answers at once and the motor takes over by and by; otherwise
/// the motor gives all.
MachineCommand LawOf::hand_over(double desired_nm, bool pressing) {
  const double weight = pressing ? -std::expm1(-period_s_ / parts_.handover_time_constant_s) : 1.0;
  handed_over_nm_ += weight * (desired_nm - handed_over_nm_);
  const double rest_nm = desired_nm - handed_over_nm_;
  // A brake cannot push.
  return both_ways(handed_over_nm_, rest_nm * desired_nm > 0.0 ? std::abs(rest_nm) : 0.0);
}

MachineCommand LawOf::operator()(const Senses& senses) {
  if (setup_) return control(senses.knob_counts);
  notice_direction(senses.knob_counts);
  const double desired = senses.desired_torque_nm;
  const bool pressing = desired * direction_ < 0.0;
  // Torque of the spring on the knob, from two encoders.
  const double spring = -parts_.soft_spring_nm_per_rad * rad_per_count_ *
                        static_cast<double>(senses.knob_counts - senses.far_counts);
  switch (kind_) {
    case Kind::motor_only:
      return both_ways(desired, 0.0);
    case Kind::brake_only:
      return resist(desired, pressing);
    case Kind::parallel:
      return share(desired, pressing);
    case Kind::parallel_torque_sensor:
      return share(desired, goes_in(senses));
    case Kind::series_elastic_motor:
      return both_ways(desired + parts_.force_gain * (desired - spring), 0.0);
    case Kind::series_elastic_brake:
      return resist(desired, desired * spring >= 0.0);
    case Kind::differential_clutch:
      return drive(desired);
    case Kind::soft_spring:
      return fill_in(desired, spring);
    case Kind::one_way_brakes:
      return one_way(share(desired, pressing), desired);
    case Kind::transfer_function:
      return hand_over(desired, pressing);
    default:
      throw std::logic_error("this actuator has no law");
  }
}

double LawOf::motor_load_nm(const MachineState& state) const {
  if (kind_ != Kind::differential_clutch) return state.motor_torque_nm;
  return (parts_.brake_drag_nm + state.brake_forward_capacity_nm) / parts_.source_gear_ratio;
}

}  // namespace torsio::studies::actuators
