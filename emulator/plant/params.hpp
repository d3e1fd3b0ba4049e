/// @file
/// What the plant is made of: every constant of motor, knob, shaft spring and brake.
#pragma once

#include <optional>
#include <vector>

namespace torsio::emulator {

/// Part: the shaft spring gets stiffer beyond a knee of twist, on both sides.
struct ShaftHardening {
  double knee_rad = 0.015;        ///< > 0; the spring is linear up to here
  double stiffness_factor = 2.0;  ///< > 0; stiffness beyond the knee over stiffness before it
};

/// Part: magnetic hysteresis of the brake. The torque that the brake settles at trails the command
/// like a play of this half-width.
struct BrakeHysteresis {
  double half_width_nm = 5.5e-3;  ///< >= 0; 5 % of the default brake's limit
};

/// Part: a belt between the spring's pulley and the brake that stretches.
struct Belt {
  double stiffness_nm_per_rad = 60.0;  ///< > 0
  double damping_nm_s_per_rad = 1e-3;  ///< >= 0
  double pulley_inertia_kg_m2 = 1e-5;  ///< > 0; the share of brake_inertia_kg_m2 before the belt
};

/// Part: cogging of the motor, a torque that repeats along the turn. It is given as a table and
/// linear in between, which is what lets the exact stepper stay exact.
struct Cogging {
  int periods_per_rev = 0;        ///< >= 1
  std::vector<double> torque_nm;  ///< at equal distances over one period from angle 0; 2 to 64

  /// A sine wave of `points` corners a period.
  [[nodiscard]] static Cogging sine(int periods_per_rev, double amplitude_nm, int points = 16);
};

/// Everything that is constant about motor, knob, shaft spring and brake. The default is parameter
/// set P1. Torques are seen at the knob.
///
///     JA wA' = Thand + Tm - K (thA - thB) - c (wA - wB) - bA wA - fA sgn(wA)
///     JB wB' =              K (thA - thB) + c (wA - wB) - bB wB - (Tb + drag) sgn(wB)
///     Tm' = (Tm_command - Tm) / tau_m,      Tb' = (Tb_command - Tb) / tau_b
///
/// with sgn set-valued at rest: friction truly holds.
struct PlantParams {
  double knob_inertia_kg_m2 = 6e-5;           ///< JA, motor and knob, > 0
  double knob_viscous_nm_s_per_rad = 2.6e-5;  ///< bA, >= 0
  double knob_coulomb_nm = 6e-3;              ///< fA, >= 0
  double brake_inertia_kg_m2 = 4e-5;          ///< JB, pulleys and brake, > 0
  double brake_viscous_nm_s_per_rad = 2e-6;   ///< bB, >= 0
  double brake_drag_nm = 2e-3;                ///< drag of the released brake, >= 0
  double shaft_stiffness_nm_per_rad = 2.873;  ///< K, >= 0 (0: the shaft is cut)
  double shaft_damping_nm_s_per_rad = 2e-4;   ///< c, >= 0
  double brake_time_constant_s = 60e-3;       ///< tau_b, >= 0 (0: no lag)
  double motor_time_constant_s = 0.1e-3;      ///< tau_m, >= 0 (0: no lag)
  double motor_limit_nm = 85e-3;              ///< Tmm, >= 0; commands are clipped to +-Tmm
  double brake_limit_nm = 110e-3;             ///< Tbm, >= 0; commands are clipped to [0, Tbm]

  /// Part: spring and brake. Without it the brake is taken as never engaged and the shafts as one
  /// rigid body that carries the sums of inertia, viscous and Coulomb friction; commands to the
  /// brake have no effect and nothing is spent on its states.
  bool spring_and_brake = true;
  std::optional<ShaftHardening> shaft_hardening;    ///< needs spring_and_brake
  std::optional<BrakeHysteresis> brake_hysteresis;  ///< needs spring_and_brake
  std::optional<Belt> belt;                         ///< needs spring_and_brake
  std::optional<Cogging> cogging;
};

/// @throws std::invalid_argument that names the field, its range and its value
void validate(const PlantParams& params);

}  // namespace torsio::emulator
