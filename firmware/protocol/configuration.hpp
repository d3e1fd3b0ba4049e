/// @file
/// The device's parts and its control: the reports that are kept in flash.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "protocol/effects.hpp"
#include "protocol/enumerations.hpp"
#include "protocol/layout.hpp"

namespace torsio::protocol {

// Limits of a real board until its parts are confirmed and known.
// Enough to move the reference actuator against its friction, and nothing that hurts.
inline constexpr float unconfirmed_motor_torque_max_nm = 0.015F;
inline constexpr float unconfirmed_brake_torque_max_nm = 0.03F;
inline constexpr float unconfirmed_speed_limit_rad_s = 10;

// A torque's way to zero when somebody disarms; its spectrum is zero at 250 Hz, where the skin is
// most sensitive.
inline constexpr float let_go_s = 0.004F;

// An experiment's servo disarms after so long at full torque without movement; the reference motor
// makes the reference knob 40 rad/s faster in this time.
inline constexpr float excitation_still_s = 0.05F;

/// The actuator as built. The defaults are the reference actuator. Set only while disarmed; another
/// encoder empties the scene.
struct ActuatorConfig {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  float motor_torque_max_nm = 0.085F;
  float brake_torque_max_nm = 0.11F;
  float brake_torque_min_nm = 0.0033F;
  float brake_drag_nm = 0.002F;
  float brake_time_constant_s = 0.06F;
  float spring_stiffness_nm_per_rad = 2.873F;
  std::uint32_t counts_per_rev = 8192;
  std::uint8_t counter_bits = 32;
  Toggle encoder_reversed = Toggle::off;
  float knob_inertia_kg_m2 = 6e-5F;
  float knob_coulomb_nm = 0.006F;
  float knob_viscous_nm_s_per_rad = 2.6e-5F;
  float motor_time_constant_s = 4.4e-5F;
  float brake_inertia_kg_m2 = 4e-5F;
  float brake_hysteresis_nm = 0;
  float brake_release_time_constant_s = 0;
  std::uint8_t encoder_index_pin = 0;
};
template <>
struct Layout<ActuatorConfig> {
  static constexpr std::uint8_t id = 0x04;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "actuator_config";
  static constexpr std::string_view doc =
      "The actuator as built. The defaults are the reference actuator. Set only while disarmed; "
      "another encoder empties the scene.";
  static constexpr FieldList fields{
      any_number("sequence", &ActuatorConfig::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &ActuatorConfig::axis, "", "0: an interface has one axis"),
      number("motor_torque_max_nm", &ActuatorConfig::motor_torque_max_nm, "N m", 0, max_torque_nm,
             "largest torque of the motor"),
      number("brake_torque_max_nm", &ActuatorConfig::brake_torque_max_nm, "N m", 0, max_torque_nm,
             "largest torque of the brake"),
      number("brake_torque_min_nm", &ActuatorConfig::brake_torque_min_nm, "N m", 0, max_torque_nm,
             "least brake torque that the sensor assumes"),
      number("brake_drag_nm", &ActuatorConfig::brake_drag_nm, "N m", 0, max_torque_nm,
             "drag of the brake without current"),
      number("brake_time_constant_s", &ActuatorConfig::brake_time_constant_s, "s", 0, 100,
             "the brake's lag from command to torque"),
      number("spring_stiffness_nm_per_rad", &ActuatorConfig::spring_stiffness_nm_per_rad, "N m/rad",
             0, max_stiffness_nm_per_rad, "stiffness of the shaft between knob and brake"),
      number("counts_per_rev", &ActuatorConfig::counts_per_rev, "", 4, 1U << 24,
             "the encoder's counts in a turn"),
      number("counter_bits", &ActuatorConfig::counter_bits, "", 8, 32,
             "width at which the encoder's counter wraps"),
      choice("encoder_reversed", &ActuatorConfig::encoder_reversed,
             "on: it counts down where the angle grows"),
      number("knob_inertia_kg_m2", &ActuatorConfig::knob_inertia_kg_m2, "kg m^2", 1e-9F, 1,
             "inertia of motor and knob; this and the next three bound a game's effects"),
      number("knob_coulomb_nm", &ActuatorConfig::knob_coulomb_nm, "N m", 0, max_torque_nm,
             "dry friction of motor and knob"),
      number("knob_viscous_nm_s_per_rad", &ActuatorConfig::knob_viscous_nm_s_per_rad, "N m s/rad",
             0, max_damping_nm_s_per_rad, "viscous friction of motor and knob"),
      number("motor_time_constant_s", &ActuatorConfig::motor_time_constant_s, "s", 0, 1,
             "the motor's lag from command to torque"),
      number("brake_inertia_kg_m2", &ActuatorConfig::brake_inertia_kg_m2, "kg m^2", 0, 1,
             "inertia of pulleys and brake; 0: not counted. This and the next two are for the law "
             "calibrated"),
      number("brake_hysteresis_nm", &ActuatorConfig::brake_hysteresis_nm, "N m", 0, max_torque_nm,
             "half the width of the brake's hysteresis loop"),
      number("brake_release_time_constant_s", &ActuatorConfig::brake_release_time_constant_s, "s",
             0, 100, "the brake's lag while its torque falls; 0: as `brake_time_constant_s`"),
      number("encoder_index_pin", &ActuatorConfig::encoder_index_pin, "", 0, 29,
             "GPIO of the encoder's index, one pulse a turn; 0: none. Save it: it takes effect at "
             "the next start"),
  };
};

/// How the device controls, and what it does when the host goes silent. Set only while disarmed.
struct ControlConfig {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  Law law = Law::paper;
  float beta = 0.5F;
  float speed_bandwidth_hz = 100;
  float motor_torque_cap_nm = max_torque_nm;
  float brake_torque_cap_nm = max_torque_nm;
  float motor_slew_nm_per_s = 0;
  float speed_limit_rad_s = 0;
  float watchdog_s = 0.25F;
  float passive_ramp_s = 0.05F;
  float passive_brake_nm = 0;
  Toggle autonomous = Toggle::off;
  float free_assist_nm = 0;
};
template <>
struct Layout<ControlConfig> {
  static constexpr std::uint8_t id = 0x05;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "control_config";
  static constexpr std::string_view doc =
      "How the device controls, and what it does when the host goes silent. Set only while "
      "disarmed.";
  static constexpr FieldList fields{
      any_number("sequence", &ControlConfig::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &ControlConfig::axis, "", "0: an interface has one axis"),
      choice("law", &ControlConfig::law,
             "how the desired torque is shared between motor and brake"),
      number("beta", &ControlConfig::beta, "", 0, 1, "the brake's share of the desired torque"),
      number("speed_bandwidth_hz", &ControlConfig::speed_bandwidth_hz, "Hz", 1, 1e4F,
             "bandwidth of the speed estimate"),
      number("motor_torque_cap_nm", &ControlConfig::motor_torque_cap_nm, "N m", 0, max_torque_nm,
             "the user's limit, below the actuator's"),
      number("brake_torque_cap_nm", &ControlConfig::brake_torque_cap_nm, "N m", 0, max_torque_nm,
             "the user's limit, below the actuator's"),
      number("motor_slew_nm_per_s", &ControlConfig::motor_slew_nm_per_s, "N m/s", 0, 1e6F,
             "largest rate of the motor's torque; 0 is no limit"),
      number("speed_limit_rad_s", &ControlConfig::speed_limit_rad_s, "rad/s", 0, 1e4F,
             "a faster knob is a fault; 0: no limit"),
      number("watchdog_s", &ControlConfig::watchdog_s, "s", 0.01F, 60,
             "silence of the host after which the knob disarms"),
      number("passive_ramp_s", &ControlConfig::passive_ramp_s, "s", 0, 10,
             "time of the motor's torque to zero when the host is lost"),
      number("passive_brake_nm", &ControlConfig::passive_brake_nm, "N m", 0, max_torque_nm,
             "the brake's torque during the ramp; 0 releases it"),
      choice("autonomous", &ControlConfig::autonomous, "on: no watchdog, plays on without a host"),
      number("free_assist_nm", &ControlConfig::free_assist_nm, "N m", 0, max_torque_nm,
             "friction that the motor cancels where the scene asks for nothing, at most three "
             "quarters of the configured friction, for four turns without a rest at most; law "
             "calibrated only"),
  };
};

/// The board's wiring, and the electrical values of motor and brake; docs/how-to/hardware.md. A pin
/// is the number of its GPIO. Set only while disarmed, then save: it takes effect at the next
/// start. The emulated device uses it where it has Electrics.
struct BoardConfig {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  float supply_v = 12;
  float motor_torque_constant_nm_per_a = 0.05F;
  float motor_current_max_a = 2;
  float motor_current_continuous_a = 1;
  float motor_resistance_ohm = 2.5F;
  float motor_inductance_h = 0.0015F;
  std::uint16_t current_bandwidth_hz = 10000;
  float current_sense_v_per_a = 0.2F;
  float brake_torque_constant_nm_per_a = 0.44F;
  float brake_current_max_a = 0.3F;
  float brake_resistance_ohm = 40;
  float brake_inductance_h = 0;
  Toggle motor_reversed = Toggle::off;
  Toggle confirmed = Toggle::off;
  std::uint8_t brake_continuous_percent = 100;
  std::uint8_t ambient_c = 25;
  std::uint8_t supply_sense_ratio = 11;
  std::uint8_t encoder_pin = 2;
  std::uint8_t motor_pin = 6;
  std::uint8_t brake_pin = 8;
  std::uint8_t enable_pin = 10;
  std::uint8_t emergency_stop_pin = 11;
  std::uint8_t driver_fault_pin = 12;
  std::uint8_t current_sense_pin = 26;
  std::uint8_t supply_sense_pin = 0;
  std::uint8_t light_pin = 25;
};
template <>
struct Layout<BoardConfig> {
  static constexpr std::uint8_t id = 0x06;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "board_config";
  static constexpr std::string_view doc =
      "The board's wiring, and the electrical values of motor and brake; docs/how-to/hardware.md. "
      "A pin is the number of its GPIO. Set only while disarmed, then save: it takes effect at the "
      "next start. The emulated device uses it where it has Electrics.";
  static constexpr FieldList fields{
      any_number("sequence", &BoardConfig::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &BoardConfig::axis, "", "0: an interface has one axis"),
      number("supply_v", &BoardConfig::supply_v, "V", 3, 60, "voltage of both H-bridges"),
      number("motor_torque_constant_nm_per_a", &BoardConfig::motor_torque_constant_nm_per_a,
             "N m/A", 1e-4F, 100, "the motor's torque an ampere, at the knob"),
      number("motor_current_max_a", &BoardConfig::motor_current_max_a, "A", 0, 100,
             "largest current the firmware asks for; a measured current of 1.5 times as much is a "
             "fault"),
      number(
          "motor_current_continuous_a", &BoardConfig::motor_current_continuous_a, "A", 0, 100,
          "continuous current of the winding in air of 25 degrees; more is given for seconds only"),
      number("motor_resistance_ohm", &BoardConfig::motor_resistance_ohm, "ohm", 0.001F, 1000,
             "resistance of the winding"),
      number("motor_inductance_h", &BoardConfig::motor_inductance_h, "H", 1e-6F, 1,
             "inductance of the winding"),
      number("current_bandwidth_hz", &BoardConfig::current_bandwidth_hz, "Hz", 1, 65535,
             "of the current loop; on a pico held at a tenth of the control rate"),
      number("current_sense_v_per_a", &BoardConfig::current_sense_v_per_a, "V/A", 0.001F, 10,
             "of the current sensor; its zero is measured while the power is off"),
      number("brake_torque_constant_nm_per_a", &BoardConfig::brake_torque_constant_nm_per_a,
             "N m/A", 1e-4F, 1000, "the brake's torque an ampere, on its pulley"),
      number("brake_current_max_a", &BoardConfig::brake_current_max_a, "A", 0, 100,
             "largest current of the coil"),
      number("brake_resistance_ohm", &BoardConfig::brake_resistance_ohm, "ohm", 0.001F, 1e4F,
             "resistance of the coil"),
      number("brake_inductance_h", &BoardConfig::brake_inductance_h, "H", 0, 1000,
             "inductance of the coil. Above 0 the bridge drives the coil both ways, with the "
             "actuator's brake_time_constant_s. 0: the current follows as the coil lets it"),
      choice("motor_reversed", &BoardConfig::motor_reversed,
             "on: a current into the first motor pin turns the knob to smaller angles"),
      choice("confirmed", &BoardConfig::confirmed,
             "on: somebody has checked the parts. A real board holds torques and speed low until "
             "this is on and `values_are` is not `assumed`. Acts at once"),
      number("brake_continuous_percent", &BoardConfig::brake_continuous_percent, "%", 0, 100,
             "continuous current of the coil in air of 25 degrees, of brake_current_max_a; more is "
             "given for a while only"),
      number("ambient_c", &BoardConfig::ambient_c, "degree C", 0, 100,
             "highest temperature of the air around motor and brake"),
      number("supply_sense_ratio", &BoardConfig::supply_sense_ratio, "", 1, 255,
             "of the divider at supply_sense_pin: the supply's voltage over the pin's"),
      number("encoder_pin", &BoardConfig::encoder_pin, "", 0, 28, "GPIO of A; B is the next one"),
      number("motor_pin", &BoardConfig::motor_pin, "", 0, 28,
             "GPIO of the first input of the motor's bridge, even; the second is the next one"),
      number("brake_pin", &BoardConfig::brake_pin, "", 0, 28,
             "GPIO of the first input of the brake's bridge, even; the second is the next one"),
      number("enable_pin", &BoardConfig::enable_pin, "", 0, 29,
             "GPIO, high while the power stages are on"),
      number("emergency_stop_pin", &BoardConfig::emergency_stop_pin, "", 0, 29,
             "GPIO, low to run; an open wire stops"),
      number("driver_fault_pin", &BoardConfig::driver_fault_pin, "", 0, 29,
             "GPIO, low when a bridge reports an error"),
      number("current_sense_pin", &BoardConfig::current_sense_pin, "", 26, 28,
             "GPIO of the motor's current sensor"),
      number("supply_sense_pin", &BoardConfig::supply_sense_pin, "", 0, 28,
             "GPIO of a divider at the supply, 26 to 28; the supply is then watched. 0: none"),
      number("light_pin", &BoardConfig::light_pin, "", 0, 29, "GPIO of the status light"),
  };
};

/// Permissions of games on the game interface, and the scale of their torques;
/// docs/reference/games.md. Set only while disarmed.
struct GameConfig {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  Toggle enabled = Toggle::on;
  float range_deg = 900;
  float torque_max_nm = max_torque_nm;
  float gain = 1;
  float spring_gain = 20;
  float speed_full_rad_s = 20;
  float acceleration_full_rad_s2 = 3000;
  float blend_s = 0.002F;
  float silence_s = 10;
  Toggle join_updates = Toggle::on;
  float end_stiffness_nm_per_rad = 0;
  Personality personality = Personality::game_controller;
  DialUse dial_use = DialUse::wheel;
  std::uint8_t dial_detents = 24;
  float dial_torque_nm = 0.02F;
  std::uint8_t own_damper_percent = 0;
  std::uint8_t own_friction_percent = 0;
  std::uint8_t own_inertia_percent = 0;
  std::uint8_t own_spring_percent = 0;
  std::uint8_t constants_gain_percent = 100;
  std::uint8_t waves_gain_percent = 100;
  std::uint8_t springs_gain_percent = 100;
  std::uint8_t dampers_gain_percent = 100;
  std::uint8_t inertias_gain_percent = 100;
  std::uint8_t frictions_gain_percent = 100;
  std::uint8_t torque_max_percent = 100;
  Toggle reversed = Toggle::off;
  Toggle dial_coarse = Toggle::off;
  std::uint8_t dial_fast_steps = 1;
  Toggle remote_wakeup = Toggle::off;
};
template <>
struct Layout<GameConfig> {
  static constexpr std::uint8_t id = 0x07;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "game_config";
  static constexpr std::string_view doc =
      "Permissions of games on the game interface, and the scale of their torques; "
      "docs/reference/games.md. Set only while disarmed.";
  static constexpr FieldList fields{
      any_number("sequence", &GameConfig::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &GameConfig::axis, "", "0: an interface has one axis"),
      choice("enabled", &GameConfig::enabled, "off: games see the axis but move nothing"),
      number("range_deg", &GameConfig::range_deg, "degree", 10, 36000,
             "angle from one end of the game's axis to the other, round angle 0"),
      number("torque_max_nm", &GameConfig::torque_max_nm, "N m", 0, max_torque_nm,
             "torque at full level, and the limit of all effects together; never more than the "
             "motor's"),
      number("gain", &GameConfig::gain, "", 0, 1,
             "strength of all games' effects, times their own gains"),
      number("spring_gain", &GameConfig::spring_gain, "", 0, 1000,
             "1: a full spring reaches full torque at the end of the axis"),
      number("speed_full_rad_s", &GameConfig::speed_full_rad_s, "rad/s", 0.1F, 1e4F,
             "speed at which a full damper reaches full torque"),
      number("acceleration_full_rad_s2", &GameConfig::acceleration_full_rad_s2, "rad/s^2", 1, 1e7F,
             "acceleration at which a full inertia reaches full torque"),
      number("blend_s", &GameConfig::blend_s, "s", 0, 0.1F,
             "in which a change of an effect, its beginning or its end takes full effect"),
      number("silence_s", &GameConfig::silence_s, "s", 0, 3600,
             "silence of the game after which forces without end stop; 0: never"),
      choice("join_updates", &GameConfig::join_updates,
             "on: updates of a steady force are joined by lines, half a frame of the game late; "
             "hits pass"),
      number("end_stiffness_nm_per_rad", &GameConfig::end_stiffness_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad,
             "stiffness of walls at both ends of the axis, while a game has the actuator; 0: none"),
      choice("personality", &GameConfig::personality,
             "the computer's view of the knob; save it: it takes effect at the next start"),
      choice("dial_use", &GameConfig::dial_use, "use of a dial"),
      number("dial_detents", &GameConfig::dial_detents, "", 1, 240, "detents of a dial in a turn"),
      number("dial_torque_nm", &GameConfig::dial_torque_nm, "N m", 0, max_torque_nm,
             "torque between two detents of a dial, held down to a stable one; 0: it turns freely"),
      number("own_damper_percent", &GameConfig::own_damper_percent, "", 0, 100,
             "share of a full damper, always felt while somebody turns the knob, with a game and "
             "without"),
      number("own_friction_percent", &GameConfig::own_friction_percent, "", 0, 100,
             "share of full torque as friction, always felt, with a game and without"),
      number("own_inertia_percent", &GameConfig::own_inertia_percent, "", 0, 100,
             "share of a full inertia, always felt, with a game and without"),
      number("own_spring_percent", &GameConfig::own_spring_percent, "", 0, 100,
             "share of a full spring to the middle, while no game plays"),
      number("constants_gain_percent", &GameConfig::constants_gain_percent, "", 0, 100,
             "strength of games' constant forces and ramps"),
      number("waves_gain_percent", &GameConfig::waves_gain_percent, "", 0, 100,
             "strength of games' waves"),
      number("springs_gain_percent", &GameConfig::springs_gain_percent, "", 0, 100,
             "strength of games' springs"),
      number("dampers_gain_percent", &GameConfig::dampers_gain_percent, "", 0, 100,
             "strength of games' dampers"),
      number("inertias_gain_percent", &GameConfig::inertias_gain_percent, "", 0, 100,
             "strength of games' inertias"),
      number("frictions_gain_percent", &GameConfig::frictions_gain_percent, "", 0, 100,
             "strength of games' frictions"),
      number("torque_max_percent", &GameConfig::torque_max_percent, "", 1, 100,
             "share of the motor's torque that all effects together get at most; the smaller of "
             "this and `torque_max_nm` counts"),
      choice("reversed", &GameConfig::reversed,
             "on: axis, games' forces and the dial go the other way"),
      choice("dial_coarse", &GameConfig::dial_coarse,
             "on: a dial tells whole detents, although the host asks for fine ones"),
      number("dial_fast_steps", &GameConfig::dial_fast_steps, "", 1, 20,
             "steps of a wheel for a detent that is turned at two turns a second or faster; in "
             "proportion below, down to one"),
      choice(
          "remote_wakeup", &GameConfig::remote_wakeup,
          "on: turning or pressing wakes a host that sleeps, if it lets; from the next start on"),
  };
};

/// The curve of the shaft's spring beyond its first straight piece. Up to the first knee the
/// stiffness is the actuator's `spring_stiffness_nm_per_rad`. Both directions are alike. Set only
/// while disarmed.
struct ShaftConfig {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  float knee_1_rad = 0;
  float knee_1_nm_per_rad = 0;
  float knee_2_rad = 0;
  float knee_2_nm_per_rad = 0;
  float knee_3_rad = 0;
  float knee_3_nm_per_rad = 0;
  float knee_4_rad = 0;
  float knee_4_nm_per_rad = 0;
};
template <>
struct Layout<ShaftConfig> {
  static constexpr std::uint8_t id = 0x0A;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "shaft_config";
  static constexpr std::string_view doc =
      "The curve of the shaft's spring beyond its first straight piece. Up to the first knee the "
      "stiffness is the actuator's `spring_stiffness_nm_per_rad`. Both directions are alike. Set "
      "only while disarmed.";
  static constexpr FieldList fields{
      any_number("sequence", &ShaftConfig::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &ShaftConfig::axis, "", "0: an interface has one axis"),
      number("knee_1_rad", &ShaftConfig::knee_1_rad, "rad", 0, 100,
             "twist of the first knee; 0: the spring is one straight line"),
      number("knee_1_nm_per_rad", &ShaftConfig::knee_1_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad,
             "stiffness beyond this knee; more than 0, so that the torque always grows"),
      number("knee_2_rad", &ShaftConfig::knee_2_rad, "rad", 0, 100,
             "twist of the second knee, beyond the first; 0: none"),
      number("knee_2_nm_per_rad", &ShaftConfig::knee_2_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad,
             "stiffness beyond this knee; more than 0, so that the torque always grows"),
      number("knee_3_rad", &ShaftConfig::knee_3_rad, "rad", 0, 100, "twist of the third knee"),
      number("knee_3_nm_per_rad", &ShaftConfig::knee_3_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad,
             "stiffness beyond this knee; more than 0, so that the torque always grows"),
      number("knee_4_rad", &ShaftConfig::knee_4_rad, "rad", 0, 100, "twist of the fourth knee"),
      number("knee_4_nm_per_rad", &ShaftConfig::knee_4_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad,
             "stiffness beyond this knee; more than 0, so that the torque always grows"),
  };
};

/// How well the values of actuator and shaft are known, and since when. It belongs to the values
/// that the device has when it takes this report. When one of them changes, `values_are` reads
/// `assumed`. A `sigma` is the standard uncertainty of a value; 0: it was not measured. Set only
/// while disarmed.
struct CalibrationConfig {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  Basis values_are = Basis::assumed;
  std::uint32_t calibrated_unix_s = 0;
  float ambient_k = 0;
  float calibrated_rate_hz = 0;
  float sigma_knob_inertia_kg_m2 = 0;
  float sigma_knob_coulomb_nm = 0;
  float sigma_knob_viscous_nm_s_per_rad = 0;
  float sigma_spring_stiffness_nm_per_rad = 0;
  float sigma_knee_1_rad = 0;
  float sigma_knee_1_nm_per_rad = 0;
  float sigma_brake_drag_nm = 0;
  float sigma_brake_time_constant_s = 0;
  float sigma_brake_release_time_constant_s = 0;
  float sigma_brake_inertia_kg_m2 = 0;
  float sigma_brake_hysteresis_nm = 0;
  std::uint8_t sigma_motor_resistance_permille = 0;
  std::uint8_t sigma_motor_inductance_permille = 0;
  std::uint8_t sigma_motor_torque_constant_permille = 0;
};
template <>
struct Layout<CalibrationConfig> {
  static constexpr std::uint8_t id = 0x0B;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "calibration_config";
  static constexpr std::string_view doc =
      "How well the values of actuator and shaft are known, and since when. It belongs to the "
      "values that the device has when it takes this report. When one of them changes, "
      "`values_are` reads `assumed`. A `sigma` is the standard uncertainty of a value; 0: it was "
      "not measured. Set only while disarmed.";
  static constexpr FieldList fields{
      any_number("sequence", &CalibrationConfig::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &CalibrationConfig::axis, "", "0: an interface has one axis"),
      choice("values_are", &CalibrationConfig::values_are,
             "source of the values of actuator and shaft"),
      number("calibrated_unix_s", &CalibrationConfig::calibrated_unix_s, "", 0, 4294967295,
             "time of the measurement, in seconds since 1970; 0: never"),
      number("ambient_k", &CalibrationConfig::ambient_k, "K", 0, 1000,
             "the room's temperature, as the user gave it; 0: not given"),
      number("calibrated_rate_hz", &CalibrationConfig::calibrated_rate_hz, "Hz", 0, 1e6F,
             "control rate of the measurement"),
      number("sigma_knob_inertia_kg_m2", &CalibrationConfig::sigma_knob_inertia_kg_m2, "kg m^2", 0,
             1e6F, "of `knob_inertia_kg_m2`"),
      number("sigma_knob_coulomb_nm", &CalibrationConfig::sigma_knob_coulomb_nm, "N m", 0, 1e6F,
             "of `knob_coulomb_nm`"),
      number("sigma_knob_viscous_nm_s_per_rad", &CalibrationConfig::sigma_knob_viscous_nm_s_per_rad,
             "N m s/rad", 0, 1e6F, "of `knob_viscous_nm_s_per_rad`"),
      number("sigma_spring_stiffness_nm_per_rad",
             &CalibrationConfig::sigma_spring_stiffness_nm_per_rad, "N m/rad", 0, 1e6F,
             "of `spring_stiffness_nm_per_rad`"),
      number("sigma_knee_1_rad", &CalibrationConfig::sigma_knee_1_rad, "rad", 0, 1e6F,
             "of `knee_1_rad`"),
      number("sigma_knee_1_nm_per_rad", &CalibrationConfig::sigma_knee_1_nm_per_rad, "N m/rad", 0,
             1e6F, "of `knee_1_nm_per_rad`"),
      number("sigma_brake_drag_nm", &CalibrationConfig::sigma_brake_drag_nm, "N m", 0, 1e6F,
             "of `brake_drag_nm`"),
      number("sigma_brake_time_constant_s", &CalibrationConfig::sigma_brake_time_constant_s, "s", 0,
             1e6F, "of `brake_time_constant_s`"),
      number("sigma_brake_release_time_constant_s",
             &CalibrationConfig::sigma_brake_release_time_constant_s, "s", 0, 1e6F,
             "of `brake_release_time_constant_s`"),
      number("sigma_brake_inertia_kg_m2", &CalibrationConfig::sigma_brake_inertia_kg_m2, "kg m^2",
             0, 1e6F, "of `brake_inertia_kg_m2`"),
      number("sigma_brake_hysteresis_nm", &CalibrationConfig::sigma_brake_hysteresis_nm, "N m", 0,
             1e6F, "of `brake_hysteresis_nm`"),
      number("sigma_motor_resistance_permille", &CalibrationConfig::sigma_motor_resistance_permille,
             "", 0, 255,
             "standard uncertainty of the board's `motor_resistance_ohm` in thousandths of it; 0: "
             "it was not measured"),
      number("sigma_motor_inductance_permille", &CalibrationConfig::sigma_motor_inductance_permille,
             "", 0, 255,
             "standard uncertainty of the board's `motor_inductance_h` in thousandths of it; 0: it "
             "was not measured"),
      number("sigma_motor_torque_constant_permille",
             &CalibrationConfig::sigma_motor_torque_constant_permille, "", 0, 255,
             "standard uncertainty of the board's `motor_torque_constant_nm_per_a` in thousandths "
             "of it; 0: it was not measured"),
  };
};

// The sizes as literals: a change of the wire must be seen in a diff.
static_assert(wire_size<ActuatorConfig>() == 62);
static_assert(wire_size<ControlConfig>() == 45);
static_assert(wire_size<BoardConfig>() == 63);
static_assert(wire_size<GameConfig>() == 63);
static_assert(wire_size<ShaftConfig>() == 35);
static_assert(wire_size<CalibrationConfig>() == 63);

}  // namespace torsio::protocol
