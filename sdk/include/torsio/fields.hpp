/// @file
/// The fields of every public structure by name, with unit, range and sentence, and the names of
/// every enumeration's values: for tools that show, keep or edit them.
///
/// Printed from the field lists in firmware/protocol/definition/ and emulator/definition/ by `./dev
/// generate`; change those instead.
#pragma once

#include <array>
#include <string_view>

#include "torsio/config.hpp"
#include "torsio/emulator_options.hpp"
#include "torsio/field.hpp"
#include "torsio/scene.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

template <>
struct Names<Side> {
  static constexpr std::array<std::string_view, 2> values{"above", "below"};
};
template <>
struct Names<Waveform> {
  static constexpr std::array<std::string_view, 5> values{"sine", "square", "triangle",
                                                          "sawtooth_up", "sawtooth_down"};
};
template <>
struct Names<DetentProfile> {
  static constexpr std::array<std::string_view, 3> values{"sine", "linear", "click"};
};
template <>
struct Names<Grain> {
  static constexpr std::array<std::string_view, 4> values{"sine", "square", "triangle", "noise"};
};
template <>
struct Names<Ends> {
  static constexpr std::array<std::string_view, 2> values{"hold", "repeat"};
};
template <>
struct Names<Law> {
  static constexpr std::array<std::string_view, 5> values{"paper", "compensated", "parallel",
                                                          "motor_only", "calibrated"};
};
template <>
struct Names<Basis> {
  static constexpr std::array<std::string_view, 3> values{"assumed", "stated", "measured"};
};
template <>
struct Names<Personality> {
  static constexpr std::array<std::string_view, 2> values{"game_controller", "dial"};
};
template <>
struct Names<DialUse> {
  static constexpr std::array<std::string_view, 7> values{
      "wheel", "pan", "volume", "radial", "wheel_or_pan", "wheel_or_volume", "volume_or_wheel"};
};
template <>
struct Names<State> {
  static constexpr std::array<std::string_view, 4> values{"disarmed", "armed", "fault",
                                                          "disconnected"};
};
template <>
struct Names<Owner> {
  static constexpr std::array<std::string_view, 4> values{"none", "sdk", "game", "dial"};
};
template <>
struct Names<GameEffectKind> {
  static constexpr std::array<std::string_view, 12> values{
      "none",        "constant",      "ramp",   "square", "sine",    "triangle",
      "sawtooth_up", "sawtooth_down", "spring", "damper", "inertia", "friction"};
};
template <>
struct Names<GameEffectState> {
  static constexpr std::array<std::string_view, 3> values{"stopped", "playing", "set_aside"};
};
template <>
struct Names<ResetCause> {
  static constexpr std::array<std::string_view, 7> values{
      "unknown", "power", "brown_out", "reset_pin", "watchdog", "hard_fault", "stack"};
};
template <>
struct Names<Centre> {
  static constexpr std::array<std::string_view, 3> values{"power_up", "awaits_index", "index"};
};
template <>
struct Names<DisarmReason> {
  static constexpr std::array<std::string_view, 10> values{
      "order",   "watchdog",        "deadline_missed",    "fault",    "game_idle", "disconnected",
      "unknown", "excitation_over", "excitation_stopped", "dial_idle"};
};

template <>
struct Fields<Timing> {
  static constexpr std::string_view name = "Timing";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("delay_s", &Timing::delay_s, "s", 0.0, 1e5, "silence after the scene begins"),
        field("duration_s", &Timing::duration_s, "s", 0.0, 1e5, "0 plays without end"),
        field("attack_level", &Timing::attack_level, "", 0.0, 1.0,
              "share of the strength at the start"),
        field("attack_s", &Timing::attack_s, "s", 0.0, 1e5, "time to full strength"),
        field("fade_level", &Timing::fade_level, "", 0.0, 1.0, "share of the strength at the end"),
        field("fade_s", &Timing::fade_s, "s", 0.0, 1e5, "fading time before the end"));
  }
};
template <>
struct Fields<Wall> {
  static constexpr std::string_view name = "Wall";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("angle_rad", &Wall::angle_rad, "rad", -kNoLimit, kNoLimit, "the wall's surface"),
        field("side", &Wall::side, "", -kNoLimit, kNoLimit,
              "on which side of the surface the wall is solid"),
        field("stiffness_nm_per_rad", &Wall::stiffness_nm_per_rad, "N m/rad", 0.0, 1e6,
              "torque per depth"),
        field("damping_nm_s_per_rad", &Wall::damping_nm_s_per_rad, "N m s/rad", 0.0, 1000.0,
              "torque per inward speed"));
  }
};
template <>
struct Fields<Spring> {
  static constexpr std::string_view name = "Spring";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("angle_rad", &Spring::angle_rad, "rad", -kNoLimit, kNoLimit, "rest angle"),
                 field("stiffness_nm_per_rad", &Spring::stiffness_nm_per_rad, "N m/rad", 0.0, 1e6,
                       "torque per distance from the rest angle"),
                 field("deadband_rad", &Spring::deadband_rad, "rad", 0.0, 1000.0,
                       "no torque within this distance of the rest angle"),
                 field("torque_limit_nm", &Spring::torque_limit_nm, "N m", 0.0, 100.0,
                       "the torque does not grow beyond this"));
  }
};
template <>
struct Fields<Damper> {
  static constexpr std::string_view name = "Damper";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("damping_nm_s_per_rad", &Damper::damping_nm_s_per_rad, "N m s/rad", 0.0,
                       1000.0, "torque per speed"),
                 field("torque_limit_nm", &Damper::torque_limit_nm, "N m", 0.0, 100.0,
                       "the torque does not grow beyond this"));
  }
};
template <>
struct Fields<Friction> {
  static constexpr std::string_view name = "Friction";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("torque_nm", &Friction::torque_nm, "N m", 0.0, 100.0, "while sliding"),
                 field("stiffness_nm_per_rad", &Friction::stiffness_nm_per_rad, "N m/rad", 1e-6,
                       1e6, "while sticking"));
  }
};
template <>
struct Fields<Inertia> {
  static constexpr std::string_view name = "Inertia";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("inertia_kg_m2", &Inertia::inertia_kg_m2, "kg m^2", 0.0, 10.0,
                       "torque per acceleration"),
                 field("torque_limit_nm", &Inertia::torque_limit_nm, "N m", 0.0, 100.0,
                       "the torque does not grow beyond this"));
  }
};
template <>
struct Fields<Constant> {
  static constexpr std::string_view name = "Constant";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("torque_nm", &Constant::torque_nm, "N m", -100.0, 100.0, "at full strength"),
                 field("timing", &Constant::timing, "", -kNoLimit, kNoLimit,
                       "when it plays, and its envelope"));
  }
};
template <>
struct Fields<Ramp> {
  static constexpr std::string_view name = "Ramp";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("start_torque_nm", &Ramp::start_torque_nm, "N m", -100.0, 100.0,
              "when the duration begins"),
        field("end_torque_nm", &Ramp::end_torque_nm, "N m", -100.0, 100.0, "when it ends"),
        field("timing", &Ramp::timing, "", -kNoLimit, kNoLimit, "when it plays, and its envelope"));
  }
};
template <>
struct Fields<Periodic> {
  static constexpr std::string_view name = "Periodic";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("waveform", &Periodic::waveform, "", -kNoLimit, kNoLimit,
              "starts at 0 and rises; the square starts high"),
        field("amplitude_nm", &Periodic::amplitude_nm, "N m", 0.0, 100.0,
              "of the wave, from its middle"),
        field("offset_nm", &Periodic::offset_nm, "N m", -100.0, 100.0, "the wave's middle"),
        field("frequency_hz", &Periodic::frequency_hz, "Hz", 0.0, 1e4,
              "at most half the control rate"),
        field("phase_turns", &Periodic::phase_turns, "turn", 0.0, 1.0,
              "where in the period it starts"),
        field("timing", &Periodic::timing, "", -kNoLimit, kNoLimit,
              "when it plays, and its envelope"));
  }
};
template <>
struct Fields<Detents> {
  static constexpr std::string_view name = "Detents";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("angle_rad", &Detents::angle_rad, "rad", -kNoLimit, kNoLimit,
                       "where one of the notches is"),
                 field("per_turn", &Detents::per_turn, "", -kNoLimit, kNoLimit,
                       "notches in a turn, > 0; need not be whole"),
                 field("pitch_rad", &Detents::pitch_rad, "rad", -kNoLimit, kNoLimit,
                       "distance of two notches, > 0"),
                 field("torque_nm", &Detents::torque_nm, "N m", 0.0, 100.0, "largest torque"),
                 field("profile", &Detents::profile, "", -kNoLimit, kNoLimit,
                       "torque from one notch to the next"),
                 field("width", &Detents::width, "", 0.01, 1.0, "share of the pitch; click only"));
  }
};
template <>
struct Fields<EndStops> {
  static constexpr std::string_view name = "EndStops";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("lower_rad", &EndStops::lower_rad, "rad", -kNoLimit, kNoLimit,
                       "surface of the lower wall"),
                 field("upper_rad", &EndStops::upper_rad, "rad", -kNoLimit, kNoLimit,
                       "surface of the upper one, not below the lower one"),
                 field("stiffness_nm_per_rad", &EndStops::stiffness_nm_per_rad, "N m/rad", 0.0, 1e6,
                       "torque per depth, of either wall"),
                 field("damping_nm_s_per_rad", &EndStops::damping_nm_s_per_rad, "N m s/rad", 0.0,
                       1000.0, "torque per inward speed, of either wall"));
  }
};
template <>
struct Fields<Texture> {
  static constexpr std::string_view name = "Texture";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("grains_per_turn", &Texture::grains_per_turn, "", 1.0, 65535.0,
                       "at most half the encoder's counts"),
                 field("torque_nm", &Texture::torque_nm, "N m", 0.0, 100.0, "of the highest grain"),
                 field("grain", &Texture::grain, "", -kNoLimit, kNoLimit, "shape of a grain"),
                 field("seed", &Texture::seed, "", -kNoLimit, kNoLimit,
                       "another seed, another surface; noise only"));
  }
};
template <>
struct Fields<Curve> {
  static constexpr std::string_view name = "Curve";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("torque_nm", &Curve::torque_nm, "N m", -kNoLimit, kNoLimit,
              "at least 2 points; all curves of a scene share 1024"),
        field("angle_rad", &Curve::angle_rad, "rad", -kNoLimit, kNoLimit,
              "angle of the first point"),
        field("span_rad", &Curve::span_rad, "rad", 0.0, 804.247719318987,
              "from the first point to the last; at least two of the encoder's counts"),
        field("ends", &Curve::ends, "", -kNoLimit, kNoLimit, "its torque outside the span"));
  }
};
template <>
struct Fields<Impact> {
  static constexpr std::string_view name = "Impact";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("angle_rad", &Impact::angle_rad, "rad", -kNoLimit, kNoLimit,
              "the surface, usually a wall's"),
        field("side", &Impact::side, "", -kNoLimit, kNoLimit,
              "on which side of the surface it is solid"),
        field("strength_nm_s_per_rad", &Impact::strength_nm_s_per_rad, "N m s/rad", 0.0, 1000.0,
              "the sine's torque at first, per speed of impact"),
        field("frequency_hz", &Impact::frequency_hz, "Hz", 1.0, 1000.0,
              "of the sine; at most half the control rate"),
        field("decay_s", &Impact::decay_s, "s", 1e-4, 0.1, "in which the sine falls to 1/e"),
        field("pulse_nm_s_per_rad", &Impact::pulse_nm_s_per_rad, "N m s/rad", 0.0, 1000.0,
              "the pulse's torque, per speed of impact"),
        field("pulse_s", &Impact::pulse_s, "s", 0.0, 0.1,
              "how long the pulse lasts; it ends where the knob stops"),
        field("torque_limit_nm", &Impact::torque_limit_nm, "N m", 0.0, 100.0,
              "the torque does not grow beyond this"));
  }
};
template <>
struct Fields<LocalModel> {
  static constexpr std::string_view name = "LocalModel";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("torque_nm", &LocalModel::torque_nm, "N m", -100.0, 100.0,
              "at the reference, at rest"),
        field("angle_rad", &LocalModel::angle_rad, "rad", -kNoLimit, kNoLimit,
              "reference position"),
        field("stiffness_nm_per_rad", &LocalModel::stiffness_nm_per_rad, "N m/rad", 0.0, 1e6, ""),
        field("damping_nm_s_per_rad", &LocalModel::damping_nm_s_per_rad, "N m s/rad", 0.0, 1000.0,
              ""),
        field("deadline_s", &LocalModel::deadline_s, "s", 0.0, 60.0,
              "how long it holds; 0 ends the stream in good order"));
  }
};
template <>
struct Fields<Excitation> {
  static constexpr std::string_view name = "Excitation";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("duration_s", &Excitation::duration_s, "s", 0.001, 60.0,
              "until it disarms, unless the next one comes first"),
        field("travel_rad", &Excitation::travel_rad, "rad", 0.001, 1000.0,
              "further from its first angle disarms"),
        field("speed_limit_rad_s", &Excitation::speed_limit_rad_s, "rad/s", 0.1, 1e4,
              "faster disarms"),
        field("torque_limit_nm", &Excitation::torque_limit_nm, "N m", 0.0, 100.0,
              "largest torque of the motor"),
        field("motor_command_nm", &Excitation::motor_command_nm, "N m", -100.0, 100.0,
              "where the motor goes"),
        field("brake_command_nm", &Excitation::brake_command_nm, "N m", 0.0, 100.0,
              "where the brake's command goes"),
        field("ramp_s", &Excitation::ramp_s, "s", 0.0, 60.0, "time that both take; 0 is a step"),
        field("sine_nm", &Excitation::sine_nm, "N m", 0.0, 100.0,
              "amplitude of the sine on top of `motor_command_nm`"),
        field("sine_begin_hz", &Excitation::sine_begin_hz, "Hz", 0.0, 1000.0,
              "its frequency at the beginning"),
        field("sine_end_hz", &Excitation::sine_end_hz, "Hz", 0.0, 1000.0, "and after `duration_s`"),
        field("stiffness_nm_per_rad", &Excitation::stiffness_nm_per_rad, "N m/rad", 0.0, 1e6,
              "of the servo"),
        field("damping_nm_s_per_rad", &Excitation::damping_nm_s_per_rad, "N m s/rad", 0.0, 1000.0,
              "of the servo"),
        field("servo_rad_s", &Excitation::servo_rad_s, "rad/s", -1000.0, 1000.0,
              "speed of the servo's reference"));
  }
};
template <>
struct Fields<ActuatorConfig> {
  static constexpr std::string_view name = "ActuatorConfig";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("motor_torque_max_nm", &ActuatorConfig::motor_torque_max_nm, "N m", 0.0, 100.0,
              "largest torque of the motor"),
        field("brake_torque_max_nm", &ActuatorConfig::brake_torque_max_nm, "N m", 0.0, 100.0,
              "largest torque of the brake"),
        field("brake_torque_min_nm", &ActuatorConfig::brake_torque_min_nm, "N m", 0.0, 100.0,
              "least brake torque that the sensor assumes"),
        field("brake_drag_nm", &ActuatorConfig::brake_drag_nm, "N m", 0.0, 100.0,
              "drag of the brake without current"),
        field("brake_time_constant_s", &ActuatorConfig::brake_time_constant_s, "s", 0.0, 100.0,
              "the brake's lag from command to torque"),
        field("spring_stiffness_nm_per_rad", &ActuatorConfig::spring_stiffness_nm_per_rad,
              "N m/rad", 0.0, 1e6, "stiffness of the shaft between knob and brake"),
        field("counts_per_rev", &ActuatorConfig::counts_per_rev, "", 4.0, 16777216.0,
              "the encoder's counts in a turn"),
        field("counter_bits", &ActuatorConfig::counter_bits, "", 8.0, 32.0,
              "width at which the encoder's counter wraps"),
        field("encoder_reversed", &ActuatorConfig::encoder_reversed, "", -kNoLimit, kNoLimit,
              "on: it counts down where the angle grows"),
        field("knob_inertia_kg_m2", &ActuatorConfig::knob_inertia_kg_m2, "kg m^2", 1e-9, 1.0,
              "inertia of motor and knob; this and the next three bound a game's effects"),
        field("knob_coulomb_nm", &ActuatorConfig::knob_coulomb_nm, "N m", 0.0, 100.0,
              "dry friction of motor and knob"),
        field("knob_viscous_nm_s_per_rad", &ActuatorConfig::knob_viscous_nm_s_per_rad, "N m s/rad",
              0.0, 1000.0, "viscous friction of motor and knob"),
        field("motor_time_constant_s", &ActuatorConfig::motor_time_constant_s, "s", 0.0, 1.0,
              "the motor's lag from command to torque"),
        field("brake_inertia_kg_m2", &ActuatorConfig::brake_inertia_kg_m2, "kg m^2", 0.0, 1.0,
              "inertia of pulleys and brake; 0: not counted. This and the next two are for the law "
              "calibrated"),
        field("brake_hysteresis_nm", &ActuatorConfig::brake_hysteresis_nm, "N m", 0.0, 100.0,
              "half the width of the brake's hysteresis loop"),
        field("brake_release_time_constant_s", &ActuatorConfig::brake_release_time_constant_s, "s",
              0.0, 100.0, "the brake's lag while its torque falls; 0: as `brake_time_constant_s`"),
        field("encoder_index_pin", &ActuatorConfig::encoder_index_pin, "", 0.0, 29.0,
              "GPIO of the encoder's index, one pulse a turn; 0: none. Save it: it takes effect at "
              "the next start"));
  }
};
template <>
struct Fields<ControlConfig> {
  static constexpr std::string_view name = "ControlConfig";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("law", &ControlConfig::law, "", -kNoLimit, kNoLimit,
                       "how the desired torque is shared between motor and brake"),
                 field("beta", &ControlConfig::beta, "", 0.0, 1.0,
                       "the brake's share of the desired torque"),
                 field("speed_bandwidth_hz", &ControlConfig::speed_bandwidth_hz, "Hz", 1.0, 1e4,
                       "bandwidth of the speed estimate"),
                 field("motor_torque_cap_nm", &ControlConfig::motor_torque_cap_nm, "N m", 0.0,
                       100.0, "the user's limit, below the actuator's"),
                 field("brake_torque_cap_nm", &ControlConfig::brake_torque_cap_nm, "N m", 0.0,
                       100.0, "the user's limit, below the actuator's"),
                 field("motor_slew_nm_per_s", &ControlConfig::motor_slew_nm_per_s, "N m/s", 0.0,
                       1e6, "largest rate of the motor's torque; 0 is no limit"),
                 field("speed_limit_rad_s", &ControlConfig::speed_limit_rad_s, "rad/s", 0.0, 1e4,
                       "a faster knob is a fault; 0: no limit"),
                 field("watchdog_s", &ControlConfig::watchdog_s, "s", 0.01, 60.0,
                       "silence of the host after which the knob disarms"),
                 field("passive_ramp_s", &ControlConfig::passive_ramp_s, "s", 0.0, 10.0,
                       "time of the motor's torque to zero when the host is lost"),
                 field("passive_brake_nm", &ControlConfig::passive_brake_nm, "N m", 0.0, 100.0,
                       "the brake's torque during the ramp; 0 releases it"),
                 field("autonomous", &ControlConfig::autonomous, "", -kNoLimit, kNoLimit,
                       "on: no watchdog, plays on without a host"),
                 field("free_assist_nm", &ControlConfig::free_assist_nm, "N m", 0.0, 100.0,
                       "friction that the motor cancels where the scene asks for nothing, at most "
                       "three quarters of the configured friction, for four turns without a rest "
                       "at most; law calibrated only"));
  }
};
template <>
struct Fields<BoardConfig> {
  static constexpr std::string_view name = "BoardConfig";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("supply_v", &BoardConfig::supply_v, "V", 3.0, 60.0, "voltage of both H-bridges"),
        field("motor_torque_constant_nm_per_a", &BoardConfig::motor_torque_constant_nm_per_a,
              "N m/A", 1e-4, 100.0, "the motor's torque an ampere, at the knob"),
        field("motor_current_max_a", &BoardConfig::motor_current_max_a, "A", 0.0, 100.0,
              "largest current the firmware asks for; a measured current of 1.5 times as much is a "
              "fault"),
        field("motor_current_continuous_a", &BoardConfig::motor_current_continuous_a, "A", 0.0,
              100.0,
              "continuous current of the winding in air of 25 degrees; more is given for seconds "
              "only"),
        field("motor_resistance_ohm", &BoardConfig::motor_resistance_ohm, "ohm", 0.001, 1000.0,
              "resistance of the winding"),
        field("motor_inductance_h", &BoardConfig::motor_inductance_h, "H", 1e-6, 1.0,
              "inductance of the winding"),
        field("current_bandwidth_hz", &BoardConfig::current_bandwidth_hz, "Hz", 1.0, 65535.0,
              "of the current loop; on a pico held at a tenth of the control rate"),
        field("current_sense_v_per_a", &BoardConfig::current_sense_v_per_a, "V/A", 0.001, 10.0,
              "of the current sensor; its zero is measured while the power is off"),
        field("brake_torque_constant_nm_per_a", &BoardConfig::brake_torque_constant_nm_per_a,
              "N m/A", 1e-4, 1000.0, "the brake's torque an ampere, on its pulley"),
        field("brake_current_max_a", &BoardConfig::brake_current_max_a, "A", 0.0, 100.0,
              "largest current of the coil"),
        field("brake_resistance_ohm", &BoardConfig::brake_resistance_ohm, "ohm", 0.001, 1e4,
              "resistance of the coil"),
        field("brake_inductance_h", &BoardConfig::brake_inductance_h, "H", 0.0, 1000.0,
              "inductance of the coil. Above 0 the bridge drives the coil both ways, with the "
              "actuator's brake_time_constant_s. 0: the current follows as the coil lets it"),
        field("motor_reversed", &BoardConfig::motor_reversed, "", -kNoLimit, kNoLimit,
              "on: a current into the first motor pin turns the knob to smaller angles"),
        field("confirmed", &BoardConfig::confirmed, "", -kNoLimit, kNoLimit,
              "on: somebody has checked the parts. A real board holds torques and speed low until "
              "this is on and `values_are` is not `assumed`. Acts at once"),
        field("brake_continuous_percent", &BoardConfig::brake_continuous_percent, "%", 0.0, 100.0,
              "continuous current of the coil in air of 25 degrees, of brake_current_max_a; more "
              "is given for a while only"),
        field("ambient_c", &BoardConfig::ambient_c, "degree C", 0.0, 100.0,
              "highest temperature of the air around motor and brake"),
        field("supply_sense_ratio", &BoardConfig::supply_sense_ratio, "", 1.0, 255.0,
              "of the divider at supply_sense_pin: the supply's voltage over the pin's"),
        field("encoder_pin", &BoardConfig::encoder_pin, "", 0.0, 28.0,
              "GPIO of A; B is the next one"),
        field("motor_pin", &BoardConfig::motor_pin, "", 0.0, 28.0,
              "GPIO of the first input of the motor's bridge, even; the second is the next one"),
        field("brake_pin", &BoardConfig::brake_pin, "", 0.0, 28.0,
              "GPIO of the first input of the brake's bridge, even; the second is the next one"),
        field("enable_pin", &BoardConfig::enable_pin, "", 0.0, 29.0,
              "GPIO, high while the power stages are on"),
        field("emergency_stop_pin", &BoardConfig::emergency_stop_pin, "", 0.0, 29.0,
              "GPIO, low to run; an open wire stops"),
        field("driver_fault_pin", &BoardConfig::driver_fault_pin, "", 0.0, 29.0,
              "GPIO, low when a bridge reports an error"),
        field("current_sense_pin", &BoardConfig::current_sense_pin, "", 26.0, 28.0,
              "GPIO of the motor's current sensor"),
        field("supply_sense_pin", &BoardConfig::supply_sense_pin, "", 0.0, 28.0,
              "GPIO of a divider at the supply, 26 to 28; the supply is then watched. 0: none"),
        field("light_pin", &BoardConfig::light_pin, "", 0.0, 29.0, "GPIO of the status light"));
  }
};
template <>
struct Fields<GameConfig> {
  static constexpr std::string_view name = "GameConfig";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("enabled", &GameConfig::enabled, "", -kNoLimit, kNoLimit,
              "off: games see the axis but move nothing"),
        field("range_deg", &GameConfig::range_deg, "degree", 10.0, 36000.0,
              "angle from one end of the game's axis to the other, round angle 0"),
        field("torque_max_nm", &GameConfig::torque_max_nm, "N m", 0.0, 100.0,
              "torque at full level, and the limit of all effects together; never more than the "
              "motor's"),
        field("gain", &GameConfig::gain, "", 0.0, 1.0,
              "strength of all games' effects, times their own gains"),
        field("spring_gain", &GameConfig::spring_gain, "", 0.0, 1000.0,
              "1: a full spring reaches full torque at the end of the axis"),
        field("speed_full_rad_s", &GameConfig::speed_full_rad_s, "rad/s", 0.1, 1e4,
              "speed at which a full damper reaches full torque"),
        field("acceleration_full_rad_s2", &GameConfig::acceleration_full_rad_s2, "rad/s^2", 1.0,
              1e7, "acceleration at which a full inertia reaches full torque"),
        field("blend_s", &GameConfig::blend_s, "s", 0.0, 0.1,
              "in which a change of an effect, its beginning or its end takes full effect"),
        field("silence_s", &GameConfig::silence_s, "s", 0.0, 3600.0,
              "silence of the game after which forces without end stop; 0: never"),
        field("join_updates", &GameConfig::join_updates, "", -kNoLimit, kNoLimit,
              "on: updates of a steady force are joined by lines, half a frame of the game late; "
              "hits pass"),
        field(
            "end_stiffness_nm_per_rad", &GameConfig::end_stiffness_nm_per_rad, "N m/rad", 0.0, 1e6,
            "stiffness of walls at both ends of the axis, while a game has the actuator; 0: none"),
        field("personality", &GameConfig::personality, "", -kNoLimit, kNoLimit,
              "the computer's view of the knob; save it: it takes effect at the next start"),
        field("dial_use", &GameConfig::dial_use, "", -kNoLimit, kNoLimit, "use of a dial"),
        field("dial_detents", &GameConfig::dial_detents, "", 1.0, 240.0,
              "detents of a dial in a turn"),
        field(
            "dial_torque_nm", &GameConfig::dial_torque_nm, "N m", 0.0, 100.0,
            "torque between two detents of a dial, held down to a stable one; 0: it turns freely"),
        field("own_damper_percent", &GameConfig::own_damper_percent, "", 0.0, 100.0,
              "share of a full damper, always felt while somebody turns the knob, with a game and "
              "without"),
        field("own_friction_percent", &GameConfig::own_friction_percent, "", 0.0, 100.0,
              "share of full torque as friction, always felt, with a game and without"),
        field("own_inertia_percent", &GameConfig::own_inertia_percent, "", 0.0, 100.0,
              "share of a full inertia, always felt, with a game and without"),
        field("own_spring_percent", &GameConfig::own_spring_percent, "", 0.0, 100.0,
              "share of a full spring to the middle, while no game plays"),
        field("constants_gain_percent", &GameConfig::constants_gain_percent, "", 0.0, 100.0,
              "strength of games' constant forces and ramps"),
        field("waves_gain_percent", &GameConfig::waves_gain_percent, "", 0.0, 100.0,
              "strength of games' waves"),
        field("springs_gain_percent", &GameConfig::springs_gain_percent, "", 0.0, 100.0,
              "strength of games' springs"),
        field("dampers_gain_percent", &GameConfig::dampers_gain_percent, "", 0.0, 100.0,
              "strength of games' dampers"),
        field("inertias_gain_percent", &GameConfig::inertias_gain_percent, "", 0.0, 100.0,
              "strength of games' inertias"),
        field("frictions_gain_percent", &GameConfig::frictions_gain_percent, "", 0.0, 100.0,
              "strength of games' frictions"),
        field("torque_max_percent", &GameConfig::torque_max_percent, "", 1.0, 100.0,
              "share of the motor's torque that all effects together get at most; the smaller of "
              "this and `torque_max_nm` counts"),
        field("reversed", &GameConfig::reversed, "", -kNoLimit, kNoLimit,
              "on: axis, games' forces and the dial go the other way"),
        field("dial_coarse", &GameConfig::dial_coarse, "", -kNoLimit, kNoLimit,
              "on: a dial tells whole detents, although the host asks for fine ones"),
        field("dial_fast_steps", &GameConfig::dial_fast_steps, "", 1.0, 20.0,
              "steps of a wheel for a detent that is turned at two turns a second or faster; in "
              "proportion below, down to one"),
        field("remote_wakeup", &GameConfig::remote_wakeup, "", -kNoLimit, kNoLimit,
              "on: turning or pressing wakes a host that sleeps, if it lets; from the next start "
              "on"));
  }
};
template <>
struct Fields<ShaftConfig> {
  static constexpr std::string_view name = "ShaftConfig";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("knee_1_rad", &ShaftConfig::knee_1_rad, "rad", 0.0, 100.0,
              "twist of the first knee; 0: the spring is one straight line"),
        field("knee_1_nm_per_rad", &ShaftConfig::knee_1_nm_per_rad, "N m/rad", 0.0, 1e6,
              "stiffness beyond this knee; more than 0, so that the torque always grows"),
        field("knee_2_rad", &ShaftConfig::knee_2_rad, "rad", 0.0, 100.0,
              "twist of the second knee, beyond the first; 0: none"),
        field("knee_2_nm_per_rad", &ShaftConfig::knee_2_nm_per_rad, "N m/rad", 0.0, 1e6,
              "stiffness beyond this knee; more than 0, so that the torque always grows"),
        field("knee_3_rad", &ShaftConfig::knee_3_rad, "rad", 0.0, 100.0, "twist of the third knee"),
        field("knee_3_nm_per_rad", &ShaftConfig::knee_3_nm_per_rad, "N m/rad", 0.0, 1e6,
              "stiffness beyond this knee; more than 0, so that the torque always grows"),
        field("knee_4_rad", &ShaftConfig::knee_4_rad, "rad", 0.0, 100.0,
              "twist of the fourth knee"),
        field("knee_4_nm_per_rad", &ShaftConfig::knee_4_nm_per_rad, "N m/rad", 0.0, 1e6,
              "stiffness beyond this knee; more than 0, so that the torque always grows"));
  }
};
template <>
struct Fields<CalibrationConfig> {
  static constexpr std::string_view name = "CalibrationConfig";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("values_are", &CalibrationConfig::values_are, "", -kNoLimit, kNoLimit,
              "source of the values of actuator and shaft"),
        field("calibrated_unix_s", &CalibrationConfig::calibrated_unix_s, "", 0.0, 4294967295.0,
              "time of the measurement, in seconds since 1970; 0: never"),
        field("ambient_k", &CalibrationConfig::ambient_k, "K", 0.0, 1000.0,
              "the room's temperature, as the user gave it; 0: not given"),
        field("calibrated_rate_hz", &CalibrationConfig::calibrated_rate_hz, "Hz", 0.0, 1e6,
              "control rate of the measurement"),
        field("sigma_knob_inertia_kg_m2", &CalibrationConfig::sigma_knob_inertia_kg_m2, "kg m^2",
              0.0, 1e6, "of `knob_inertia_kg_m2`"),
        field("sigma_knob_coulomb_nm", &CalibrationConfig::sigma_knob_coulomb_nm, "N m", 0.0, 1e6,
              "of `knob_coulomb_nm`"),
        field("sigma_knob_viscous_nm_s_per_rad",
              &CalibrationConfig::sigma_knob_viscous_nm_s_per_rad, "N m s/rad", 0.0, 1e6,
              "of `knob_viscous_nm_s_per_rad`"),
        field("sigma_spring_stiffness_nm_per_rad",
              &CalibrationConfig::sigma_spring_stiffness_nm_per_rad, "N m/rad", 0.0, 1e6,
              "of `spring_stiffness_nm_per_rad`"),
        field("sigma_knee_1_rad", &CalibrationConfig::sigma_knee_1_rad, "rad", 0.0, 1e6,
              "of `knee_1_rad`"),
        field("sigma_knee_1_nm_per_rad", &CalibrationConfig::sigma_knee_1_nm_per_rad, "N m/rad",
              0.0, 1e6, "of `knee_1_nm_per_rad`"),
        field("sigma_brake_drag_nm", &CalibrationConfig::sigma_brake_drag_nm, "N m", 0.0, 1e6,
              "of `brake_drag_nm`"),
        field("sigma_brake_time_constant_s", &CalibrationConfig::sigma_brake_time_constant_s, "s",
              0.0, 1e6, "of `brake_time_constant_s`"),
        field("sigma_brake_release_time_constant_s",
              &CalibrationConfig::sigma_brake_release_time_constant_s, "s", 0.0, 1e6,
              "of `brake_release_time_constant_s`"),
        field("sigma_brake_inertia_kg_m2", &CalibrationConfig::sigma_brake_inertia_kg_m2, "kg m^2",
              0.0, 1e6, "of `brake_inertia_kg_m2`"),
        field("sigma_brake_hysteresis_nm", &CalibrationConfig::sigma_brake_hysteresis_nm, "N m",
              0.0, 1e6, "of `brake_hysteresis_nm`"),
        field("sigma_motor_resistance_permille",
              &CalibrationConfig::sigma_motor_resistance_permille, "", 0.0, 255.0,
              "standard uncertainty of the board's `motor_resistance_ohm` in thousandths of it; 0: "
              "it was not measured"),
        field("sigma_motor_inductance_permille",
              &CalibrationConfig::sigma_motor_inductance_permille, "", 0.0, 255.0,
              "standard uncertainty of the board's `motor_inductance_h` in thousandths of it; 0: "
              "it was not measured"),
        field("sigma_motor_torque_constant_permille",
              &CalibrationConfig::sigma_motor_torque_constant_permille, "", 0.0, 255.0,
              "standard uncertainty of the board's `motor_torque_constant_nm_per_a` in thousandths "
              "of it; 0: it was not measured"));
  }
};
template <>
struct Fields<TelemetrySample> {
  static constexpr std::string_view name = "TelemetrySample";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("tick", &TelemetrySample::tick, "", -kNoLimit, kNoLimit,
              "control periods since power-up"),
        field("time_s", &TelemetrySample::time_s, "", -kNoLimit, kNoLimit,
              "tick times the control period"),
        field("position_counts", &TelemetrySample::position_counts, "", -kNoLimit, kNoLimit,
              "from the device's zero, never wraps"),
        field("angle_rad", &TelemetrySample::angle_rad, "", -kNoLimit, kNoLimit,
              "the same as an angle"),
        field("speed_rad_s", &TelemetrySample::speed_rad_s, "", -kNoLimit, kNoLimit, "estimated"),
        field("desired_torque_nm", &TelemetrySample::desired_torque_nm, "", -kNoLimit, kNoLimit,
              "torque that the scene asks for"),
        field("motor_command_nm", &TelemetrySample::motor_command_nm, "", -kNoLimit, kNoLimit,
              "asked of the motor"),
        field("brake_capacity_nm", &TelemetrySample::brake_capacity_nm, "", -kNoLimit, kNoLimit,
              "most that the brake can hold, estimated"),
        field("spring_torque_nm", &TelemetrySample::spring_torque_nm, "", -kNoLimit, kNoLimit,
              "of the shaft on the knob, sensed"),
        field("flags", &TelemetrySample::flags, "", -kNoLimit, kNoLimit,
              "of this sample or a neighbour in the same report"));
  }
};
template <>
struct Fields<ListedDevice> {
  static constexpr std::string_view name = "ListedDevice";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("path", &ListedDevice::path, "", -kNoLimit, kNoLimit, "path for open()"),
        field("serial", &ListedDevice::serial, "", -kNoLimit, kNoLimit, "serial number"),
        field("product", &ListedDevice::product, "", -kNoLimit, kNoLimit, "as its maker calls it"),
        field("board", &ListedDevice::board, "", -kNoLimit, kNoLimit,
              "empty if the device could not be asked"),
        field("transport", &ListedDevice::transport, "", -kNoLimit, kNoLimit,
              "\"hid\" or \"emulated\""),
        field("problem", &ListedDevice::problem, "", -kNoLimit, kNoLimit,
              "why it cannot be opened now; empty if it can"));
  }
};
template <>
struct Fields<DeviceInfo> {
  static constexpr std::string_view name = "DeviceInfo";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("path", &DeviceInfo::path, "", -kNoLimit, kNoLimit, "path for open()"),
        field("serial", &DeviceInfo::serial, "", -kNoLimit, kNoLimit, "serial number"),
        field("product", &DeviceInfo::product, "", -kNoLimit, kNoLimit, "as its maker calls it"),
        field("board", &DeviceInfo::board, "", -kNoLimit, kNoLimit, "\"pico2\", \"emulated\", ..."),
        field("firmware_version", &DeviceInfo::firmware_version, "", -kNoLimit, kNoLimit,
              "\"major.minor.patch\""),
        field("transport", &DeviceInfo::transport, "", -kNoLimit, kNoLimit,
              "\"hid\", \"emulated\" or \"own\", a transport that the program brings"),
        field("protocol_version", &DeviceInfo::protocol_version, "", -kNoLimit, kNoLimit,
              "of the reports"),
        field("fingerprint", &DeviceInfo::fingerprint, "", -kNoLimit, kNoLimit,
              "of the report layouts, the same as the library's"),
        field("axes", &DeviceInfo::axes, "", -kNoLimit, kNoLimit,
              "actuators behind this interface"),
        field("effects", &DeviceInfo::effects, "", -kNoLimit, kNoLimit, "places in a scene"),
        field("curve_points", &DeviceInfo::curve_points, "", -kNoLimit, kNoLimit,
              "shared by all curves of a scene"),
        field("control_rate_hz", &DeviceInfo::control_rate_hz, "", -kNoLimit, kNoLimit,
              "ticks in a second"),
        field("counts_per_rev", &DeviceInfo::counts_per_rev, "", -kNoLimit, kNoLimit,
              "of the encoder"),
        field("torque_step_nm", &DeviceInfo::torque_step_nm, "", -kNoLimit, kNoLimit,
              "resolution of telemetry's torques"),
        field("speed_step_rad_s", &DeviceInfo::speed_step_rad_s, "", -kNoLimit, kNoLimit,
              "resolution of telemetry's speed"));
  }
};
template <>
struct Fields<Clock> {
  static constexpr std::string_view name = "Clock";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("tick", &Clock::tick, "", -kNoLimit, kNoLimit, "control periods since power-up"),
        field("time_s", &Clock::time_s, "", -kNoLimit, kNoLimit, "tick times the control period"),
        field("position_counts", &Clock::position_counts, "", -kNoLimit, kNoLimit,
              "from the device's zero, never wraps"),
        field("angle_rad", &Clock::angle_rad, "", -kNoLimit, kNoLimit, "the same as an angle"));
  }
};
template <>
struct Fields<Health> {
  static constexpr std::string_view name = "Health";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("state", &Health::state, "", -kNoLimit, kNoLimit, "whether it makes torque"),
        field("faults", &Health::faults, "", -kNoLimit, kNoLimit,
              "names of the latched faults: \"over_speed\", ..."),
        field("reports_accepted", &Health::reports_accepted, "", -kNoLimit, kNoLimit,
              "that did what they asked"),
        field("reports_refused", &Health::reports_refused, "", -kNoLimit, kNoLimit,
              "that changed nothing"),
        field("samples_dropped", &Health::samples_dropped, "", -kNoLimit, kNoLimit,
              "telemetry that the host did not fetch in time"),
        field("tick_overruns", &Health::tick_overruns, "", -kNoLimit, kNoLimit,
              "ticks that were missed"),
        field("tick_time_s", &Health::tick_time_s, "", -kNoLimit, kNoLimit,
              "time that the last control tick took"),
        field("tick_time_max_s", &Health::tick_time_max_s, "", -kNoLimit, kNoLimit,
              "longest tick so far"),
        field("saves", &Health::saves, "", -kNoLimit, kNoLimit,
              "how often the configuration was saved, ever"),
        field("owner", &Health::owner, "", -kNoLimit, kNoLimit, "owner of the actuator"),
        field("reset_cause", &Health::reset_cause, "", -kNoLimit, kNoLimit,
              "why the device started"),
        field(
            "unexpected_swings", &Health::unexpected_swings, "", -kNoLimit, kNoLimit,
            "swings of the law `calibrated` that lasted in scenes which the configured parts can "
            "render, and four for a ring, since the knob was configured, less one for fifty turns"),
        field("centre", &Health::centre, "", -kNoLimit, kNoLimit, "where angle 0 comes from"));
  }
};
template <>
struct Fields<Energies> {
  static constexpr std::string_view name = "Energies";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("tick", &Energies::tick, "", -kNoLimit, kNoLimit,
              "of this moment: control periods since power-up"),
        field("time_s", &Energies::time_s, "", -kNoLimit, kNoLimit,
              "tick times the control period"),
        field("kept", &Energies::kept, "", -kNoLimit, kNoLimit,
              "the law keeps count; else all stand still"),
        field("motor_j", &Energies::motor_j, "", -kNoLimit, kNoLimit,
              "given to the knob by the motor"),
        field("felt_j", &Energies::felt_j, "", -kNoLimit, kNoLimit,
              "given to the knob by motor and shaft together, which a hand feels"),
        field("stored_j", &Energies::stored_j, "", -kNoLimit, kNoLimit,
              "in the shaft's spring now"),
        field("brake_j", &Energies::brake_j, "", -kNoLimit, kNoLimit, "taken by the brake"),
        field("bound_nm_per_rad", &Energies::bound_nm_per_rad, "", -kNoLimit, kNoLimit,
              "the stiffest that is rendered now, found out from the knob's swings; 0: no bound"));
  }
};
template <>
struct Fields<MotorCurrent> {
  static constexpr std::string_view name = "MotorCurrent";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("measured", &MotorCurrent::measured, "", -kNoLimit, kNoLimit,
              "there is a current sensor; without one the other fields are 0"),
        field("time_s", &MotorCurrent::time_s, "", -kNoLimit, kNoLimit,
              "periods of the current loop since the board started"),
        field("angle_rad", &MotorCurrent::angle_rad, "", -kNoLimit, kNoLimit, "at the newest tick"),
        field("period_s", &MotorCurrent::period_s, "", -kNoLimit, kNoLimit, "of the current loop"),
        field("delay_s", &MotorCurrent::delay_s, "", -kNoLimit, kNoLimit,
              "from a measurement to the voltage that answers it"),
        field("periods", &MotorCurrent::periods, "", -kNoLimit, kNoLimit,
              "done, each with one measurement"),
        field("current_a", &MotorCurrent::current_a, "", -kNoLimit, kNoLimit,
              "the newest measurement, without its zero"),
        field("zero_a", &MotorCurrent::zero_a, "", -kNoLimit, kNoLimit, "reading without current"),
        field("step_a", &MotorCurrent::step_a, "", -kNoLimit, kNoLimit, "of the converter"),
        field("current_sum_a", &MotorCurrent::current_sum_a, "", -kNoLimit, kNoLimit,
              "of all measurements, each with its zero"),
        field("share", &MotorCurrent::share, "", -kNoLimit, kNoLimit,
              "share of the supply's voltage that answers it"),
        field("share_before", &MotorCurrent::share_before, "", -kNoLimit, kNoLimit,
              "share before it"),
        field("share_sum", &MotorCurrent::share_sum, "", -kNoLimit, kNoLimit,
              "sum of all shares, positive to larger angles"),
        field("torque_constant_nm_per_a", &MotorCurrent::torque_constant_nm_per_a, "", -kNoLimit,
              kNoLimit, "that the board reckons with: what it was configured to when it started"));
  }
};
template <>
struct Fields<Limits> {
  static constexpr std::string_view name = "Limits";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("motor_torque_max_nm", &Limits::motor_torque_max_nm, "", -kNoLimit, kNoLimit,
                       "of the motor, for seconds"),
                 field("motor_torque_continuous_max_nm", &Limits::motor_torque_continuous_max_nm,
                       "", -kNoLimit, kNoLimit, "the same for ever, as its winding stands it"),
                 field("brake_torque_max_nm", &Limits::brake_torque_max_nm, "", -kNoLimit, kNoLimit,
                       "of the brake"),
                 field("speed_limit_rad_s", &Limits::speed_limit_rad_s, "", -kNoLimit, kNoLimit,
                       "more is a fault; 0: no limit"),
                 field("held_low", &Limits::held_low, "", -kNoLimit, kNoLimit,
                       "the board gives little, because nobody has confirmed its parts, or because "
                       "their values are assumed; `confirmed` and a calibration end it"));
  }
};
template <>
struct Fields<StableStiffness> {
  static constexpr std::string_view name = "StableStiffness";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("stiffness_nm_per_rad", &StableStiffness::stiffness_nm_per_rad, "",
                       -kNoLimit, kNoLimit, "the stiffest such spring"),
                 field("limited_by", &StableStiffness::limited_by, "", -kNoLimit, kNoLimit,
                       "the limit to improve: \"rate\" of the control, \"lag\" of the motor, "
                       "\"counts\" of the encoder"));
  }
};
template <>
struct Fields<GameStatus> {
  static constexpr std::string_view name = "GameStatus";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("time_s", &GameStatus::time_s, "", -kNoLimit, kNoLimit,
              "of this moment: the device's tick times the control period"),
        field("owner", &GameStatus::owner, "", -kNoLimit, kNoLimit, "owner of the actuator"),
        field("paused", &GameStatus::paused, "", -kNoLimit, kNoLimit, "by the game"),
        field("enabled", &GameStatus::enabled, "", -kNoLimit, kNoLimit,
              "the game wants the actuator on"),
        field("gain", &GameStatus::gain, "", -kNoLimit, kNoLimit,
              "of the device, as the game set it, 0 to 1"),
        field("torque_nm", &GameStatus::torque_nm, "", -kNoLimit, kNoLimit,
              "of all effects together"),
        field("updates", &GameStatus::updates, "", -kNoLimit, kNoLimit,
              "reports that games sent since power-up"),
        field("effects", &GameStatus::effects, "", -kNoLimit, kNoLimit, "that exist"),
        field("clipped_ticks", &GameStatus::clipped_ticks, "", -kNoLimit, kNoLimit,
              "ticks in which effects asked for more than all together get, since power-up"),
        field("asked_percent", &GameStatus::asked_percent, "", -kNoLimit, kNoLimit,
              "the most that effects asked for in the last half second, as a share of their joint "
              "limit"));
  }
};
template <>
struct Fields<GameEffect> {
  static constexpr std::string_view name = "GameEffect";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("block", &GameEffect::block, "", -kNoLimit, kNoLimit,
                       "its number, from 1; 0: an empty row of the report"),
                 field("kind", &GameEffect::kind, "", -kNoLimit, kNoLimit, "its kind"),
                 field("state", &GameEffect::state, "", -kNoLimit, kNoLimit, "whether it plays"),
                 field("torque_nm", &GameEffect::torque_nm, "", -kNoLimit, kNoLimit,
                       "torque now, before the cap on all together"),
                 field("updates", &GameEffect::updates, "", -kNoLimit, kNoLimit,
                       "reports about it since it was made"),
                 field("silent_s", &GameEffect::silent_s, "", -kNoLimit, kNoLimit,
                       "since the last of them; 65.535 s is that or longer"));
  }
};
template <>
struct Fields<LinkStatistics> {
  static constexpr std::string_view name = "LinkStatistics";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("reports_sent", &LinkStatistics::reports_sent, "", -kNoLimit, kNoLimit,
                       "to the device"),
                 field("reports_received", &LinkStatistics::reports_received, "", -kNoLimit,
                       kNoLimit, "from the device"),
                 field("reports_undecodable", &LinkStatistics::reports_undecodable, "", -kNoLimit,
                       kNoLimit, "damaged on the way, and ignored"),
                 field("samples_received", &LinkStatistics::samples_received, "", -kNoLimit,
                       kNoLimit, "of telemetry"),
                 field("samples_lost", &LinkStatistics::samples_lost, "", -kNoLimit, kNoLimit,
                       "never arrived, or not read before the ring was full"),
                 field("events_lost", &LinkStatistics::events_lost, "", -kNoLimit, kNoLimit,
                       "not taken before there were 1,024 of them"),
                 field("local_models_refused", &LinkStatistics::local_models_refused, "", -kNoLimit,
                       kNoLimit, "by the device"),
                 field("last_refusal", &LinkStatistics::last_refusal, "", -kNoLimit, kNoLimit,
                       "of a local model, in words"));
  }
};
template <>
struct Fields<Event> {
  static constexpr std::string_view name = "Event";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("kind", &Event::kind, "", -kNoLimit, kNoLimit,
              "kind of event: \"state_changed\", \"watchdog\", \"deadline_missed\", ..."),
        field("state", &Event::state, "", -kNoLimit, kNoLimit, "after the event"),
        field("owner", &Event::owner, "", -kNoLimit, kNoLimit,
              "owner of the actuator after the event"),
        field("faults", &Event::faults, "", -kNoLimit, kNoLimit,
              "names of the faults that are latched after it"),
        field("tick", &Event::tick, "", -kNoLimit, kNoLimit,
              "when: control periods since power-up"),
        field("time_s", &Event::time_s, "", -kNoLimit, kNoLimit, "tick times the control period"));
  }
};
template <>
struct Fields<Disarm> {
  static constexpr std::string_view name = "Disarm";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("reason", &Disarm::reason, "", -kNoLimit, kNoLimit, "why it went"),
        field("faults", &Disarm::faults, "", -kNoLimit, kNoLimit,
              "names of the faults that were latched then"),
        field("tick", &Disarm::tick, "", -kNoLimit, kNoLimit,
              "when: control periods since power-up"),
        field("time_s", &Disarm::time_s, "", -kNoLimit, kNoLimit, "tick times the control period"));
  }
};
template <>
struct Fields<EmulatorOptions> {
  static constexpr std::string_view name = "EmulatorOptions";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("seed", &EmulatorOptions::seed, "", -kNoLimit, kNoLimit,
              "of everything random: encoder noise, damaged reports"),
        field("control_rate_hz", &EmulatorOptions::control_rate_hz, "Hz", 1000.0, 2e4,
              "ticks in a second"),
        field("plant", &EmulatorOptions::plant, "", -kNoLimit, kNoLimit, "its parts"),
        field("hand", &EmulatorOptions::hand, "", -kNoLimit, kNoLimit, "the hand on it"),
        field("serial", &EmulatorOptions::serial, "", -kNoLimit, kNoLimit,
              "at most 16 ASCII characters; empty: derived from the device's name"),
        field("actuator", &EmulatorOptions::actuator, "", -kNoLimit, kNoLimit,
              "configuration at power-up; it replaces the stored one and the defaults"),
        field("control", &EmulatorOptions::control, "", -kNoLimit, kNoLimit, "the same"),
        field("board", &EmulatorOptions::board, "", -kNoLimit, kNoLimit,
              "the same; a plant with electrics has use for it"),
        field("game", &EmulatorOptions::game, "", -kNoLimit, kNoLimit, "the same"),
        field("shaft", &EmulatorOptions::shaft, "", -kNoLimit, kNoLimit, "the same"),
        field("paced", &EmulatorOptions::paced, "", -kNoLimit, kNoLimit,
              "on: real time, as with hardware; off: virtual time, which passes only inside calls "
              "that wait, as fast as the computer can. The same calls with the same seed give the "
              "same bytes"),
        field("log_truth", &EmulatorOptions::log_truth, "", -kNoLimit, kNoLimit,
              "record what no sensor sees, once a tick"),
        field("log_inputs", &EmulatorOptions::log_inputs, "", -kNoLimit, kNoLimit,
              "record what enters the device, from power-up on, so that it can run again"));
  }
};

}  // namespace torsio
