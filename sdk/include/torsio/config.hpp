/// @file
/// The device's configuration. It can be set only while disarmed and is lost at power-off unless
/// `Knob::save()` keeps it.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <cstdint>

namespace torsio {

/// How the desired torque is shared between motor and brake; docs/explanation/theory.md.
enum class Law : std::uint8_t {
  paper,        ///< the printed law, as it must be read
  compensated,  ///< the motor fills in what the brake does not hold, with its drag counted
  parallel,     ///< fixed shares without the sensor: it sticks, and is here to show that
  motor_only,   ///< no brake
  calibrated,   ///< as compensated, with a stiffness that is bounded by the parts
};

/// On what the values of actuator and shaft are based.
enum class Basis : std::uint8_t {
  assumed,   ///< on data sheets, or a value was changed since
  stated,    ///< on the word of a user who answers for them
  measured,  ///< on a calibration
};

/// The second interface, as the computer sees it.
enum class Personality : std::uint8_t {
  game_controller,  ///< a joystick's axis with force feedback
  dial,             ///< a wheel of the desktop, with detents
};

/// Effect of a dial: clockwise, to larger angles, is down, right or louder.
enum class DialUse : std::uint8_t {
  wheel,            ///< scrolls, in 120 steps a detent where the system can
  pan,              ///< scrolls sideways, as finely
  volume,           ///< a key press for each detent
  radial,           ///< turns Windows' radial controller; the first button is the controller's
  wheel_or_pan,     ///< scrolls; sideways while the first button is pressed
  wheel_or_volume,  ///< scrolls; presses the keys while the first button is pressed
  volume_or_wheel,  ///< presses the keys; scrolls while the first button is pressed
};

/// The actuator as built. The defaults are the reference actuator. Set only while disarmed; another
/// encoder empties the scene.
struct ActuatorConfig {
  double motor_torque_max_nm = 0.085;   ///< largest torque of the motor; 0 to 100
  double brake_torque_max_nm = 0.11;    ///< largest torque of the brake; 0 to 100
  double brake_torque_min_nm = 0.0033;  ///< least brake torque that the sensor assumes; 0 to 100
  double brake_drag_nm = 0.002;         ///< drag of the brake without current; 0 to 100
  double brake_time_constant_s = 0.06;  ///< the brake's lag from command to torque; 0 to 100
  /// stiffness of the shaft between knob and brake; 0 to 1e6
  double spring_stiffness_nm_per_rad = 2.873;
  std::uint32_t counts_per_rev = 8192;  ///< the encoder's counts in a turn; 4 to 16777216
  int counter_bits = 32;                ///< width at which the encoder's counter wraps; 8 to 32
  bool encoder_reversed = false;        ///< true: it counts down where the angle grows
  /// inertia of motor and knob; this and the next three bound a game's effects; 1e-9 to 1
  double knob_inertia_kg_m2 = 6e-5;
  double knob_coulomb_nm = 0.006;             ///< dry friction of motor and knob; 0 to 100
  double knob_viscous_nm_s_per_rad = 2.6e-5;  ///< viscous friction of motor and knob; 0 to 1000
  double motor_time_constant_s = 4.4e-5;      ///< the motor's lag from command to torque; 0 to 1
  /// inertia of pulleys and brake; 0: not counted. This and the next two are for the law
  /// calibrated; 0 to 1
  double brake_inertia_kg_m2 = 4e-5;
  double brake_hysteresis_nm = 0.0;  ///< half the width of the brake's hysteresis loop; 0 to 100
  /// the brake's lag while its torque falls; 0: as `brake_time_constant_s`; 0 to 100
  double brake_release_time_constant_s = 0.0;
  /// GPIO of the encoder's index, one pulse a turn; 0: none. Save it: it takes effect at the next
  /// start; 0 to 29
  int encoder_index_pin = 0;
};

/// How the device controls, and what it does when the host goes silent. Set only while disarmed.
struct ControlConfig {
  Law law = Law::paper;                ///< how the desired torque is shared between motor and brake
  double beta = 0.5;                   ///< the brake's share of the desired torque; 0 to 1
  double speed_bandwidth_hz = 100.0;   ///< bandwidth of the speed estimate; 1 to 1e4
  double motor_torque_cap_nm = 100.0;  ///< the user's limit, below the actuator's; 0 to 100
  double brake_torque_cap_nm = 100.0;  ///< the user's limit, below the actuator's; 0 to 100
  /// largest rate of the motor's torque; 0 is no limit; 0 to 1e6
  double motor_slew_nm_per_s = 0.0;
  double speed_limit_rad_s = 0.0;  ///< a faster knob is a fault; 0: no limit; 0 to 1e4
  double watchdog_s = 0.25;        ///< silence of the host after which the knob disarms; 0.01 to 60
  /// time of the motor's torque to zero when the host is lost; 0 to 10
  double passive_ramp_s = 0.05;
  double passive_brake_nm = 0.0;  ///< the brake's torque during the ramp; 0 releases it; 0 to 100
  bool autonomous = false;        ///< true: no watchdog, plays on without a host
  /// friction that the motor cancels where the scene asks for nothing, at most three quarters of
  /// the configured friction, for four turns without a rest at most; law calibrated only; 0 to 100
  double free_assist_nm = 0.0;
};

/// The board's wiring, and the electrical values of motor and brake; docs/how-to/hardware.md. A pin
/// is the number of its GPIO. Set only while disarmed, then save: it takes effect at the next
/// start. The emulated device uses it where it has Electrics.
struct BoardConfig {
  double supply_v = 12.0;  ///< voltage of both H-bridges; 3 to 60
  /// the motor's torque an ampere, at the knob; 1e-4 to 100
  double motor_torque_constant_nm_per_a = 0.05;
  /// largest current the firmware asks for; a measured current of 1.5 times as much is a fault; 0
  /// to 100
  double motor_current_max_a = 2.0;
  /// continuous current of the winding in air of 25 degrees; more is given for seconds only; 0 to
  /// 100
  double motor_current_continuous_a = 1.0;
  double motor_resistance_ohm = 2.5;   ///< resistance of the winding; 0.001 to 1000
  double motor_inductance_h = 0.0015;  ///< inductance of the winding; 1e-6 to 1
  /// of the current loop; on a pico held at a tenth of the control rate; 1 to 65535
  int current_bandwidth_hz = 10000;
  /// of the current sensor; its zero is measured while the power is off; 0.001 to 10
  double current_sense_v_per_a = 0.2;
  /// the brake's torque an ampere, on its pulley; 1e-4 to 1000
  double brake_torque_constant_nm_per_a = 0.44;
  double brake_current_max_a = 0.3;    ///< largest current of the coil; 0 to 100
  double brake_resistance_ohm = 40.0;  ///< resistance of the coil; 0.001 to 1e4
  /// inductance of the coil. Above 0 the bridge drives the coil both ways, with the actuator's
  /// brake_time_constant_s. 0: the current follows as the coil lets it; 0 to 1000
  double brake_inductance_h = 0.0;
  /// true: a current into the first motor pin turns the knob to smaller angles
  bool motor_reversed = false;
  /// true: somebody has checked the parts. A real board holds torques and speed low until this is
  /// on and `values_are` is not `assumed`. Acts at once
  bool confirmed = false;
  /// continuous current of the coil in air of 25 degrees, of brake_current_max_a; more is given for
  /// a while only; 0 to 100
  int brake_continuous_percent = 100;
  int ambient_c = 25;  ///< highest temperature of the air around motor and brake; 0 to 100
  /// of the divider at supply_sense_pin: the supply's voltage over the pin's; 1 to 255
  int supply_sense_ratio = 11;
  int encoder_pin = 2;  ///< GPIO of A; B is the next one; 0 to 28
  /// GPIO of the first input of the motor's bridge, even; the second is the next one; 0 to 28
  int motor_pin = 6;
  /// GPIO of the first input of the brake's bridge, even; the second is the next one; 0 to 28
  int brake_pin = 8;
  int enable_pin = 10;          ///< GPIO, high while the power stages are on; 0 to 29
  int emergency_stop_pin = 11;  ///< GPIO, low to run; an open wire stops; 0 to 29
  int driver_fault_pin = 12;    ///< GPIO, low when a bridge reports an error; 0 to 29
  int current_sense_pin = 26;   ///< GPIO of the motor's current sensor; 26 to 28
  /// GPIO of a divider at the supply, 26 to 28; the supply is then watched. 0: none; 0 to 28
  int supply_sense_pin = 0;
  int light_pin = 25;  ///< GPIO of the status light; 0 to 29
};

/// Permissions of games on the game interface, and the scale of their torques;
/// docs/reference/games.md. Set only while disarmed.
struct GameConfig {
  bool enabled = true;  ///< false: games see the axis but move nothing
  /// angle from one end of the game's axis to the other, round angle 0; 10 to 36000
  double range_deg = 900.0;
  /// torque at full level, and the limit of all effects together; never more than the motor's; 0 to
  /// 100
  double torque_max_nm = 100.0;
  double gain = 1.0;  ///< strength of all games' effects, times their own gains; 0 to 1
  /// 1: a full spring reaches full torque at the end of the axis; 0 to 1000
  double spring_gain = 20.0;
  /// speed at which a full damper reaches full torque; 0.1 to 1e4
  double speed_full_rad_s = 20.0;
  /// acceleration at which a full inertia reaches full torque; 1 to 1e7
  double acceleration_full_rad_s2 = 3000.0;
  /// in which a change of an effect, its beginning or its end takes full effect; 0 to 0.1
  double blend_s = 0.002;
  /// silence of the game after which forces without end stop; 0: never; 0 to 3600
  double silence_s = 10.0;
  /// true: updates of a steady force are joined by lines, half a frame of the game late; hits pass
  bool join_updates = true;
  /// stiffness of walls at both ends of the axis, while a game has the actuator; 0: none; 0 to 1e6
  double end_stiffness_nm_per_rad = 0.0;
  /// the computer's view of the knob; save it: it takes effect at the next start
  Personality personality = Personality::game_controller;
  DialUse dial_use = DialUse::wheel;  ///< use of a dial
  int dial_detents = 24;              ///< detents of a dial in a turn; 1 to 240
  /// torque between two detents of a dial, held down to a stable one; 0: it turns freely; 0 to 100
  double dial_torque_nm = 0.02;
  /// share of a full damper, always felt while somebody turns the knob, with a game and without; 0
  /// to 100
  int own_damper_percent = 0;
  /// share of full torque as friction, always felt, with a game and without; 0 to 100
  int own_friction_percent = 0;
  /// share of a full inertia, always felt, with a game and without; 0 to 100
  int own_inertia_percent = 0;
  /// share of a full spring to the middle, while no game plays; 0 to 100
  int own_spring_percent = 0;
  int constants_gain_percent = 100;  ///< strength of games' constant forces and ramps; 0 to 100
  int waves_gain_percent = 100;      ///< strength of games' waves; 0 to 100
  int springs_gain_percent = 100;    ///< strength of games' springs; 0 to 100
  int dampers_gain_percent = 100;    ///< strength of games' dampers; 0 to 100
  int inertias_gain_percent = 100;   ///< strength of games' inertias; 0 to 100
  int frictions_gain_percent = 100;  ///< strength of games' frictions; 0 to 100
  /// share of the motor's torque that all effects together get at most; the smaller of this and
  /// `torque_max_nm` counts; 1 to 100
  int torque_max_percent = 100;
  bool reversed = false;  ///< true: axis, games' forces and the dial go the other way
  /// true: a dial tells whole detents, although the host asks for fine ones
  bool dial_coarse = false;
  /// steps of a wheel for a detent that is turned at two turns a second or faster; in proportion
  /// below, down to one; 1 to 20
  int dial_fast_steps = 1;
  /// true: turning or pressing wakes a host that sleeps, if it lets; from the next start on
  bool remote_wakeup = false;
};

/// The curve of the shaft's spring beyond its first straight piece. Up to the first knee the
/// stiffness is the actuator's `spring_stiffness_nm_per_rad`. Both directions are alike. Set only
/// while disarmed.
struct ShaftConfig {
  /// twist of the first knee; 0: the spring is one straight line; 0 to 100
  double knee_1_rad = 0.0;
  /// stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6
  double knee_1_nm_per_rad = 0.0;
  double knee_2_rad = 0.0;  ///< twist of the second knee, beyond the first; 0: none; 0 to 100
  /// stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6
  double knee_2_nm_per_rad = 0.0;
  double knee_3_rad = 0.0;  ///< twist of the third knee; 0 to 100
  /// stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6
  double knee_3_nm_per_rad = 0.0;
  double knee_4_rad = 0.0;  ///< twist of the fourth knee; 0 to 100
  /// stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6
  double knee_4_nm_per_rad = 0.0;
};

/// How well the values of actuator and shaft are known, and since when. It belongs to the values
/// that the device has when it takes this report. When one of them changes, `values_are` reads
/// `assumed`. A `sigma` is the standard uncertainty of a value; 0: it was not measured. Set only
/// while disarmed.
struct CalibrationConfig {
  Basis values_are = Basis::assumed;  ///< source of the values of actuator and shaft
  /// time of the measurement, in seconds since 1970; 0: never; 0 to 4294967300
  std::uint32_t calibrated_unix_s = 0;
  /// the room's temperature, as the user gave it; 0: not given; 0 to 1000
  double ambient_k = 0.0;
  double calibrated_rate_hz = 0.0;                 ///< control rate of the measurement; 0 to 1e6
  double sigma_knob_inertia_kg_m2 = 0.0;           ///< of `knob_inertia_kg_m2`; 0 to 1e6
  double sigma_knob_coulomb_nm = 0.0;              ///< of `knob_coulomb_nm`; 0 to 1e6
  double sigma_knob_viscous_nm_s_per_rad = 0.0;    ///< of `knob_viscous_nm_s_per_rad`; 0 to 1e6
  double sigma_spring_stiffness_nm_per_rad = 0.0;  ///< of `spring_stiffness_nm_per_rad`; 0 to 1e6
  double sigma_knee_1_rad = 0.0;                   ///< of `knee_1_rad`; 0 to 1e6
  double sigma_knee_1_nm_per_rad = 0.0;            ///< of `knee_1_nm_per_rad`; 0 to 1e6
  double sigma_brake_drag_nm = 0.0;                ///< of `brake_drag_nm`; 0 to 1e6
  double sigma_brake_time_constant_s = 0.0;        ///< of `brake_time_constant_s`; 0 to 1e6
  /// of `brake_release_time_constant_s`; 0 to 1e6
  double sigma_brake_release_time_constant_s = 0.0;
  double sigma_brake_inertia_kg_m2 = 0.0;  ///< of `brake_inertia_kg_m2`; 0 to 1e6
  double sigma_brake_hysteresis_nm = 0.0;  ///< of `brake_hysteresis_nm`; 0 to 1e6
  /// standard uncertainty of the board's `motor_resistance_ohm` in thousandths of it; 0: it was not
  /// measured; 0 to 255
  int sigma_motor_resistance_permille = 0;
  /// standard uncertainty of the board's `motor_inductance_h` in thousandths of it; 0: it was not
  /// measured; 0 to 255
  int sigma_motor_inductance_permille = 0;
  /// standard uncertainty of the board's `motor_torque_constant_nm_per_a` in thousandths of it; 0:
  /// it was not measured; 0 to 255
  int sigma_motor_torque_constant_permille = 0;
};

}  // namespace torsio
