/// @file
/// The device's configuration. It can be set only while disarmed and is lost at power-off unless
/// `Knob::save()` keeps it. docs/protocol.md has the range of each field.
#pragma once

#include <cstdint>

namespace torsio {

/// The actuator as built. The defaults are those of the reference actuator.
struct ActuatorConfig {
  double motor_torque_max_nm = 85e-3;   ///< what the motor can give
  double brake_torque_max_nm = 110e-3;  ///< what the brake can hold
  double brake_torque_min_nm = 3.3e-3;  ///< floor of the brake's torque in the sensor
  double brake_drag_nm = 2e-3;          ///< what the brake holds with no current
  double brake_time_constant_s = 60e-3;
  double spring_stiffness_nm_per_rad = 2.873;  ///< of the shaft between knob and brake
  std::uint32_t counts_per_rev = 8192;
  int counter_bits = 32;  ///< width at which the encoder's counter wraps, 8 to 32
  bool encoder_reversed = false;
  // These bound what a game may ask for; docs/games.md.
  double knob_inertia_kg_m2 = 6e-5;  ///< of motor and knob
  double knob_coulomb_nm = 6e-3;     ///< dry friction of motor and knob
  double knob_viscous_nm_s_per_rad = 2.6e-5;
  double motor_time_constant_s = 0.1e-3;  ///< from command to torque
};

/// How the desired torque is shared between motor and brake; docs/theory.md.
enum class Law : std::uint8_t { paper, compensated, parallel, motor_only };

/// How the device controls, and what it does when the host goes silent.
struct ControlConfig {
  Law law = Law::paper;
  double beta = 0.5;                   ///< the brake's share of the desired torque, 0 to 1
  double speed_bandwidth_hz = 100.0;   ///< of the speed estimate
  double motor_torque_cap_nm = 100.0;  ///< the user's limit, below the actuator's
  double brake_torque_cap_nm = 100.0;  ///< the user's limit, below the actuator's
  double motor_slew_nm_per_s = 0.0;    ///< largest rate of the motor's torque; 0 is no limit
  double speed_limit_rad_s = 0.0;      ///< faster is a fault; 0 is no limit
  double watchdog_s = 0.25;            ///< silence of the host that disarms, 0.01 to 60
  double passive_ramp_s = 0.05;        ///< the motor's way to zero when the host is lost
  double passive_brake_nm = 0.0;       ///< the brake's torque on that way; 0 releases it
  bool autonomous = false;             ///< no watchdog, plays on without a host
};

/// What is wired to the board, and the electrical values of motor and brake; docs/hardware.md. A
/// pin is the number of its GPIO. Saved, it takes effect when the device starts the next time.
struct BoardConfig {
  double supply_v = 12.0;                        ///< of both H-bridges
  double motor_torque_constant_nm_per_a = 0.05;  ///< at the knob
  double motor_current_max_a = 2.0;              ///< 1.5 times as much measured is a fault
  double motor_resistance_ohm = 2.5;             ///< of the winding
  double motor_inductance_h = 1.5e-3;
  double current_bandwidth_hz = 500.0;           ///< of the current loop
  double current_sense_v_per_a = 0.2;            ///< of the current sensor
  double brake_torque_constant_nm_per_a = 0.44;  ///< on the pulley
  double brake_current_max_a = 0.3;
  double brake_resistance_ohm = 40.0;  ///< of the coil
  bool motor_reversed = false;         ///< a current into the first pin turns to smaller angles
  int encoder_pin = 2;                 ///< of A; B is the next one
  int motor_pin = 6;            ///< first input of the motor's bridge, even; then the next one
  int brake_pin = 8;            ///< first input of the brake's bridge, even; then the next one
  int enable_pin = 10;          ///< high while the power stages are on
  int emergency_stop_pin = 11;  ///< low to run
  int driver_fault_pin = 12;    ///< low when a bridge reports an error
  int current_sense_pin = 26;   ///< 26 to 28
  int light_pin = 25;
};

/// What games may do over the game interface, and how their numbers become torques; docs/games.md.
struct GameConfig {
  bool enabled = true;             ///< false: games see the axis but move nothing
  double range_deg = 900.0;        ///< from one end of the game's axis to the other
  double torque_max_nm = 100.0;    ///< at full level, and the most all effects together get
  double gain = 1.0;               ///< on top of the game's own gains, 0 to 1
  double spring_gain = 1.0;        ///< 1: a full spring reaches full torque at the axis' end
  double speed_full_rad_s = 20.0;  ///< where a full damper reaches full torque
  double acceleration_full_rad_s2 = 3000.0;  ///< where a full inertia does
  double blend_s = 2e-3;    ///< in which a change, a beginning or an end takes full effect
  double silence_s = 10.0;  ///< silence of the game that stops forces without end; 0 is never
};

}  // namespace torsio
