/// @file
/// The device's controller, unchanged, in closed loop with the plant, without protocol, states and
/// cable between them: for studies of many runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "core/controller.hpp"
#include "device/config.hpp"
#include "emulator/encoder.hpp"
#include "emulator/hand.hpp"
#include "emulator/plant.hpp"
#include "protocol/effects.hpp"
#include "protocol/reports.hpp"

namespace torsio::emulator {

/// An effect of a scene as it would travel to the device.
using EffectReport =
    std::variant<protocol::Wall, protocol::Spring, protocol::Damper, protocol::Friction,
                 protocol::Inertia, protocol::Constant, protocol::Ramp, protocol::Periodic,
                 protocol::Detents, protocol::EndStops, protocol::Texture, protocol::Curve>;

/// A first phase in which the law is held off: the motor's torque is prescribed and the brake off
/// until the knob is fast enough. Where that happens becomes angle 0 and when it happens time 0.
struct SpinUp {
  double motor_torque_nm = 0.0;  ///< positive or negative, not 0
  double speed_rad_s = 0.0;      ///< to be reached in that direction, > 0
  double longest_s = 10.0;       ///< giving up after, > 0
};

struct ClosedLoopOptions {
  std::int64_t control_period_ns = 1'000'000;  ///< 1,000 to 1e9; the device itself: 50,000 to 1e6
  std::uint32_t delay_ticks = 0;  ///< commands act so many ticks late, at most 1000
  protocol::ActuatorConfig actuator{};
  protocol::ControlConfig control{};
  PlantParams plant{};  ///< its steps are never longer than a control period
  EncoderParams encoder{};
  Hand hand = NoHand{};
  std::optional<PlantState> initial{};  ///< where the plant begins, if not at rest at 0
  std::vector<EffectReport> scene{};   ///< all of it plays from the first tick on; at most 16
  std::vector<float> curve_torque_nm;  ///< the pool that curves read; at most 1024 points
  std::optional<SpinUp> spin_up{};
};

/// One control tick: the truth when it samples the encoder, and what it decides then. Torques are
/// on the knob, positive along positive angle.
struct LoopRow {
  double time_s;
  double angle_rad;        ///< of the knob
  double brake_angle_rad;  ///< of the brake's shaft
  double speed_rad_s;
  double brake_speed_rad_s;
  double spring_torque_nm;         ///< true, of the shaft spring
  double motor_torque_nm;          ///< true, after the motor's lag
  double brake_torque_nm;          ///< what the brake transmits, drag included
  double brake_capacity_nm;        ///< what it could transmit, drag included
  double hand_torque_nm;           ///< of the hand
  double knob_friction_torque_nm;  ///< Coulomb friction on the knob
  std::int64_t position_counts;    ///< measured, from the device's zero
  float estimated_speed_rad_s;     ///< measured
  float desired_torque_nm;         ///< what the scene asks
  float motor_command_nm;
  float brake_command_nm;
  float sensed_spring_torque_nm;
  float sensed_brake_torque_nm;  ///< what the brake is taken to hold, drag not included
  bool knob_sticks;
  bool brake_sticks;
  bool motor_saturated;
  bool brake_saturated;
  bool numeric_error;  ///< the scene's torque was not finite
};

/// Controller, plant, encoder and hand under one virtual clock. What the device does around the
/// controller is left out: arming and its soft start, the watchdog, faults.
class ClosedLoop {
 public:
  /// Does the spin-up too, if there is one.
  /// @throws std::invalid_argument that names what is out of its range
  /// @throws std::runtime_error if the spin-up does not reach its speed
  explicit ClosedLoop(const ClosedLoopOptions& options);

  ClosedLoop(const ClosedLoop&) = delete;
  ClosedLoop& operator=(const ClosedLoop&) = delete;

  /// Goes on for so many ticks. Allocates nothing.
  /// @param rows of the ticks 0, every, 2 every ... of this call, as far as there is room
  void run(std::uint64_t ticks, std::span<LoopRow> rows, std::uint32_t every = 1);

  /// From now on the actuators get this instead of what the law decides. The controller knows of it
  /// and goes on sensing, without a scene.
  void hold_command(const Command& command) { held_ = command; }
  /// Ends hold_command().
  void release_command() { held_.reset(); }

  /// Another hand takes over; times of its profiles are plant time.
  void set_hand(Hand hand) { plant_.set_hand(std::move(hand)); }

  [[nodiscard]] const Plant& plant() const { return plant_; }
  [[nodiscard]] const core::ControllerState& controller() const { return controller_; }
  [[nodiscard]] std::int64_t control_period_ns() const { return period_ns_; }

 private:
  void spin_up(const SpinUp& spin_up);
  void tick(LoopRow* row);
  void give(const Command& command);

  std::int64_t period_ns_;
  device::LoopConfig config_;
  core::Scene scene_;
  core::ControllerState controller_;
  Plant plant_;
  Encoder encoder_;
  std::optional<Command> held_;
  std::vector<Command> late_;  // commands on their way to the actuators, a ring
  std::size_t next_late_ = 0;
};

}  // namespace torsio::emulator
