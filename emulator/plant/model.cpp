#include "emulator/plant/model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

namespace torsio::emulator {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<SpringPiece> shaft_spring(const PlantParams& params) {
  const double stiffness = params.shaft_stiffness_nm_per_rad;
  if (!params.shaft_hardening) return {{-kInfinity, kInfinity, stiffness, 0.0}};
  // Beyond the knee the line is steeper and still meets the knee's torque, so it appears to come
  // from another rest position.
  const double knee = params.shaft_hardening->knee_rad;
  const double factor = params.shaft_hardening->stiffness_factor;
  const double rest = knee * (1.0 - 1.0 / factor);
  return {{-kInfinity, -knee, stiffness * factor, -rest},
          {-knee, knee, stiffness, 0.0},
          {knee, kInfinity, stiffness * factor, rest}};
}

void put_shafts_together(const PlantParams& params, PlantModel& model) {
  model.inertia_kg_m2[0] = params.knob_inertia_kg_m2;
  model.viscous_nm_s_per_rad[0] = params.knob_viscous_nm_s_per_rad;
  model.knob_coulomb_nm = params.knob_coulomb_nm;
  if (!params.spring_and_brake) {
    model.shafts = 1;
    model.inertia_kg_m2[0] += params.brake_inertia_kg_m2;
    model.viscous_nm_s_per_rad[0] += params.brake_viscous_nm_s_per_rad;
    model.knob_coulomb_nm += params.brake_drag_nm;
    return;
  }
  model.shafts = 2;
  model.inertia_kg_m2[1] = params.brake_inertia_kg_m2;
  model.viscous_nm_s_per_rad[1] = params.brake_viscous_nm_s_per_rad;
  model.damping_nm_s_per_rad[0] = params.shaft_damping_nm_s_per_rad;
  model.shaft_spring = shaft_spring(params);
  model.brake_drag_nm = params.brake_drag_nm;
  model.brake_time_constant_s = params.brake_time_constant_s;
  if (!params.belt) return;
  model.shafts = 3;
  model.inertia_kg_m2[1] = params.belt->pulley_inertia_kg_m2;
  model.inertia_kg_m2[2] = params.brake_inertia_kg_m2 - params.belt->pulley_inertia_kg_m2;
  model.viscous_nm_s_per_rad[1] = 0.0;
  model.viscous_nm_s_per_rad[2] = params.brake_viscous_nm_s_per_rad;
  model.damping_nm_s_per_rad[1] = params.belt->damping_nm_s_per_rad;
  model.belt_stiffness_nm_per_rad = params.belt->stiffness_nm_per_rad;
}

/// A winding is a lag that the knob's speed works against: L i' = v - R i - k w, in torques k i.
void wind(const Electrics& electrics, bool connected, PlantModel& model) {
  const double resistance = electrics.winding_resistance_ohm;
  const double constant = electrics.torque_constant_nm_per_a;
  model.motor_time_constant_s = connected ? electrics.winding_inductance_h / resistance : 0.0;
  model.back_emf_nm_s_per_rad = connected ? constant * constant / resistance : 0.0;
  if (model.has_spring()) {
    model.brake_time_constant_s = electrics.coil_inductance_h / electrics.coil_resistance_ohm;
  }
}

void take_in_hand(const Hand& hand, PlantModel& model) {
  if (std::holds_alternative<TorqueHand>(hand) || std::holds_alternative<FeedbackHand>(hand)) {
    model.hand = HandKind::torque;
  }
  if (std::holds_alternative<PrescribedMotion>(hand)) model.hand = HandKind::prescribed;
  if (const auto* impedance = std::get_if<ImpedanceHand>(&hand)) {
    model.hand = HandKind::impedance;
    model.hand_stiffness_nm_per_rad = impedance->stiffness_nm_per_rad;
    model.hand_damping_nm_s_per_rad = impedance->damping_nm_s_per_rad;
    model.inertia_kg_m2[0] += impedance->inertia_kg_m2;
    model.viscous_nm_s_per_rad[0] += impedance->damping_nm_s_per_rad;
  }
}

/// Torque of the springs, with their damping, on one shaft.
double springs_on_shaft_nm(const PlantModel& model, const PlantState& state, int shaft) {
  double torque_nm = 0.0;
  for (const int spring : {shaft - 1, shaft}) {
    if (spring < 0 || spring >= model.last_shaft()) continue;
    const auto s = static_cast<std::size_t>(spring);
    const double twisting =
        (spring == 0 ? spring_torque_nm(model, state.twist_rad[0])
                     : model.belt_stiffness_nm_per_rad * state.twist_rad[1]) +
        model.damping_nm_s_per_rad[s] * (state.speed_rad_s[s] - state.speed_rad_s[s + 1]);
    torque_nm += spring == shaft ? -twisting : twisting;
  }
  return torque_nm;
}

/// Coulomb friction on a shaft: full against motion, and at rest as much as it takes.
double friction_torque_nm(double speed_rad_s, double demand_nm, double capacity_nm) {
  if (speed_rad_s != 0.0) return -std::copysign(capacity_nm, speed_rad_s);
  return -std::clamp(demand_nm, -capacity_nm, capacity_nm);
}

}  // namespace

PlantModel make_model(const PlantParams& params, const Hand& hand, bool connected) {
  validate(params);
  validate(hand);
  PlantModel model;
  put_shafts_together(params, model);
  model.motor_time_constant_s = params.motor_time_constant_s;
  if (params.electrics) wind(*params.electrics, connected, model);
  if (params.cogging) {
    model.cogging_nm = params.cogging->torque_nm;
    model.cogging_period_rad = Angle::kTurnRad / params.cogging->periods_per_rev;
  }
  take_in_hand(hand, model);
  return model;
}

int spring_piece_at(const PlantModel& model, double twist_rad) {
  if (model.shaft_spring.size() < 3) return 0;
  if (twist_rad < model.shaft_spring[1].begin_rad) return 0;
  return twist_rad > model.shaft_spring[1].end_rad ? 2 : 1;
}

double spring_torque_nm(const PlantModel& model, double twist_rad) {
  const auto& piece =
      model.shaft_spring[static_cast<std::size_t>(spring_piece_at(model, twist_rad))];
  return piece.stiffness_nm_per_rad * (twist_rad - piece.rest_rad);
}

CoggingPiece cogging_at(const PlantModel& model, const Angle& angle) {
  if (model.cogging_nm.empty()) return {0, 0.0, 0.0, 0.0, 0.0};
  const int pieces = static_cast<int>(model.cogging_nm.size());
  const double width_rad = model.cogging_period_rad / pieces;
  // The period divides the turn, so whole turns do not matter.
  const double along = angle.fraction_rad / width_rad;
  const double whole = std::floor(along);
  const int index = static_cast<int>(whole) % pieces;
  const double begin_nm = model.cogging_nm[static_cast<std::size_t>(index)];
  const double end_nm = model.cogging_nm[static_cast<std::size_t>((index + 1) % pieces)];
  const double slope = (end_nm - begin_nm) / width_rad;
  const double into_rad = (along - whole) * width_rad;
  return {index, -into_rad, width_rad - into_rad, begin_nm + slope * into_rad, slope};
}

CoggingPiece neighbour(const PlantModel& model, const CoggingPiece& piece, int steps) {
  const int pieces = static_cast<int>(model.cogging_nm.size());
  const double width_rad = model.cogging_period_rad / pieces;
  const int index = (piece.index + steps + pieces) % pieces;
  const double begin_nm = model.cogging_nm[static_cast<std::size_t>(index)];
  const double end_nm = model.cogging_nm[static_cast<std::size_t>((index + 1) % pieces)];
  const double slope = (end_nm - begin_nm) / width_rad;
  if (steps > 0) return {index, 0.0, width_rad, begin_nm, slope};
  return {index, -width_rad, 0.0, end_nm, slope};
}

double friction_demand_nm(const PlantModel& model, const PlantState& state,
                          const HeldInputs& inputs, int shaft) {
  const double speed = state.speed_rad_s[static_cast<std::size_t>(shaft)];
  double demand_nm = springs_on_shaft_nm(model, state, shaft) -
                     model.viscous_nm_s_per_rad[static_cast<std::size_t>(shaft)] * speed;
  if (shaft == 0) {
    demand_nm += state.motor_torque_nm + hand_force(model, state, inputs).force_nm +
                 cogging_at(model, state.knob_angle).torque_nm;
  }
  return demand_nm;
}

Truth truth(const PlantModel& model, const PlantState& state, const HeldInputs& inputs) {
  Truth result{};
  result.motor_torque_nm = state.motor_torque_nm;
  result.cogging_torque_nm = cogging_at(model, state.knob_angle).torque_nm;
  result.spring_torque_nm = springs_on_shaft_nm(model, state, 0);
  result.hand_torque_nm = hand_force(model, state, inputs).force_nm -
                          model.hand_damping_nm_s_per_rad * state.knob_speed_rad_s();

  const double knob_demand_nm = friction_demand_nm(model, state, inputs, 0);
  if (model.knob_is_driven()) {
    // The hand gives whatever the path takes; the path has no acceleration between its corners.
    const double speed = state.knob_speed_rad_s();
    result.knob_friction_torque_nm = friction_torque_nm(speed, 0.0, model.knob_coulomb_nm);
    result.hand_torque_nm = -(knob_demand_nm + result.knob_friction_torque_nm);
    result.knob_sticks = false;
  } else {
    result.knob_friction_torque_nm =
        friction_torque_nm(state.knob_speed_rad_s(), knob_demand_nm, model.knob_coulomb_nm);
    result.knob_sticks =
        state.knob_speed_rad_s() == 0.0 && std::abs(knob_demand_nm) <= model.knob_coulomb_nm;
  }

  if (model.has_spring()) {
    const double demand_nm = friction_demand_nm(model, state, inputs, model.last_shaft());
    result.brake_capacity_nm = state.brake_magnetic_nm + model.brake_drag_nm;
    result.brake_torque_nm =
        friction_torque_nm(state.brake_speed_rad_s(), demand_nm, result.brake_capacity_nm);
    result.brake_sticks =
        state.brake_speed_rad_s() == 0.0 && std::abs(demand_nm) <= result.brake_capacity_nm;
  }
  return result;
}

}  // namespace torsio::emulator
