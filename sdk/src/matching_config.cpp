// The configuration that tells the device the truth about an emulated plant.
#include <algorithm>

#include "torsio/emulator.hpp"

namespace torsio {

ActuatorConfig matching_config(const PlantParams& plant) {
  ActuatorConfig config;
  config.motor_torque_max_nm = plant.motor_limit_nm;
  config.brake_torque_max_nm = plant.brake_limit_nm;
  config.brake_torque_min_nm = std::min(config.brake_torque_min_nm, plant.brake_limit_nm);
  config.brake_drag_nm = plant.brake_drag_nm;
  config.brake_time_constant_s = plant.brake_time_constant_s;
  config.spring_stiffness_nm_per_rad = plant.shaft_stiffness_nm_per_rad;
  config.counts_per_rev = plant.counts_per_rev;
  config.knob_inertia_kg_m2 = plant.knob_inertia_kg_m2;
  config.knob_coulomb_nm = plant.knob_coulomb_nm;
  config.knob_viscous_nm_s_per_rad = plant.knob_viscous_nm_s_per_rad;
  config.motor_time_constant_s = plant.motor_time_constant_s;
  config.brake_inertia_kg_m2 = plant.brake_inertia_kg_m2;
  if (plant.brake_hysteresis) {
    // The plant refuses a value out of its range by its own name.
    config.brake_hysteresis_nm = std::max(plant.brake_hysteresis->half_width_nm, 0.0);
  }
  if (plant.electrics) {
    config.brake_time_constant_s =
        plant.electrics->coil_inductance_h / plant.electrics->coil_resistance_ohm;
    // Its bandwidth is 1 kHz.
    if (!plant.electrics->predictive) config.motor_time_constant_s = 0.16e-3;
  }
  return config;
}

ShaftConfig matching_shaft(const PlantParams& plant) {
  if (!plant.shaft_hardening) return {};
  const ShaftHardening& hardening = *plant.shaft_hardening;
  return {.knee_1_rad = hardening.knee_rad,
          .knee_1_nm_per_rad = plant.shaft_stiffness_nm_per_rad * hardening.stiffness_factor};
}

}  // namespace torsio
