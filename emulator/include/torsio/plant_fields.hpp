/// @file
/// The fields of the emulated knob's structures by name, as fields.hpp has the others.
///
/// Printed from the field lists in emulator/definition/ by `./dev generate`; change those instead.
#pragma once

#include <array>
#include <string_view>

#include "torsio/field.hpp"
#include "torsio/plant.hpp"

namespace torsio {

template <>
struct Names<EncoderRounding> {
  static constexpr std::array<std::string_view, 2> values{"floor", "nearest"};
};

template <>
struct Names<IndexPulse> {
  static constexpr std::array<std::string_view, 4> values{"works", "missing", "doubled", "noisy"};
};

template <>
struct Names<CurrentSensorState> {
  static constexpr std::array<std::string_view, 4> values{"works", "dead", "stuck", "saturated"};
};

template <>
struct Names<InputKind> {
  static constexpr std::array<std::string_view, 15> values{
      "stored",       "power",        "connected", "output",         "feature",
      "game_output",  "game_feature", "buttons",   "emergency_stop", "actuator_fault",
      "power_faults", "missed_ticks", "power_cut", "counts",         "index"};
};

template <>
struct Fields<NoHand> {
  static constexpr std::string_view name = "NoHand";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit();
  }
};
template <>
struct Fields<TorqueHand> {
  static constexpr std::string_view name = "TorqueHand";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("torque_nm", &TorqueHand::torque_nm, "N m", -100.0, 100.0,
                       "two knots at the same time make a jump"));
  }
};
template <>
struct Fields<ImpedanceHand> {
  static constexpr std::string_view name = "ImpedanceHand";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("inertia_kg_m2", &ImpedanceHand::inertia_kg_m2, "kg m^2", 0.0, 10.0, "of the hand"),
        field("stiffness_nm_per_rad", &ImpedanceHand::stiffness_nm_per_rad, "N m/rad", 0.0, 1e6,
              "of the hand"),
        field("damping_nm_s_per_rad", &ImpedanceHand::damping_nm_s_per_rad, "N m s/rad", 0.0,
              1000.0, "of the hand"),
        field("intended_angle_rad", &ImpedanceHand::intended_angle_rad, "rad", -1e9, 1e9,
              "without jumps"));
  }
};
template <>
struct Fields<PrescribedMotion> {
  static constexpr std::string_view name = "PrescribedMotion";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("angle_rad", &PrescribedMotion::angle_rad, "rad", -1e9, 1e9, "without jumps"));
  }
};
template <>
struct Fields<FeedbackHand> {
  static constexpr std::string_view name = "FeedbackHand";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("torque_nm", &FeedbackHand::torque_nm, "", -kNoLimit, kNoLimit,
              "the torque on the knob; held until it is asked again"),
        field("period_s", &FeedbackHand::period_s, "s", 1e-5, 1.0, "from one asking to the next"));
  }
};
template <>
struct Fields<ShaftHardening> {
  static constexpr std::string_view name = "ShaftHardening";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("knee_rad", &ShaftHardening::knee_rad, "rad", 1e-15, 1e15,
                       "the spring is linear up to here"),
                 field("stiffness_factor", &ShaftHardening::stiffness_factor, "", 1e-15, 1e15,
                       "stiffness beyond the knee over stiffness before it"));
  }
};
template <>
struct Fields<BrakeHysteresis> {
  static constexpr std::string_view name = "BrakeHysteresis";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("half_width_nm", &BrakeHysteresis::half_width_nm, "N m", 0.0, 1e15,
                       "of the play; the default is 5 % of the brake's limit"));
  }
};
template <>
struct Fields<Belt> {
  static constexpr std::string_view name = "Belt";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("stiffness_nm_per_rad", &Belt::stiffness_nm_per_rad, "N m/rad", 1e-15, 1e15,
                       "of the belt"),
                 field("damping_nm_s_per_rad", &Belt::damping_nm_s_per_rad, "N m s/rad", 0.0, 1e15,
                       "of the belt"),
                 field("pulley_inertia_kg_m2", &Belt::pulley_inertia_kg_m2, "kg m^2", 1e-15, 1e15,
                       "the share of brake_inertia_kg_m2 that lies before the belt"));
  }
};
template <>
struct Fields<Cogging> {
  static constexpr std::string_view name = "Cogging";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("periods_per_rev", &Cogging::periods_per_rev, "", 1.0, 65535.0, "of the torque"),
        field("torque_nm", &Cogging::torque_nm, "N m", -kNoLimit, kNoLimit,
              "2 to 64 torques at equal distances over one period, from angle 0; straight lines "
              "between"));
  }
};
template <>
struct Fields<Electrics> {
  static constexpr std::string_view name = "Electrics";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("winding_resistance_ohm", &Electrics::winding_resistance_ohm, "ohm", 1e-15, 1e15,
              "of the motor, at 25 degrees"),
        field("winding_inductance_h", &Electrics::winding_inductance_h, "H", 1e-15, 1e15,
              "of the motor"),
        field("torque_constant_nm_per_a", &Electrics::torque_constant_nm_per_a, "N m/A", 1e-15,
              1e15, "of the motor, at the knob; V s/rad of back EMF as well"),
        field("motor_reversed", &Electrics::motor_reversed, "", -kNoLimit, kNoLimit,
              "a current into the first pin turns the knob to smaller angles"),
        field("coil_resistance_ohm", &Electrics::coil_resistance_ohm, "ohm", 1e-15, 1e15,
              "of the brake"),
        field("coil_inductance_h", &Electrics::coil_inductance_h, "H", 1e-15, 1e15, "of the brake"),
        field("coil_torque_constant_nm_per_a", &Electrics::coil_torque_constant_nm_per_a, "N m/A",
              1e-15, 1e15, "of the brake, on the pulley"),
        field("supply_v", &Electrics::supply_v, "V", 1e-15, 1e15, "without load"),
        field("supply_resistance_ohm", &Electrics::supply_resistance_ohm, "ohm", 0.0, 1e15,
              "of the supply; it takes no current back"),
        field("supply_capacitance_f", &Electrics::supply_capacitance_f, "F", 1e-15, 1e15,
              "behind that"),
        field("supply_divider_ratio", &Electrics::supply_divider_ratio, "", 1e-15, 1e15,
              "the supply's voltage over what a board with supply_sense_pin measures of it"),
        field("ambient_c", &Electrics::ambient_c, "degree C", -100.0, 300.0,
              "of the air; everything begins there"),
        field("winding_heat_j_per_k", &Electrics::winding_heat_j_per_k, "J/K", 1e-15, 1e15,
              "heat capacity of the motor's winding"),
        field("winding_to_rotor_k_per_w", &Electrics::winding_to_rotor_k_per_w, "K/W", 1e-15, 1e15,
              "from there to the rotor"),
        field("rotor_heat_j_per_k", &Electrics::rotor_heat_j_per_k, "J/K", 1e-15, 1e15,
              "heat capacity of the rotor"),
        field("rotor_to_air_k_per_w", &Electrics::rotor_to_air_k_per_w, "K/W", 1e-15, 1e15,
              "from there to the air"),
        field("coil_heat_j_per_k", &Electrics::coil_heat_j_per_k, "J/K", 1e-15, 1e15,
              "heat capacity of the brake's coil"),
        field("coil_to_air_k_per_w", &Electrics::coil_to_air_k_per_w, "K/W", 1e-15, 1e15,
              "from there to the air"),
        field("pwm_steps", &Electrics::pwm_steps, "", 1.0, 65535.0, "of a bridge's full share"),
        field("current_period_s", &Electrics::current_period_s, "s", 0.0, 0.001,
              "of the current loop, rounded to a whole part of the control period, which 0 is"),
        field("output_delay_s", &Electrics::output_delay_s, "s", 1e-6, 0.001,
              "from a measurement to the voltage that answers it; at most a period of the current "
              "loop"),
        field("predictive", &Electrics::predictive, "", -kNoLimit, kNoLimit,
              "the current loop of the RP2350; off: the one of the RP2040"),
        field("sample_offset_s", &Electrics::sample_offset_s, "s", 0.0, 1e-5,
              "from the beginning of a measurement until it takes the current; boards begin 1 us "
              "before the middle of the bridge's pulse"),
        field("sensor_v_per_a", &Electrics::sensor_v_per_a, "V/A", 1e-15, 1e15,
              "of the current sensor"),
        field("sensor_zero_v", &Electrics::sensor_zero_v, "V", -10.0, 10.0,
              "its output without current"),
        field("sensor_noise_v", &Electrics::sensor_noise_v, "V", 0.0, 1e15, "standard deviation"),
        field("sensor_range_v", &Electrics::sensor_range_v, "V", 1e-15, 1e15,
              "of its converter, from 0"),
        field("sensor_bits", &Electrics::sensor_bits, "", 1.0, 24.0, "of its converter"),
        field("sensor_state", &Electrics::sensor_state, "", -kNoLimit, kNoLimit,
              "dead: 0 V; stuck: at its zero; saturated: at the end of its range"));
  }
};
template <>
struct Fields<PlantParams> {
  static constexpr std::string_view name = "PlantParams";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("knob_inertia_kg_m2", &PlantParams::knob_inertia_kg_m2, "kg m^2", 1e-15, 1e15,
              "motor and knob"),
        field("knob_viscous_nm_s_per_rad", &PlantParams::knob_viscous_nm_s_per_rad, "N m s/rad",
              0.0, 1e15, "viscous friction there"),
        field("knob_coulomb_nm", &PlantParams::knob_coulomb_nm, "N m", 0.0, 1e15,
              "dry friction there"),
        field("brake_inertia_kg_m2", &PlantParams::brake_inertia_kg_m2, "kg m^2", 1e-15, 1e15,
              "pulleys and brake"),
        field("brake_viscous_nm_s_per_rad", &PlantParams::brake_viscous_nm_s_per_rad, "N m s/rad",
              0.0, 1e15, "viscous friction there"),
        field("brake_drag_nm", &PlantParams::brake_drag_nm, "N m", 0.0, 1e15,
              "drag of the released brake"),
        field("shaft_stiffness_nm_per_rad", &PlantParams::shaft_stiffness_nm_per_rad, "N m/rad",
              0.0, 1e15, "0: the shaft is cut"),
        field("shaft_damping_nm_s_per_rad", &PlantParams::shaft_damping_nm_s_per_rad, "N m s/rad",
              0.0, 1e15, "of the shaft"),
        field("brake_time_constant_s", &PlantParams::brake_time_constant_s, "s", 0.0, 1e15,
              "from command to torque; 0: no lag"),
        field("motor_time_constant_s", &PlantParams::motor_time_constant_s, "s", 0.0, 1e15,
              "from command to torque; 0: no lag"),
        field("motor_limit_nm", &PlantParams::motor_limit_nm, "N m", 0.0, 1e15,
              "commands are clipped to it, both ways"),
        field("brake_limit_nm", &PlantParams::brake_limit_nm, "N m", 0.0, 1e15,
              "commands are clipped to it"),
        field("counts_per_rev", &PlantParams::counts_per_rev, "", 1.0, 16777216.0,
              "of the encoder"),
        field("encoder_rounding", &PlantParams::encoder_rounding, "", -kNoLimit, kNoLimit,
              "how the encoder counts"),
        field("encoder_index", &PlantParams::encoder_index, "", -kNoLimit, kNoLimit,
              "the pulse at the encoder's count 0, for a device with encoder_index_pin"),
        field("encoder_phase_counts", &PlantParams::encoder_phase_counts, "", -kNoLimit, kNoLimit,
              "where in a count angle 0 lies"),
        field("encoder_noise_counts", &PlantParams::encoder_noise_counts, "", 0.0, 1e15,
              "standard deviation; 0 leaves the noise out"),
        field("spring_and_brake", &PlantParams::spring_and_brake, "", -kNoLimit, kNoLimit,
              "part: spring and brake. Without it knob and brake are one rigid body and the brake "
              "never engages. This suits the law motor_only and saves about a third of the plant's "
              "time. All parts below except cogging need it"),
        field("shaft_hardening", &PlantParams::shaft_hardening, "", -kNoLimit, kNoLimit,
              "part: the spring has knees"),
        field("brake_hysteresis", &PlantParams::brake_hysteresis, "", -kNoLimit, kNoLimit,
              "part: play in the brake"),
        field("belt", &PlantParams::belt, "", -kNoLimit, kNoLimit, "part: the belt stretches"),
        field("cogging", &PlantParams::cogging, "", -kNoLimit, kNoLimit, "part: the motor cogs"),
        field("electrics", &PlantParams::electrics, "", -kNoLimit, kNoLimit,
              "part: windings, bridges, supply, sensor"));
  }
};
template <>
struct Fields<LinkFaults> {
  static constexpr std::string_view name = "LinkFaults";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("drop_output", &LinkFaults::drop_output, "", 0.0, 1.0, "host to device"),
        field("corrupt_output", &LinkFaults::corrupt_output, "", 0.0, 1.0,
              "a bit of it is another"),
        field("drop_input", &LinkFaults::drop_input, "", 0.0, 1.0, "device to host"),
        field("corrupt_input", &LinkFaults::corrupt_input, "", 0.0, 1.0, "a bit of it is another"));
  }
};
template <>
struct Fields<TruthSample> {
  static constexpr std::string_view name = "TruthSample";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("time_s", &TruthSample::time_s, "", -kNoLimit, kNoLimit, "device time"),
        field("angle_rad", &TruthSample::angle_rad, "", -kNoLimit, kNoLimit, "of the knob"),
        field("brake_angle_rad", &TruthSample::brake_angle_rad, "", -kNoLimit, kNoLimit,
              "of the far side of the shaft spring"),
        field("speed_rad_s", &TruthSample::speed_rad_s, "", -kNoLimit, kNoLimit, "of the knob"),
        field("spring_torque_nm", &TruthSample::spring_torque_nm, "", -kNoLimit, kNoLimit,
              "of the shaft spring"),
        field("brake_torque_nm", &TruthSample::brake_torque_nm, "", -kNoLimit, kNoLimit,
              "torque that the brake transmits, drag included"),
        field("brake_capacity_nm", &TruthSample::brake_capacity_nm, "", -kNoLimit, kNoLimit,
              "most that it could transmit, drag included, >= 0"),
        field("motor_torque_nm", &TruthSample::motor_torque_nm, "", -kNoLimit, kNoLimit,
              "after the motor's lag"),
        field("hand_torque_nm", &TruthSample::hand_torque_nm, "", -kNoLimit, kNoLimit,
              "of the hand on the knob"));
  }
};
template <>
struct Fields<ElectricsState> {
  static constexpr std::string_view name = "ElectricsState";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(
        field("motor_current_a", &ElectricsState::motor_current_a, "", -kNoLimit, kNoLimit,
              "positive turns the knob to larger angles"),
        field("coil_current_a", &ElectricsState::coil_current_a, "", -kNoLimit, kNoLimit,
              "of the brake"),
        field("supply_v", &ElectricsState::supply_v, "", -kNoLimit, kNoLimit, "at the bridges"),
        field("winding_c", &ElectricsState::winding_c, "", -kNoLimit, kNoLimit,
              "temperature of the motor's winding"),
        field("rotor_c", &ElectricsState::rotor_c, "", -kNoLimit, kNoLimit, "of its rotor"),
        field("coil_c", &ElectricsState::coil_c, "", -kNoLimit, kNoLimit, "of the brake's coil"));
  }
};
template <>
struct Fields<DeviceInput> {
  static constexpr std::string_view name = "DeviceInput";
  template <class Visit>
  static constexpr decltype(auto) apply(Visit&& visit) {
    return visit(field("tick", &DeviceInput::tick, "", -kNoLimit, kNoLimit,
                       "control ticks that had run before it, since the first power-up"),
                 field("kind", &DeviceInput::kind, "", -kNoLimit, kNoLimit, "its kind"),
                 field("bytes", &DeviceInput::bytes, "", -kNoLimit, kNoLimit,
                       "its content: a report, or as its kind has it; of counts one control tick "
                       "for each, in 32 bits, little endian"));
  }
};

}  // namespace torsio
