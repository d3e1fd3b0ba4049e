#include "emulator/plant/params.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace torsio::emulator {
namespace {

[[noreturn]] void refuse(const std::string& field, const std::string& rule, double value) {
  throw std::invalid_argument("plant: " + field + " must be " + rule + ", is " +
                              std::to_string(value));
}

void require_positive(const char* field, double value) {
  if (!std::isfinite(value) || value <= 0.0) refuse(field, "finite and > 0", value);
}

void require_not_negative(const char* field, double value) {
  if (!std::isfinite(value) || value < 0.0) refuse(field, "finite and >= 0", value);
}

void validate_parts(const PlantParams& params) {
  if (!params.spring_and_brake &&
      (params.shaft_hardening || params.brake_hysteresis || params.belt)) {
    throw std::invalid_argument(
        "plant: shaft_hardening, brake_hysteresis and belt need spring_and_brake");
  }
  if (params.shaft_hardening) {
    require_positive("shaft_hardening.knee_rad", params.shaft_hardening->knee_rad);
    require_positive("shaft_hardening.stiffness_factor", params.shaft_hardening->stiffness_factor);
    require_positive("shaft_stiffness_nm_per_rad (with shaft_hardening)",
                     params.shaft_stiffness_nm_per_rad);
  }
  if (params.brake_hysteresis) {
    require_not_negative("brake_hysteresis.half_width_nm", params.brake_hysteresis->half_width_nm);
  }
  if (params.belt) {
    require_positive("belt.stiffness_nm_per_rad", params.belt->stiffness_nm_per_rad);
    require_not_negative("belt.damping_nm_s_per_rad", params.belt->damping_nm_s_per_rad);
    require_positive("belt.pulley_inertia_kg_m2", params.belt->pulley_inertia_kg_m2);
    if (params.belt->pulley_inertia_kg_m2 >= params.brake_inertia_kg_m2) {
      refuse("belt.pulley_inertia_kg_m2", "less than brake_inertia_kg_m2",
             params.belt->pulley_inertia_kg_m2);
    }
  }
  if (params.cogging) {
    const Cogging& cogging = *params.cogging;
    if (cogging.periods_per_rev < 1) {
      refuse("cogging.periods_per_rev", ">= 1", cogging.periods_per_rev);
    }
    if (cogging.torque_nm.size() < 2 || cogging.torque_nm.size() > 64) {
      refuse("the length of cogging.torque_nm", "from 2 to 64",
             static_cast<double>(cogging.torque_nm.size()));
    }
    for (const double torque_nm : cogging.torque_nm) {
      if (!std::isfinite(torque_nm)) refuse("cogging.torque_nm", "finite", torque_nm);
    }
  }
}

}  // namespace

Cogging sine_cogging(int periods_per_rev, double amplitude_nm, int points) {
  Cogging cogging{periods_per_rev, {}};
  for (int i = 0; i < points; ++i) {
    cogging.torque_nm.push_back(amplitude_nm * std::sin(2.0 * std::numbers::pi * i / points));
  }
  return cogging;
}

void validate(const PlantParams& params) {
  require_positive("knob_inertia_kg_m2", params.knob_inertia_kg_m2);
  require_not_negative("knob_viscous_nm_s_per_rad", params.knob_viscous_nm_s_per_rad);
  require_not_negative("knob_coulomb_nm", params.knob_coulomb_nm);
  require_positive("brake_inertia_kg_m2", params.brake_inertia_kg_m2);
  require_not_negative("brake_viscous_nm_s_per_rad", params.brake_viscous_nm_s_per_rad);
  require_not_negative("brake_drag_nm", params.brake_drag_nm);
  require_not_negative("shaft_stiffness_nm_per_rad", params.shaft_stiffness_nm_per_rad);
  require_not_negative("shaft_damping_nm_s_per_rad", params.shaft_damping_nm_s_per_rad);
  require_not_negative("brake_time_constant_s", params.brake_time_constant_s);
  require_not_negative("motor_time_constant_s", params.motor_time_constant_s);
  require_not_negative("motor_limit_nm", params.motor_limit_nm);
  require_not_negative("brake_limit_nm", params.brake_limit_nm);
  validate_parts(params);
}

}  // namespace torsio::emulator
