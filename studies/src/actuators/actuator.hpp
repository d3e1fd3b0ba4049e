/// @file
/// The actuators that the study compares, and what each one's control law may know.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "actuators/machine.hpp"
#include "core/brake_model.hpp"
#include "core/controller.hpp"
#include "emulator/plant/params.hpp"
#include "emulator/replay.hpp"

namespace torsio::studies::actuators {

/// The actuators that are compared. docs/results/actuators.md has the equations and the sources.
enum class Kind : std::uint8_t {
  motor_only,
  brake_only,
  parallel,                 ///< (a) brake and motor on one shaft
  parallel_torque_sensor,   ///< (b) the same, with the user's torque measured
  series_elastic_motor,     ///< (c) top
  series_elastic_brake,     ///< (c) bottom
  differential_clutch,      ///< (d)
  soft_spring,              ///< (e) two encoders
  soft_sensor_paper,        ///< (f) as published
  soft_sensor_compensated,  ///< (f) with the law `compensated`
  soft_sensor_calibrated,   ///< (f) with the law `calibrated`
  one_way_brakes,           ///< two brakes, each behind a one-way bearing, and a motor
  transfer_function,        ///< brake first, motor after, by a filter
};

inline constexpr int kKinds = 13;

[[nodiscard]] std::string_view name_of(Kind kind);
/// @throws std::invalid_argument that lists the names
[[nodiscard]] Kind kind_from_name(std::string_view name);

/// The parts of all actuators, so that the comparison is one of arrangements and laws. Motor,
/// brake, stiff spring and encoder are the default plant's. Its shaft A is split here: a third of
/// its inertia and a sixth of its friction are the knob on its bearing, the rest is the motor's
/// rotor.
inline const emulator::PlantParams kDefaultPlant;
struct Parts {
  double knob_inertia_kg_m2 = 2e-5;
  double knob_coulomb_nm = 1e-3;
  double rotor_inertia_kg_m2 = 4e-5;
  double rotor_coulomb_nm = 5e-3;
  double rotor_viscous_nm_s_per_rad = kDefaultPlant.knob_viscous_nm_s_per_rad;
  double brake_inertia_kg_m2 = kDefaultPlant.brake_inertia_kg_m2;
  double brake_viscous_nm_s_per_rad = kDefaultPlant.brake_viscous_nm_s_per_rad;
  double brake_drag_nm = kDefaultPlant.brake_drag_nm;
  double stiff_spring_nm_per_rad = kDefaultPlant.shaft_stiffness_nm_per_rad;
  double soft_spring_nm_per_rad = 1.0;
  double spring_damping_nm_s_per_rad = kDefaultPlant.shaft_damping_nm_s_per_rad;
  double motor_time_constant_s = kDefaultPlant.motor_time_constant_s;
  double motor_limit_nm = kDefaultPlant.motor_limit_nm;
  double brake_time_constant_s = kDefaultPlant.brake_time_constant_s;
  double brake_limit_nm = kDefaultPlant.brake_limit_nm;
  double free_assist_nm = 5.8e-3;     ///< that the law `calibrated` takes off the friction
  double beta = 0.5;                  ///< the brake's share, where a law has one
  double sensor_threshold_nm = 3e-3;  ///< of the torque sensor of (b), against its noise
  double force_gain = 1.0;            ///< of the series elastic motor's torque loop
  /// A clutch that drives is built to be fast: fluid in a gap, not powder. Assumed.
  double clutch_time_constant_s = 5e-3;
  double source_speed_rad_s = 30.0;  ///< at which the clutch's motor runs
  double source_acceleration_rad_s2 = 3000.0;
  double source_gear_ratio = 4.0;         ///< torque at the clutch over torque of its motor
  double handover_time_constant_s = 0.1;  ///< of the transfer function
};

[[nodiscard]] MachineParams machine_params(Kind kind, const Parts& parts);

/// The torque to render, from the knob's encoder.
struct Environment {
  double stiffness_nm_per_rad = 0.0;  ///< 0: free space
  double angle_rad = 0.0;             ///< surface of the wall, or centre of the spring
  bool both_ways = false;             ///< a spring; otherwise a wall towards positive angles
};

/// A law's inputs in one tick. Angles are encoders' counts; only (c) and (e) have an
/// encoder on the far shaft and only (b) has the torque sensor.
struct Senses {
  std::int64_t knob_counts = 0;
  std::int64_t far_counts = 0;
  double hand_torque_nm = 0.0;
  double desired_torque_nm = 0.0;  ///< of the virtual environment, from knob_counts
};

/// One actuator's control law with its memory.
class LawOf {
 public:
  /// @param environment that this device makes its own scene of; the others get a torque
  /// @throws std::invalid_argument if this device would refuse a part
  LawOf(Kind kind, const Parts& parts, const Environment& environment, std::uint32_t counts_per_rev,
        std::int64_t period_ns);

  [[nodiscard]] MachineCommand operator()(const Senses& senses);

  /// Torque that the actuator's motor has to give, for its heat.
  [[nodiscard]] double motor_load_nm(const MachineState& state) const;

 private:
  void notice_direction(std::int64_t counts);
  [[nodiscard]] double model_brake(double command_nm);
  [[nodiscard]] MachineCommand share(double desired_nm, bool pressing);
  [[nodiscard]] bool goes_in(const Senses& senses) const;
  [[nodiscard]] MachineCommand drive(double desired_nm) const;
  [[nodiscard]] MachineCommand control(std::int64_t counts);
  [[nodiscard]] MachineCommand hand_over(double desired_nm, bool pressing);

  Kind kind_;
  Parts parts_;
  double rad_per_count_;
  double period_s_;
  bool primed_ = false;
  std::int64_t extreme_counts_ = 0;  ///< farthest since the last turn
  int direction_ = 0;                ///< of the knob's motion, as the encoder shows it
  core::BrakeParams brake_params_;
  core::BrakeState brake_state_;
  double held_brake_nm_ = 0.0;
  double handed_over_nm_ = 0.0;
  std::optional<emulator::ControlSetup> setup_;  // for (f), the device's own controller
  core::ControllerState controller_;
};

}  // namespace torsio::studies::actuators
