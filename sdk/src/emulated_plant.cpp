#include "emulated_plant.hpp"

namespace torsio {

emulator::PlantParams to_emulator(const PlantParams& in) {
  emulator::PlantParams out;
  out.knob_inertia_kg_m2 = in.knob_inertia_kg_m2;
  out.knob_viscous_nm_s_per_rad = in.knob_viscous_nm_s_per_rad;
  out.knob_coulomb_nm = in.knob_coulomb_nm;
  out.brake_inertia_kg_m2 = in.brake_inertia_kg_m2;
  out.brake_viscous_nm_s_per_rad = in.brake_viscous_nm_s_per_rad;
  out.brake_drag_nm = in.brake_drag_nm;
  out.shaft_stiffness_nm_per_rad = in.shaft_stiffness_nm_per_rad;
  out.shaft_damping_nm_s_per_rad = in.shaft_damping_nm_s_per_rad;
  out.brake_time_constant_s = in.brake_time_constant_s;
  out.motor_time_constant_s = in.motor_time_constant_s;
  out.motor_limit_nm = in.motor_limit_nm;
  out.brake_limit_nm = in.brake_limit_nm;
  out.spring_and_brake = in.spring_and_brake;
  if (const auto& part = in.shaft_hardening) {
    out.shaft_hardening = emulator::ShaftHardening{part->knee_rad, part->stiffness_factor};
  }
  if (const auto& part = in.brake_hysteresis) {
    out.brake_hysteresis = emulator::BrakeHysteresis{part->half_width_nm};
  }
  if (const auto& part = in.belt) {
    out.belt = emulator::Belt{part->stiffness_nm_per_rad, part->damping_nm_s_per_rad,
                              part->pulley_inertia_kg_m2};
  }
  if (const auto& part = in.cogging) {
    out.cogging = emulator::Cogging{part->periods_per_rev, part->torque_nm};
  }
  return out;
}

emulator::EncoderParams encoder_of(const PlantParams& plant) {
  return {.counts_per_rev = plant.counts_per_rev,
          .rounding = plant.encoder_rounding == EncoderRounding::nearest
                          ? emulator::Rounding::nearest
                          : emulator::Rounding::floor,
          .phase_counts = plant.encoder_phase_counts,
          .noise_counts = plant.encoder_noise_counts};
}

}  // namespace torsio
