/// @file
/// The mechanics that all compared actuators are made of: one or two shafts with friction.
#pragma once

#include <array>
#include <cstdint>

#include "emulator/plant/hand.hpp"
#include "steppers/lag.hpp"

namespace torsio::studies::actuators {

/// Parts that turn as one body.
struct Shaft {
  double inertia_kg_m2 = 0.0;         ///< > 0
  double viscous_nm_s_per_rad = 0.0;  ///< >= 0
  double coulomb_nm = 0.0;            ///< >= 0
};

/// Where a motor or a brake sits.
enum class Seat : std::uint8_t { nowhere, knob, far_shaft };

/// A knob, and maybe a far shaft behind a spring; a motor and a brake on either of them. Every
/// actuator of the comparison is one of these.
///
///     J0 w0' = Thand + [Tm] + Ts - b0 w0 - friction0,    Ts = -K (th0 - th1) - c (w0 - w1)
///     J1 w1' =         [Tm] - Ts - b1 w1 - friction1
///
/// Friction is set-valued. A brake adds to the friction of its shaft. It may hold more one way than
/// the other (one-way bearings), or be fixed to a part that turns (a clutch).
struct MachineParams {
  Shaft knob;
  Shaft far_shaft;                    ///< only with has_far_shaft
  bool has_far_shaft = false;         ///< otherwise the knob is all there is
  double stiffness_nm_per_rad = 0.0;  ///< K, >= 0
  double damping_nm_s_per_rad = 0.0;  ///< c, >= 0
  Seat motor = Seat::nowhere;
  Seat brake = Seat::nowhere;
  double brake_drag_nm = 0.0;          ///< of the released brake, >= 0
  double motor_time_constant_s = 0.0;  ///< >= 0
  double brake_time_constant_s = 0.0;  ///< >= 0
  double motor_limit_nm = 0.0;         ///< >= 0
  double brake_limit_nm = 0.0;         ///< >= 0
  double source_acceleration_rad_s2 = 0.0;
};

/// Torques wanted, held until the next command. Values beyond the limits are clipped.
struct MachineCommand {
  double motor_command_nm = 0.0;  ///< on its shaft
  double brake_forward_command_nm =
      0.0;  ///< what the brake shall hold against motion forward, >= 0
  double brake_backward_command_nm = 0.0;  ///< ... and against motion backward
  double source_speed_rad_s = 0.0;         ///< of what the brake is fixed to
};

struct MachineState {
  std::int64_t time_ns = 0;
  std::array<double, 2> angle_rad{};  ///< knob, far shaft
  std::array<double, 2> speed_rad_s{};
  double motor_torque_nm = 0.0;            ///< after the motor's lag
  double brake_forward_capacity_nm = 0.0;  ///< after the brake's lag, without drag
  double brake_backward_capacity_nm = 0.0;
  double source_speed_rad_s = 0.0;
  double brake_torque_nm = 0.0;  ///< on its shaft, drag included; mean of the last step
};

/// Steps a machine with the theta = 1/2 method and set-valued friction: second order between
/// friction events, first order across them. The comparison halves the step to see that it is fine.
class Machine {
 public:
  /// @throws std::invalid_argument if a parameter is out of its range, or the hand prescribes
  ///         the motion, which a brake fixed to the knob could not answer with one definite torque
  Machine(const MachineParams& params, const emulator::Hand& hand, std::int64_t step_ns);

  void set_command(const MachineCommand& command);
  void set_state(const MachineState& state) { state_ = state; }

  /// One step of `step_ns`.
  void step();

  [[nodiscard]] const MachineState& state() const { return state_; }

  /// The hand's torque on the knob, without the hand's own inertia.
  [[nodiscard]] double hand_torque_nm() const;
  /// The spring's torque on the knob, its damping included; 0 without a far shaft.
  [[nodiscard]] double spring_torque_nm() const;
  /// What the hand feels: the actuator's torques on the knob, without the friction of its bearings.
  [[nodiscard]] double rendered_torque_nm() const;

 private:
  using Pair = std::array<double, 2>;

  void refresh_matrix();
  [[nodiscard]] double intended_rad(double ahead_s) const;
  [[nodiscard]] Pair push();
  [[nodiscard]] Pair solve_friction(Pair& speed, const Pair& lowest, const Pair& highest) const;

  MachineParams params_;
  emulator::Hand hand_;
  double hand_stiffness_ = 0.0;
  double hand_damping_ = 0.0;
  std::int64_t step_ns_;
  double step_s_;
  Lag motor_lag_;
  Lag brake_lag_;
  MachineCommand command_;
  MachineState state_;
  std::array<Pair, 2> damping_{};  ///< B + h/2 S
  std::array<Pair, 2> inverse_{};  ///< of J/h + (B + h/2 S)/2
};

}  // namespace torsio::studies::actuators
