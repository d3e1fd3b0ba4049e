/// @file
/// The fields of the emulated knob's structures by name, as fields.hpp has the others.
///
/// Printed from the field lists in emulator/definition/ by `./dev generate`; change those instead.
#pragma once

#include <array>
#include <string_view>
#include <tuple>

#include "torsio/field.hpp"
#include "torsio/plant.hpp"

namespace torsio {

template <>
struct Names<EncoderRounding> {
  static constexpr std::array<std::string_view, 2> values{"floor", "nearest"};
};

template <>
struct Fields<NoHand> {
  static constexpr std::string_view name = "NoHand";
  static constexpr std::tuple list{};
};
template <>
struct Fields<TorqueHand> {
  static constexpr std::string_view name = "TorqueHand";
  static constexpr std::tuple list{
      field("torque_nm", &TorqueHand::torque_nm, "N m", -100.0, 100.0,
            "two knots at the same time make a jump"),
  };
};
template <>
struct Fields<ImpedanceHand> {
  static constexpr std::string_view name = "ImpedanceHand";
  static constexpr std::tuple list{
      field("inertia_kg_m2", &ImpedanceHand::inertia_kg_m2, "kg m^2", 0.0, 10.0, "of the hand"),
      field("stiffness_nm_per_rad", &ImpedanceHand::stiffness_nm_per_rad, "N m/rad", 0.0, 1e6,
            "of the hand"),
      field("damping_nm_s_per_rad", &ImpedanceHand::damping_nm_s_per_rad, "N m s/rad", 0.0, 1000.0,
            "of the hand"),
      field("intended_angle_rad", &ImpedanceHand::intended_angle_rad, "rad", -1e9, 1e9,
            "without jumps"),
  };
};
template <>
struct Fields<PrescribedMotion> {
  static constexpr std::string_view name = "PrescribedMotion";
  static constexpr std::tuple list{
      field("angle_rad", &PrescribedMotion::angle_rad, "rad", -1e9, 1e9, "without jumps"),
  };
};
template <>
struct Fields<FeedbackHand> {
  static constexpr std::string_view name = "FeedbackHand";
  static constexpr std::tuple list{
      field("torque_nm", &FeedbackHand::torque_nm, "", -kNoLimit, kNoLimit,
            "the torque on the knob; held until it is asked again"),
      field("period_s", &FeedbackHand::period_s, "s", 1e-5, 1.0, "from one asking to the next"),
  };
};
template <>
struct Fields<ShaftHardening> {
  static constexpr std::string_view name = "ShaftHardening";
  static constexpr std::tuple list{
      field("knee_rad", &ShaftHardening::knee_rad, "rad", 1e-15, 1e15,
            "the spring is linear up to here"),
      field("stiffness_factor", &ShaftHardening::stiffness_factor, "", 1e-15, 1e15,
            "stiffness beyond the knee over stiffness before it"),
  };
};
template <>
struct Fields<BrakeHysteresis> {
  static constexpr std::string_view name = "BrakeHysteresis";
  static constexpr std::tuple list{
      field("half_width_nm", &BrakeHysteresis::half_width_nm, "N m", 0.0, 1e15,
            "of the play; the default is 5 % of the brake's limit"),
  };
};
template <>
struct Fields<Belt> {
  static constexpr std::string_view name = "Belt";
  static constexpr std::tuple list{
      field("stiffness_nm_per_rad", &Belt::stiffness_nm_per_rad, "N m/rad", 1e-15, 1e15,
            "of the belt"),
      field("damping_nm_s_per_rad", &Belt::damping_nm_s_per_rad, "N m s/rad", 0.0, 1e15,
            "of the belt"),
      field("pulley_inertia_kg_m2", &Belt::pulley_inertia_kg_m2, "kg m^2", 1e-15, 1e15,
            "the share of brake_inertia_kg_m2 that lies before the belt"),
  };
};
template <>
struct Fields<Cogging> {
  static constexpr std::string_view name = "Cogging";
  static constexpr std::tuple list{
      field("periods_per_rev", &Cogging::periods_per_rev, "", 1.0, 65535.0, "of the torque"),
      field("torque_nm", &Cogging::torque_nm, "N m", -kNoLimit, kNoLimit,
            "2 to 64 torques at equal distances over one period, from angle 0; straight lines "
            "between"),
  };
};
template <>
struct Fields<PlantParams> {
  static constexpr std::string_view name = "PlantParams";
  static constexpr std::tuple list{
      field("knob_inertia_kg_m2", &PlantParams::knob_inertia_kg_m2, "kg m^2", 1e-15, 1e15,
            "motor and knob"),
      field("knob_viscous_nm_s_per_rad", &PlantParams::knob_viscous_nm_s_per_rad, "N m s/rad", 0.0,
            1e15, "viscous friction there"),
      field("knob_coulomb_nm", &PlantParams::knob_coulomb_nm, "N m", 0.0, 1e15,
            "dry friction there"),
      field("brake_inertia_kg_m2", &PlantParams::brake_inertia_kg_m2, "kg m^2", 1e-15, 1e15,
            "pulleys and brake"),
      field("brake_viscous_nm_s_per_rad", &PlantParams::brake_viscous_nm_s_per_rad, "N m s/rad",
            0.0, 1e15, "viscous friction there"),
      field("brake_drag_nm", &PlantParams::brake_drag_nm, "N m", 0.0, 1e15,
            "drag of the released brake"),
      field("shaft_stiffness_nm_per_rad", &PlantParams::shaft_stiffness_nm_per_rad, "N m/rad", 0.0,
            1e15, "0: the shaft is cut"),
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
      field("counts_per_rev", &PlantParams::counts_per_rev, "", 1.0, 16777216.0, "of the encoder"),
      field("encoder_rounding", &PlantParams::encoder_rounding, "", -kNoLimit, kNoLimit,
            "how the encoder counts"),
      field("encoder_phase_counts", &PlantParams::encoder_phase_counts, "", -kNoLimit, kNoLimit,
            "where in a count angle 0 lies"),
      field("encoder_noise_counts", &PlantParams::encoder_noise_counts, "", 0.0, 1e15,
            "standard deviation; 0 leaves the noise out"),
      field("spring_and_brake", &PlantParams::spring_and_brake, "", -kNoLimit, kNoLimit,
            "part: spring and brake. Without it knob and brake are one rigid body and the brake "
            "never engages, for what needs none, such as the law motor_only; it saves about half "
            "of the plant's time. The parts below, but for cogging, need it"),
      field("shaft_hardening", &PlantParams::shaft_hardening, "", -kNoLimit, kNoLimit, ""),
      field("brake_hysteresis", &PlantParams::brake_hysteresis, "", -kNoLimit, kNoLimit, ""),
      field("belt", &PlantParams::belt, "", -kNoLimit, kNoLimit, ""),
      field("cogging", &PlantParams::cogging, "", -kNoLimit, kNoLimit, ""),
  };
};
template <>
struct Fields<TruthSample> {
  static constexpr std::string_view name = "TruthSample";
  static constexpr std::tuple list{
      field("time_s", &TruthSample::time_s, "", -kNoLimit, kNoLimit, "device time"),
      field("angle_rad", &TruthSample::angle_rad, "", -kNoLimit, kNoLimit, "of the knob"),
      field("brake_angle_rad", &TruthSample::brake_angle_rad, "", -kNoLimit, kNoLimit,
            "of the far side of the shaft spring"),
      field("speed_rad_s", &TruthSample::speed_rad_s, "", -kNoLimit, kNoLimit, "of the knob"),
      field("spring_torque_nm", &TruthSample::spring_torque_nm, "", -kNoLimit, kNoLimit,
            "of the shaft spring"),
      field("brake_torque_nm", &TruthSample::brake_torque_nm, "", -kNoLimit, kNoLimit,
            "what the brake transmits, drag included"),
      field("brake_capacity_nm", &TruthSample::brake_capacity_nm, "", -kNoLimit, kNoLimit,
            "what it could transmit, drag included, >= 0"),
      field("motor_torque_nm", &TruthSample::motor_torque_nm, "", -kNoLimit, kNoLimit,
            "after the motor's lag"),
      field("hand_torque_nm", &TruthSample::hand_torque_nm, "", -kNoLimit, kNoLimit,
            "of whoever holds the knob"),
  };
};

}  // namespace torsio
