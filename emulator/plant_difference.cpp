#include "emulator/plant_difference.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace torsio::emulator {

double angle_between(const Angle& a, const Angle& b) {
  return static_cast<double>(a.revolutions - b.revolutions) * Angle::kTurnRad +
         (a.fraction_rad - b.fraction_rad);
}

FidelityAccount::Error between(const PlantModel& model, const PlantState& a, const PlantState& b) {
  FidelityAccount::Error error;
  error.angle_rad = std::abs(angle_between(a.knob_angle, b.knob_angle));
  if (model.has_spring()) {
    error.torque_nm = std::abs(spring_torque_nm(model, a.twist_rad[0]) -
                               spring_torque_nm(model, b.twist_rad[0])) +
                      model.damping_nm_s_per_rad[0] * std::abs(a.speed_rad_s[0] - b.speed_rad_s[0] -
                                                               a.speed_rad_s[1] + b.speed_rad_s[1]);
  }
  error.speed_rad_s = std::abs(a.speed_rad_s[0] - b.speed_rad_s[0]);
  return error;
}

FidelityAccount::Error bound_between(const PlantModel& model, const PlantState& a,
                                     const PlantState& b) {
  FidelityAccount::Error error = between(model, a, b);
  if (!model.has_spring()) return error;
  double stiffest = 0.0;
  for (const SpringPiece& piece : model.shaft_spring) {
    stiffest = std::max(stiffest, piece.stiffness_nm_per_rad);
  }
  const double twist = a.twist_rad[0] - b.twist_rad[0];
  const double belt = a.twist_rad[1] - b.twist_rad[1];
  double square = stiffest * twist * twist + model.belt_stiffness_nm_per_rad * belt * belt;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model.shafts); ++i) {
    const double speed = a.speed_rad_s[i] - b.speed_rad_s[i];
    square += model.inertia_kg_m2[i] * speed * speed;
  }
  error.torque_nm = std::max(error.torque_nm, std::sqrt(stiffest * square));
  return error;
}

FidelityAccount::Error larger(const FidelityAccount::Error& a, const FidelityAccount::Error& b) {
  return {std::max(a.angle_rad, b.angle_rad), std::max(a.torque_nm, b.torque_nm),
          std::max(a.speed_rad_s, b.speed_rad_s)};
}

FidelityAccount::Error scaled(const FidelityAccount::Error& error, double factor) {
  return {factor * error.angle_rad, factor * error.torque_nm, factor * error.speed_rad_s};
}

bool nothing_brings_back(const PlantModel& model) {
  double steepest = 0.0;  // rise of the cogging's torque along the turn
  const std::size_t pieces = model.cogging_nm.size();
  for (std::size_t i = 0; i < pieces; ++i) {
    const double rise_nm = model.cogging_nm[(i + 1) % pieces] - model.cogging_nm[i];
    steepest = std::max(steepest, rise_nm / model.cogging_period_rad * static_cast<double>(pieces));
  }
  return !model.knob_is_driven() && steepest >= model.hand_stiffness_nm_per_rad;
}

bool kinks(const PlantModel& model, const PlantState& a, const PlantState& b) {
  const auto sign = [](double speed) { return (speed > 0.0) - (speed < 0.0); };
  const auto last = static_cast<std::size_t>(model.last_shaft());
  return sign(a.speed_rad_s[0]) != sign(b.speed_rad_s[0]) ||
         sign(a.speed_rad_s[last]) != sign(b.speed_rad_s[last]) ||
         (model.has_spring() &&
          spring_piece_at(model, a.twist_rad[0]) != spring_piece_at(model, b.twist_rad[0])) ||
         (!model.knob_is_driven() &&
          cogging_at(model, a.knob_angle).index != cogging_at(model, b.knob_angle).index);
}

}  // namespace torsio::emulator
