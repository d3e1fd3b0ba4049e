/// @file
/// The plant's state from step to step, and its visible values.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace torsio::emulator {

/// An angle as whole turns and the rest. After 1,000 h at 10 rev/s, 2.3e8 rad, a double resolves
/// 3e-8 rad, and 3.6e9 additions lose whole counts of an encoder. The rest here stays below one
/// turn, so every addition rounds by at most 5e-16 rad at any distance.
struct Angle {
  std::int64_t revolutions = 0;
  double fraction_rad = 0.0;  ///< in [0, 2 pi)

  static constexpr double kTurnRad = 2.0 * std::numbers::pi;

  [[nodiscard]] static Angle from_rad(double rad) {
    Angle angle;
    angle.add(rad);
    return angle;
  }

  [[nodiscard]] double rad() const {
    return static_cast<double>(revolutions) * kTurnRad + fraction_rad;
  }

  void add(double delta_rad) {
    fraction_rad += delta_rad;
    if (fraction_rad >= 0.0 && fraction_rad < kTurnRad) return;
    const double turns = std::floor(fraction_rad / kTurnRad);
    revolutions += static_cast<std::int64_t>(turns);
    fraction_rad -= turns * kTurnRad;
    // The quotient may round across a whole turn.
    if (fraction_rad < 0.0) fraction_rad = 0.0;
    if (fraction_rad >= kTurnRad) {
      fraction_rad = 0.0;
      ++revolutions;
    }
  }
};

/// State of the plant. Shaft 0 is shaft A with motor and knob, shaft 1 the spring's pulley B, shaft
/// 2 the brake C. Without a belt B and C are one rigid body; without spring and brake all three
/// are. They then have equal speeds and no twist.
struct PlantState {
  std::int64_t time_ns = 0;
  Angle knob_angle;                     ///< of shaft A
  std::array<double, 3> speed_rad_s{};  ///< exactly 0 while friction holds a shaft
  std::array<double, 2> twist_rad{};    ///< shaft spring (A - B) and belt (B - C)
  double motor_torque_nm = 0.0;         ///< after the motor's lag
  double brake_magnetic_nm = 0.0;       ///< capacity after lag and hysteresis, without the drag
  double brake_target_nm = 0.0;         ///< where the capacity goes
  double brake_coil_nm = 0.0;           ///< before hysteresis, of a plant without electrics

  [[nodiscard]] double knob_angle_rad() const { return knob_angle.rad(); }
  [[nodiscard]] double knob_speed_rad_s() const { return speed_rad_s[0]; }
  [[nodiscard]] double brake_angle_rad() const {
    return knob_angle.rad() - twist_rad[0] - twist_rad[1];
  }
  [[nodiscard]] double brake_speed_rad_s() const { return speed_rad_s[2]; }
};

/// Rest of a lag, which halves for ever: gone once no torque can feel it. As a subnormal number it
/// would make every later step several times slower.
[[nodiscard]] inline double settled(double gap_nm) {
  constexpr double kNothingNm = 1e-300;
  return std::abs(gap_nm) < kNothingNm ? 0.0 : gap_nm;
}

/// Torques wanted from the actuators, held until the next command.
struct Command {
  double motor_command_nm = 0.0;  ///< on the knob
  double brake_command_nm = 0.0;  ///< capacity, >= 0
};

/// True values that no sensor of the device sees. Every torque is in N m and positive along
/// positive angle.
struct Truth {
  double spring_torque_nm;         ///< of the shaft spring on the knob, its damping included
  double motor_torque_nm;          ///< of the motor on the knob, after its lag
  double hand_torque_nm;           ///< of the hand on the knob, without the hand's own inertia
  double cogging_torque_nm;        ///< of the motor's cogging on the knob
  double knob_friction_torque_nm;  ///< Coulomb friction on shaft A
  double brake_torque_nm;          ///< what the brake, drag included, transmits to its shaft
  double brake_capacity_nm;        ///< what it could transmit, drag included, >= 0
  bool knob_sticks;                ///< friction holds shaft A
  bool brake_sticks;               ///< friction holds the brake's shaft
};

}  // namespace torsio::emulator
