/// @file
/// Converts C's structures to C++'s and back.
///
/// Printed from the field lists in firmware/protocol/definition/ and emulator/definition/ by `./dev
/// generate`; change those instead.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "c_values.hpp"
#include "torsio/config.hpp"
#include "torsio/emulator_options.hpp"
#include "torsio/plant.hpp"
#include "torsio/scene.hpp"
#include "torsio/telemetry.hpp"
#include "torsio_types.h"

namespace torsio::c {

inline constexpr std::array<std::string_view, 10> kFaultNames{
    "emergency_stop", "over_speed",     "encoder", "actuator",    "overrun",
    "numeric",        "current_sensor", "winding", "temperature", "supply"};

/// Bits of the faults with these names; a later device may have some without a bit.
inline std::uint32_t fault_bits(const std::vector<std::string>& names) {
  std::uint32_t bits = 0;
  for (const std::string& name : names) {
    for (std::size_t i = 0; i < kFaultNames.size(); ++i) {
      if (kFaultNames.at(i) == name) bits |= std::uint32_t{1} << i;
    }
  }
  return bits;
}

inline Timing from_c(const torsio_timing& from) {
  Timing to;
  to.delay_s = from.delay_s;
  to.duration_s = from.duration_s;
  to.attack_level = from.attack_level;
  to.attack_s = from.attack_s;
  to.fade_level = from.fade_level;
  to.fade_s = from.fade_s;
  return to;
}
inline Wall from_c(const torsio_wall& from) {
  Wall to;
  to.angle_rad = from.angle_rad;
  to.side = choice<Side>(from.side, "side");
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  return to;
}
inline Spring from_c(const torsio_spring& from) {
  Spring to;
  to.angle_rad = from.angle_rad;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.deadband_rad = from.deadband_rad;
  to.torque_limit_nm = from.torque_limit_nm;
  return to;
}
inline Damper from_c(const torsio_damper& from) {
  Damper to;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.torque_limit_nm = from.torque_limit_nm;
  return to;
}
inline Friction from_c(const torsio_friction& from) {
  Friction to;
  to.torque_nm = from.torque_nm;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  return to;
}
inline Inertia from_c(const torsio_inertia& from) {
  Inertia to;
  to.inertia_kg_m2 = from.inertia_kg_m2;
  to.torque_limit_nm = from.torque_limit_nm;
  return to;
}
inline Constant from_c(const torsio_constant& from) {
  Constant to;
  to.torque_nm = from.torque_nm;
  to.timing = from_c(from.timing);
  return to;
}
inline Ramp from_c(const torsio_ramp& from) {
  Ramp to;
  to.start_torque_nm = from.start_torque_nm;
  to.end_torque_nm = from.end_torque_nm;
  to.timing = from_c(from.timing);
  return to;
}
inline Periodic from_c(const torsio_periodic& from) {
  Periodic to;
  to.waveform = choice<Waveform>(from.waveform, "waveform");
  to.amplitude_nm = from.amplitude_nm;
  to.offset_nm = from.offset_nm;
  to.frequency_hz = from.frequency_hz;
  to.phase_turns = from.phase_turns;
  to.timing = from_c(from.timing);
  return to;
}
inline Detents from_c(const torsio_detents& from) {
  Detents to;
  to.angle_rad = from.angle_rad;
  if (from.per_turn != 0.0) to.per_turn = from.per_turn;
  if (from.pitch_rad != 0.0) to.pitch_rad = from.pitch_rad;
  to.torque_nm = from.torque_nm;
  to.profile = choice<DetentProfile>(from.profile, "profile");
  to.width = from.width;
  return to;
}
inline EndStops from_c(const torsio_end_stops& from) {
  EndStops to;
  to.lower_rad = from.lower_rad;
  to.upper_rad = from.upper_rad;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  return to;
}
inline Texture from_c(const torsio_texture& from) {
  Texture to;
  to.grains_per_turn = from.grains_per_turn;
  to.torque_nm = from.torque_nm;
  to.grain = choice<Grain>(from.grain, "grain");
  to.seed = from.seed;
  return to;
}
inline Curve from_c(const torsio_curve& from) {
  Curve to;
  take(to.torque_nm, from.torque_nm, from.torque_nm_count, "torque_nm");
  to.angle_rad = from.angle_rad;
  to.span_rad = from.span_rad;
  to.ends = choice<Ends>(from.ends, "ends");
  return to;
}
inline Impact from_c(const torsio_impact& from) {
  Impact to;
  to.angle_rad = from.angle_rad;
  to.side = choice<Side>(from.side, "side");
  to.strength_nm_s_per_rad = from.strength_nm_s_per_rad;
  to.frequency_hz = from.frequency_hz;
  to.decay_s = from.decay_s;
  to.pulse_nm_s_per_rad = from.pulse_nm_s_per_rad;
  to.pulse_s = from.pulse_s;
  to.torque_limit_nm = from.torque_limit_nm;
  return to;
}
inline LocalModel from_c(const torsio_local_model& from) {
  LocalModel to;
  to.torque_nm = from.torque_nm;
  to.angle_rad = from.angle_rad;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.deadline_s = from.deadline_s;
  return to;
}
inline Excitation from_c(const torsio_excitation& from) {
  Excitation to;
  to.duration_s = from.duration_s;
  to.travel_rad = from.travel_rad;
  to.speed_limit_rad_s = from.speed_limit_rad_s;
  to.torque_limit_nm = from.torque_limit_nm;
  to.motor_command_nm = from.motor_command_nm;
  to.brake_command_nm = from.brake_command_nm;
  to.ramp_s = from.ramp_s;
  to.sine_nm = from.sine_nm;
  to.sine_begin_hz = from.sine_begin_hz;
  to.sine_end_hz = from.sine_end_hz;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.servo_rad_s = from.servo_rad_s;
  return to;
}
inline ActuatorConfig from_c(const torsio_actuator_config& from) {
  ActuatorConfig to;
  to.motor_torque_max_nm = from.motor_torque_max_nm;
  to.brake_torque_max_nm = from.brake_torque_max_nm;
  to.brake_torque_min_nm = from.brake_torque_min_nm;
  to.brake_drag_nm = from.brake_drag_nm;
  to.brake_time_constant_s = from.brake_time_constant_s;
  to.spring_stiffness_nm_per_rad = from.spring_stiffness_nm_per_rad;
  to.counts_per_rev = from.counts_per_rev;
  to.counter_bits = from.counter_bits;
  to.encoder_reversed = flag(from.encoder_reversed);
  to.knob_inertia_kg_m2 = from.knob_inertia_kg_m2;
  to.knob_coulomb_nm = from.knob_coulomb_nm;
  to.knob_viscous_nm_s_per_rad = from.knob_viscous_nm_s_per_rad;
  to.motor_time_constant_s = from.motor_time_constant_s;
  to.brake_inertia_kg_m2 = from.brake_inertia_kg_m2;
  to.brake_hysteresis_nm = from.brake_hysteresis_nm;
  to.brake_release_time_constant_s = from.brake_release_time_constant_s;
  to.encoder_index_pin = from.encoder_index_pin;
  return to;
}
inline ControlConfig from_c(const torsio_control_config& from) {
  ControlConfig to;
  to.law = choice<Law>(from.law, "law");
  to.beta = from.beta;
  to.speed_bandwidth_hz = from.speed_bandwidth_hz;
  to.motor_torque_cap_nm = from.motor_torque_cap_nm;
  to.brake_torque_cap_nm = from.brake_torque_cap_nm;
  to.motor_slew_nm_per_s = from.motor_slew_nm_per_s;
  to.speed_limit_rad_s = from.speed_limit_rad_s;
  to.watchdog_s = from.watchdog_s;
  to.passive_ramp_s = from.passive_ramp_s;
  to.passive_brake_nm = from.passive_brake_nm;
  to.autonomous = flag(from.autonomous);
  to.free_assist_nm = from.free_assist_nm;
  return to;
}
inline BoardConfig from_c(const torsio_board_config& from) {
  BoardConfig to;
  to.supply_v = from.supply_v;
  to.motor_torque_constant_nm_per_a = from.motor_torque_constant_nm_per_a;
  to.motor_current_max_a = from.motor_current_max_a;
  to.motor_current_continuous_a = from.motor_current_continuous_a;
  to.motor_resistance_ohm = from.motor_resistance_ohm;
  to.motor_inductance_h = from.motor_inductance_h;
  to.current_bandwidth_hz = from.current_bandwidth_hz;
  to.current_sense_v_per_a = from.current_sense_v_per_a;
  to.brake_torque_constant_nm_per_a = from.brake_torque_constant_nm_per_a;
  to.brake_current_max_a = from.brake_current_max_a;
  to.brake_resistance_ohm = from.brake_resistance_ohm;
  to.brake_inductance_h = from.brake_inductance_h;
  to.motor_reversed = flag(from.motor_reversed);
  to.confirmed = flag(from.confirmed);
  to.brake_continuous_percent = from.brake_continuous_percent;
  to.ambient_c = from.ambient_c;
  to.supply_sense_ratio = from.supply_sense_ratio;
  to.encoder_pin = from.encoder_pin;
  to.motor_pin = from.motor_pin;
  to.brake_pin = from.brake_pin;
  to.enable_pin = from.enable_pin;
  to.emergency_stop_pin = from.emergency_stop_pin;
  to.driver_fault_pin = from.driver_fault_pin;
  to.current_sense_pin = from.current_sense_pin;
  to.supply_sense_pin = from.supply_sense_pin;
  to.light_pin = from.light_pin;
  return to;
}
inline GameConfig from_c(const torsio_game_config& from) {
  GameConfig to;
  to.enabled = flag(from.enabled);
  to.range_deg = from.range_deg;
  to.torque_max_nm = from.torque_max_nm;
  to.gain = from.gain;
  to.spring_gain = from.spring_gain;
  to.speed_full_rad_s = from.speed_full_rad_s;
  to.acceleration_full_rad_s2 = from.acceleration_full_rad_s2;
  to.blend_s = from.blend_s;
  to.silence_s = from.silence_s;
  to.join_updates = flag(from.join_updates);
  to.end_stiffness_nm_per_rad = from.end_stiffness_nm_per_rad;
  to.personality = choice<Personality>(from.personality, "personality");
  to.dial_use = choice<DialUse>(from.dial_use, "dial_use");
  to.dial_detents = from.dial_detents;
  to.dial_torque_nm = from.dial_torque_nm;
  to.own_damper_percent = from.own_damper_percent;
  to.own_friction_percent = from.own_friction_percent;
  to.own_inertia_percent = from.own_inertia_percent;
  to.own_spring_percent = from.own_spring_percent;
  to.constants_gain_percent = from.constants_gain_percent;
  to.waves_gain_percent = from.waves_gain_percent;
  to.springs_gain_percent = from.springs_gain_percent;
  to.dampers_gain_percent = from.dampers_gain_percent;
  to.inertias_gain_percent = from.inertias_gain_percent;
  to.frictions_gain_percent = from.frictions_gain_percent;
  to.torque_max_percent = from.torque_max_percent;
  to.reversed = flag(from.reversed);
  to.dial_coarse = flag(from.dial_coarse);
  to.dial_fast_steps = from.dial_fast_steps;
  to.remote_wakeup = flag(from.remote_wakeup);
  return to;
}
inline ShaftConfig from_c(const torsio_shaft_config& from) {
  ShaftConfig to;
  to.knee_1_rad = from.knee_1_rad;
  to.knee_1_nm_per_rad = from.knee_1_nm_per_rad;
  to.knee_2_rad = from.knee_2_rad;
  to.knee_2_nm_per_rad = from.knee_2_nm_per_rad;
  to.knee_3_rad = from.knee_3_rad;
  to.knee_3_nm_per_rad = from.knee_3_nm_per_rad;
  to.knee_4_rad = from.knee_4_rad;
  to.knee_4_nm_per_rad = from.knee_4_nm_per_rad;
  return to;
}
inline CalibrationConfig from_c(const torsio_calibration_config& from) {
  CalibrationConfig to;
  to.values_are = choice<Basis>(from.values_are, "values_are");
  to.calibrated_unix_s = from.calibrated_unix_s;
  to.ambient_k = from.ambient_k;
  to.calibrated_rate_hz = from.calibrated_rate_hz;
  to.sigma_knob_inertia_kg_m2 = from.sigma_knob_inertia_kg_m2;
  to.sigma_knob_coulomb_nm = from.sigma_knob_coulomb_nm;
  to.sigma_knob_viscous_nm_s_per_rad = from.sigma_knob_viscous_nm_s_per_rad;
  to.sigma_spring_stiffness_nm_per_rad = from.sigma_spring_stiffness_nm_per_rad;
  to.sigma_knee_1_rad = from.sigma_knee_1_rad;
  to.sigma_knee_1_nm_per_rad = from.sigma_knee_1_nm_per_rad;
  to.sigma_brake_drag_nm = from.sigma_brake_drag_nm;
  to.sigma_brake_time_constant_s = from.sigma_brake_time_constant_s;
  to.sigma_brake_release_time_constant_s = from.sigma_brake_release_time_constant_s;
  to.sigma_brake_inertia_kg_m2 = from.sigma_brake_inertia_kg_m2;
  to.sigma_brake_hysteresis_nm = from.sigma_brake_hysteresis_nm;
  to.sigma_motor_resistance_permille = from.sigma_motor_resistance_permille;
  to.sigma_motor_inductance_permille = from.sigma_motor_inductance_permille;
  to.sigma_motor_torque_constant_permille = from.sigma_motor_torque_constant_permille;
  return to;
}
inline TorqueHand from_c(const torsio_torque_hand& from) {
  TorqueHand to;
  take(to.torque_nm, from.torque_nm, from.torque_nm_count, "torque_nm");
  return to;
}
inline ImpedanceHand from_c(const torsio_impedance_hand& from) {
  ImpedanceHand to;
  to.inertia_kg_m2 = from.inertia_kg_m2;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  take(to.intended_angle_rad, from.intended_angle_rad, from.intended_angle_rad_count,
       "intended_angle_rad");
  return to;
}
inline PrescribedMotion from_c(const torsio_prescribed_motion& from) {
  PrescribedMotion to;
  take(to.angle_rad, from.angle_rad, from.angle_rad_count, "angle_rad");
  return to;
}
inline ShaftHardening from_c(const torsio_shaft_hardening& from) {
  ShaftHardening to;
  to.knee_rad = from.knee_rad;
  to.stiffness_factor = from.stiffness_factor;
  return to;
}
inline BrakeHysteresis from_c(const torsio_brake_hysteresis& from) {
  BrakeHysteresis to;
  to.half_width_nm = from.half_width_nm;
  return to;
}
inline Belt from_c(const torsio_belt& from) {
  Belt to;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.pulley_inertia_kg_m2 = from.pulley_inertia_kg_m2;
  return to;
}
inline Cogging from_c(const torsio_cogging& from) {
  Cogging to;
  to.periods_per_rev = from.periods_per_rev;
  take(to.torque_nm, from.torque_nm, from.torque_nm_count, "torque_nm");
  return to;
}
inline Electrics from_c(const torsio_electrics& from) {
  Electrics to;
  to.winding_resistance_ohm = from.winding_resistance_ohm;
  to.winding_inductance_h = from.winding_inductance_h;
  to.torque_constant_nm_per_a = from.torque_constant_nm_per_a;
  to.motor_reversed = flag(from.motor_reversed);
  to.coil_resistance_ohm = from.coil_resistance_ohm;
  to.coil_inductance_h = from.coil_inductance_h;
  to.coil_torque_constant_nm_per_a = from.coil_torque_constant_nm_per_a;
  to.supply_v = from.supply_v;
  to.supply_resistance_ohm = from.supply_resistance_ohm;
  to.supply_capacitance_f = from.supply_capacitance_f;
  to.supply_divider_ratio = from.supply_divider_ratio;
  to.ambient_c = from.ambient_c;
  to.winding_heat_j_per_k = from.winding_heat_j_per_k;
  to.winding_to_rotor_k_per_w = from.winding_to_rotor_k_per_w;
  to.rotor_heat_j_per_k = from.rotor_heat_j_per_k;
  to.rotor_to_air_k_per_w = from.rotor_to_air_k_per_w;
  to.coil_heat_j_per_k = from.coil_heat_j_per_k;
  to.coil_to_air_k_per_w = from.coil_to_air_k_per_w;
  to.pwm_steps = from.pwm_steps;
  to.current_period_s = from.current_period_s;
  to.output_delay_s = from.output_delay_s;
  to.predictive = flag(from.predictive);
  to.sample_offset_s = from.sample_offset_s;
  to.sensor_v_per_a = from.sensor_v_per_a;
  to.sensor_zero_v = from.sensor_zero_v;
  to.sensor_noise_v = from.sensor_noise_v;
  to.sensor_range_v = from.sensor_range_v;
  to.sensor_bits = from.sensor_bits;
  to.sensor_state = choice<CurrentSensorState>(from.sensor_state, "sensor_state");
  return to;
}
inline PlantParams from_c(const torsio_plant_params& from) {
  PlantParams to;
  to.knob_inertia_kg_m2 = from.knob_inertia_kg_m2;
  to.knob_viscous_nm_s_per_rad = from.knob_viscous_nm_s_per_rad;
  to.knob_coulomb_nm = from.knob_coulomb_nm;
  to.brake_inertia_kg_m2 = from.brake_inertia_kg_m2;
  to.brake_viscous_nm_s_per_rad = from.brake_viscous_nm_s_per_rad;
  to.brake_drag_nm = from.brake_drag_nm;
  to.shaft_stiffness_nm_per_rad = from.shaft_stiffness_nm_per_rad;
  to.shaft_damping_nm_s_per_rad = from.shaft_damping_nm_s_per_rad;
  to.brake_time_constant_s = from.brake_time_constant_s;
  to.motor_time_constant_s = from.motor_time_constant_s;
  to.motor_limit_nm = from.motor_limit_nm;
  to.brake_limit_nm = from.brake_limit_nm;
  to.counts_per_rev = from.counts_per_rev;
  to.encoder_rounding = choice<EncoderRounding>(from.encoder_rounding, "encoder_rounding");
  to.encoder_index = choice<IndexPulse>(from.encoder_index, "encoder_index");
  to.encoder_phase_counts = from.encoder_phase_counts;
  to.encoder_noise_counts = from.encoder_noise_counts;
  to.spring_and_brake = flag(from.spring_and_brake);
  if (from.shaft_hardening != nullptr)
    to.shaft_hardening =
        from_c(need_sized(from.shaft_hardening, "shaft_hardening", "torsio_shaft_hardening"));
  if (from.brake_hysteresis != nullptr)
    to.brake_hysteresis =
        from_c(need_sized(from.brake_hysteresis, "brake_hysteresis", "torsio_brake_hysteresis"));
  if (from.belt != nullptr) to.belt = from_c(need_sized(from.belt, "belt", "torsio_belt"));
  if (from.cogging != nullptr)
    to.cogging = from_c(need_sized(from.cogging, "cogging", "torsio_cogging"));
  if (from.electrics != nullptr)
    to.electrics = from_c(need_sized(from.electrics, "electrics", "torsio_electrics"));
  return to;
}
inline LinkFaults from_c(const torsio_link_faults& from) {
  LinkFaults to;
  to.drop_output = from.drop_output;
  to.corrupt_output = from.corrupt_output;
  to.drop_input = from.drop_input;
  to.corrupt_input = from.corrupt_input;
  return to;
}
inline EmulatorOptions from_c(const torsio_emulator_options& from) {
  EmulatorOptions to;
  to.seed = from.seed;
  to.control_rate_hz = from.control_rate_hz;
  if (from.plant != nullptr)
    to.plant = from_c(need_sized(from.plant, "plant", "torsio_plant_params"));
  if (from.serial != nullptr) to.serial = from.serial;
  if (from.actuator != nullptr)
    to.actuator = from_c(need_sized(from.actuator, "actuator", "torsio_actuator_config"));
  if (from.control != nullptr)
    to.control = from_c(need_sized(from.control, "control", "torsio_control_config"));
  if (from.board != nullptr)
    to.board = from_c(need_sized(from.board, "board", "torsio_board_config"));
  if (from.game != nullptr) to.game = from_c(need_sized(from.game, "game", "torsio_game_config"));
  if (from.shaft != nullptr)
    to.shaft = from_c(need_sized(from.shaft, "shaft", "torsio_shaft_config"));
  to.paced = flag(from.paced);
  to.log_truth = flag(from.log_truth);
  return to;
}

inline torsio_timing to_c([[maybe_unused]] const Timing& from) {
  torsio_timing to{};
  to.delay_s = from.delay_s;
  to.duration_s = from.duration_s;
  to.attack_level = from.attack_level;
  to.attack_s = from.attack_s;
  to.fade_level = from.fade_level;
  to.fade_s = from.fade_s;
  return to;
}
inline torsio_wall to_c([[maybe_unused]] const Wall& from) {
  torsio_wall to{};
  to.struct_size = sizeof(torsio_wall);
  to.angle_rad = from.angle_rad;
  to.side = static_cast<std::int32_t>(from.side);
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  return to;
}
inline torsio_spring to_c([[maybe_unused]] const Spring& from) {
  torsio_spring to{};
  to.struct_size = sizeof(torsio_spring);
  to.angle_rad = from.angle_rad;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.deadband_rad = from.deadband_rad;
  to.torque_limit_nm = from.torque_limit_nm;
  return to;
}
inline torsio_damper to_c([[maybe_unused]] const Damper& from) {
  torsio_damper to{};
  to.struct_size = sizeof(torsio_damper);
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.torque_limit_nm = from.torque_limit_nm;
  return to;
}
inline torsio_friction to_c([[maybe_unused]] const Friction& from) {
  torsio_friction to{};
  to.struct_size = sizeof(torsio_friction);
  to.torque_nm = from.torque_nm;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  return to;
}
inline torsio_inertia to_c([[maybe_unused]] const Inertia& from) {
  torsio_inertia to{};
  to.struct_size = sizeof(torsio_inertia);
  to.inertia_kg_m2 = from.inertia_kg_m2;
  to.torque_limit_nm = from.torque_limit_nm;
  return to;
}
inline torsio_constant to_c([[maybe_unused]] const Constant& from) {
  torsio_constant to{};
  to.struct_size = sizeof(torsio_constant);
  to.torque_nm = from.torque_nm;
  to.timing = to_c(from.timing);
  return to;
}
inline torsio_ramp to_c([[maybe_unused]] const Ramp& from) {
  torsio_ramp to{};
  to.struct_size = sizeof(torsio_ramp);
  to.start_torque_nm = from.start_torque_nm;
  to.end_torque_nm = from.end_torque_nm;
  to.timing = to_c(from.timing);
  return to;
}
inline torsio_periodic to_c([[maybe_unused]] const Periodic& from) {
  torsio_periodic to{};
  to.struct_size = sizeof(torsio_periodic);
  to.waveform = static_cast<std::int32_t>(from.waveform);
  to.amplitude_nm = from.amplitude_nm;
  to.offset_nm = from.offset_nm;
  to.frequency_hz = from.frequency_hz;
  to.phase_turns = from.phase_turns;
  to.timing = to_c(from.timing);
  return to;
}
inline torsio_detents to_c([[maybe_unused]] const Detents& from) {
  torsio_detents to{};
  to.struct_size = sizeof(torsio_detents);
  to.angle_rad = from.angle_rad;
  to.per_turn = from.per_turn.value_or(0.0);
  to.pitch_rad = from.pitch_rad.value_or(0.0);
  to.torque_nm = from.torque_nm;
  to.profile = static_cast<std::int32_t>(from.profile);
  to.width = from.width;
  return to;
}
inline torsio_end_stops to_c([[maybe_unused]] const EndStops& from) {
  torsio_end_stops to{};
  to.struct_size = sizeof(torsio_end_stops);
  to.lower_rad = from.lower_rad;
  to.upper_rad = from.upper_rad;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  return to;
}
inline torsio_texture to_c([[maybe_unused]] const Texture& from) {
  torsio_texture to{};
  to.struct_size = sizeof(torsio_texture);
  to.grains_per_turn = from.grains_per_turn;
  to.torque_nm = from.torque_nm;
  to.grain = static_cast<std::int32_t>(from.grain);
  to.seed = from.seed;
  return to;
}
inline torsio_curve to_c([[maybe_unused]] const Curve& from) {
  torsio_curve to{};
  to.struct_size = sizeof(torsio_curve);
  to.torque_nm = nullptr;
  to.torque_nm_count = 0;
  to.angle_rad = from.angle_rad;
  to.span_rad = from.span_rad;
  to.ends = static_cast<std::int32_t>(from.ends);
  return to;
}
inline torsio_impact to_c([[maybe_unused]] const Impact& from) {
  torsio_impact to{};
  to.struct_size = sizeof(torsio_impact);
  to.angle_rad = from.angle_rad;
  to.side = static_cast<std::int32_t>(from.side);
  to.strength_nm_s_per_rad = from.strength_nm_s_per_rad;
  to.frequency_hz = from.frequency_hz;
  to.decay_s = from.decay_s;
  to.pulse_nm_s_per_rad = from.pulse_nm_s_per_rad;
  to.pulse_s = from.pulse_s;
  to.torque_limit_nm = from.torque_limit_nm;
  return to;
}
inline torsio_local_model to_c([[maybe_unused]] const LocalModel& from) {
  torsio_local_model to{};
  to.struct_size = sizeof(torsio_local_model);
  to.torque_nm = from.torque_nm;
  to.angle_rad = from.angle_rad;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.deadline_s = from.deadline_s;
  return to;
}
inline torsio_excitation to_c([[maybe_unused]] const Excitation& from) {
  torsio_excitation to{};
  to.struct_size = sizeof(torsio_excitation);
  to.duration_s = from.duration_s;
  to.travel_rad = from.travel_rad;
  to.speed_limit_rad_s = from.speed_limit_rad_s;
  to.torque_limit_nm = from.torque_limit_nm;
  to.motor_command_nm = from.motor_command_nm;
  to.brake_command_nm = from.brake_command_nm;
  to.ramp_s = from.ramp_s;
  to.sine_nm = from.sine_nm;
  to.sine_begin_hz = from.sine_begin_hz;
  to.sine_end_hz = from.sine_end_hz;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.servo_rad_s = from.servo_rad_s;
  return to;
}
inline torsio_actuator_config to_c([[maybe_unused]] const ActuatorConfig& from) {
  torsio_actuator_config to{};
  to.struct_size = sizeof(torsio_actuator_config);
  to.motor_torque_max_nm = from.motor_torque_max_nm;
  to.brake_torque_max_nm = from.brake_torque_max_nm;
  to.brake_torque_min_nm = from.brake_torque_min_nm;
  to.brake_drag_nm = from.brake_drag_nm;
  to.brake_time_constant_s = from.brake_time_constant_s;
  to.spring_stiffness_nm_per_rad = from.spring_stiffness_nm_per_rad;
  to.counts_per_rev = from.counts_per_rev;
  to.counter_bits = from.counter_bits;
  to.encoder_reversed = from.encoder_reversed;
  to.knob_inertia_kg_m2 = from.knob_inertia_kg_m2;
  to.knob_coulomb_nm = from.knob_coulomb_nm;
  to.knob_viscous_nm_s_per_rad = from.knob_viscous_nm_s_per_rad;
  to.motor_time_constant_s = from.motor_time_constant_s;
  to.brake_inertia_kg_m2 = from.brake_inertia_kg_m2;
  to.brake_hysteresis_nm = from.brake_hysteresis_nm;
  to.brake_release_time_constant_s = from.brake_release_time_constant_s;
  to.encoder_index_pin = from.encoder_index_pin;
  return to;
}
inline torsio_control_config to_c([[maybe_unused]] const ControlConfig& from) {
  torsio_control_config to{};
  to.struct_size = sizeof(torsio_control_config);
  to.law = static_cast<std::int32_t>(from.law);
  to.beta = from.beta;
  to.speed_bandwidth_hz = from.speed_bandwidth_hz;
  to.motor_torque_cap_nm = from.motor_torque_cap_nm;
  to.brake_torque_cap_nm = from.brake_torque_cap_nm;
  to.motor_slew_nm_per_s = from.motor_slew_nm_per_s;
  to.speed_limit_rad_s = from.speed_limit_rad_s;
  to.watchdog_s = from.watchdog_s;
  to.passive_ramp_s = from.passive_ramp_s;
  to.passive_brake_nm = from.passive_brake_nm;
  to.autonomous = from.autonomous;
  to.free_assist_nm = from.free_assist_nm;
  return to;
}
inline torsio_board_config to_c([[maybe_unused]] const BoardConfig& from) {
  torsio_board_config to{};
  to.struct_size = sizeof(torsio_board_config);
  to.supply_v = from.supply_v;
  to.motor_torque_constant_nm_per_a = from.motor_torque_constant_nm_per_a;
  to.motor_current_max_a = from.motor_current_max_a;
  to.motor_current_continuous_a = from.motor_current_continuous_a;
  to.motor_resistance_ohm = from.motor_resistance_ohm;
  to.motor_inductance_h = from.motor_inductance_h;
  to.current_bandwidth_hz = from.current_bandwidth_hz;
  to.current_sense_v_per_a = from.current_sense_v_per_a;
  to.brake_torque_constant_nm_per_a = from.brake_torque_constant_nm_per_a;
  to.brake_current_max_a = from.brake_current_max_a;
  to.brake_resistance_ohm = from.brake_resistance_ohm;
  to.brake_inductance_h = from.brake_inductance_h;
  to.motor_reversed = from.motor_reversed;
  to.confirmed = from.confirmed;
  to.brake_continuous_percent = from.brake_continuous_percent;
  to.ambient_c = from.ambient_c;
  to.supply_sense_ratio = from.supply_sense_ratio;
  to.encoder_pin = from.encoder_pin;
  to.motor_pin = from.motor_pin;
  to.brake_pin = from.brake_pin;
  to.enable_pin = from.enable_pin;
  to.emergency_stop_pin = from.emergency_stop_pin;
  to.driver_fault_pin = from.driver_fault_pin;
  to.current_sense_pin = from.current_sense_pin;
  to.supply_sense_pin = from.supply_sense_pin;
  to.light_pin = from.light_pin;
  return to;
}
inline torsio_game_config to_c([[maybe_unused]] const GameConfig& from) {
  torsio_game_config to{};
  to.struct_size = sizeof(torsio_game_config);
  to.enabled = from.enabled;
  to.range_deg = from.range_deg;
  to.torque_max_nm = from.torque_max_nm;
  to.gain = from.gain;
  to.spring_gain = from.spring_gain;
  to.speed_full_rad_s = from.speed_full_rad_s;
  to.acceleration_full_rad_s2 = from.acceleration_full_rad_s2;
  to.blend_s = from.blend_s;
  to.silence_s = from.silence_s;
  to.join_updates = from.join_updates;
  to.end_stiffness_nm_per_rad = from.end_stiffness_nm_per_rad;
  to.personality = static_cast<std::int32_t>(from.personality);
  to.dial_use = static_cast<std::int32_t>(from.dial_use);
  to.dial_detents = from.dial_detents;
  to.dial_torque_nm = from.dial_torque_nm;
  to.own_damper_percent = from.own_damper_percent;
  to.own_friction_percent = from.own_friction_percent;
  to.own_inertia_percent = from.own_inertia_percent;
  to.own_spring_percent = from.own_spring_percent;
  to.constants_gain_percent = from.constants_gain_percent;
  to.waves_gain_percent = from.waves_gain_percent;
  to.springs_gain_percent = from.springs_gain_percent;
  to.dampers_gain_percent = from.dampers_gain_percent;
  to.inertias_gain_percent = from.inertias_gain_percent;
  to.frictions_gain_percent = from.frictions_gain_percent;
  to.torque_max_percent = from.torque_max_percent;
  to.reversed = from.reversed;
  to.dial_coarse = from.dial_coarse;
  to.dial_fast_steps = from.dial_fast_steps;
  to.remote_wakeup = from.remote_wakeup;
  return to;
}
inline torsio_shaft_config to_c([[maybe_unused]] const ShaftConfig& from) {
  torsio_shaft_config to{};
  to.struct_size = sizeof(torsio_shaft_config);
  to.knee_1_rad = from.knee_1_rad;
  to.knee_1_nm_per_rad = from.knee_1_nm_per_rad;
  to.knee_2_rad = from.knee_2_rad;
  to.knee_2_nm_per_rad = from.knee_2_nm_per_rad;
  to.knee_3_rad = from.knee_3_rad;
  to.knee_3_nm_per_rad = from.knee_3_nm_per_rad;
  to.knee_4_rad = from.knee_4_rad;
  to.knee_4_nm_per_rad = from.knee_4_nm_per_rad;
  return to;
}
inline torsio_calibration_config to_c([[maybe_unused]] const CalibrationConfig& from) {
  torsio_calibration_config to{};
  to.struct_size = sizeof(torsio_calibration_config);
  to.values_are = static_cast<std::int32_t>(from.values_are);
  to.calibrated_unix_s = from.calibrated_unix_s;
  to.ambient_k = from.ambient_k;
  to.calibrated_rate_hz = from.calibrated_rate_hz;
  to.sigma_knob_inertia_kg_m2 = from.sigma_knob_inertia_kg_m2;
  to.sigma_knob_coulomb_nm = from.sigma_knob_coulomb_nm;
  to.sigma_knob_viscous_nm_s_per_rad = from.sigma_knob_viscous_nm_s_per_rad;
  to.sigma_spring_stiffness_nm_per_rad = from.sigma_spring_stiffness_nm_per_rad;
  to.sigma_knee_1_rad = from.sigma_knee_1_rad;
  to.sigma_knee_1_nm_per_rad = from.sigma_knee_1_nm_per_rad;
  to.sigma_brake_drag_nm = from.sigma_brake_drag_nm;
  to.sigma_brake_time_constant_s = from.sigma_brake_time_constant_s;
  to.sigma_brake_release_time_constant_s = from.sigma_brake_release_time_constant_s;
  to.sigma_brake_inertia_kg_m2 = from.sigma_brake_inertia_kg_m2;
  to.sigma_brake_hysteresis_nm = from.sigma_brake_hysteresis_nm;
  to.sigma_motor_resistance_permille = from.sigma_motor_resistance_permille;
  to.sigma_motor_inductance_permille = from.sigma_motor_inductance_permille;
  to.sigma_motor_torque_constant_permille = from.sigma_motor_torque_constant_permille;
  return to;
}
inline torsio_torque_hand to_c([[maybe_unused]] const TorqueHand& from) {
  torsio_torque_hand to{};
  to.struct_size = sizeof(torsio_torque_hand);
  to.torque_nm = nullptr;
  to.torque_nm_count = 0;
  return to;
}
inline torsio_impedance_hand to_c([[maybe_unused]] const ImpedanceHand& from) {
  torsio_impedance_hand to{};
  to.struct_size = sizeof(torsio_impedance_hand);
  to.inertia_kg_m2 = from.inertia_kg_m2;
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.intended_angle_rad = nullptr;
  to.intended_angle_rad_count = 0;
  return to;
}
inline torsio_prescribed_motion to_c([[maybe_unused]] const PrescribedMotion& from) {
  torsio_prescribed_motion to{};
  to.struct_size = sizeof(torsio_prescribed_motion);
  to.angle_rad = nullptr;
  to.angle_rad_count = 0;
  return to;
}
inline torsio_shaft_hardening to_c([[maybe_unused]] const ShaftHardening& from) {
  torsio_shaft_hardening to{};
  to.struct_size = sizeof(torsio_shaft_hardening);
  to.knee_rad = from.knee_rad;
  to.stiffness_factor = from.stiffness_factor;
  return to;
}
inline torsio_brake_hysteresis to_c([[maybe_unused]] const BrakeHysteresis& from) {
  torsio_brake_hysteresis to{};
  to.struct_size = sizeof(torsio_brake_hysteresis);
  to.half_width_nm = from.half_width_nm;
  return to;
}
inline torsio_belt to_c([[maybe_unused]] const Belt& from) {
  torsio_belt to{};
  to.struct_size = sizeof(torsio_belt);
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  to.damping_nm_s_per_rad = from.damping_nm_s_per_rad;
  to.pulley_inertia_kg_m2 = from.pulley_inertia_kg_m2;
  return to;
}
inline torsio_cogging to_c([[maybe_unused]] const Cogging& from) {
  torsio_cogging to{};
  to.struct_size = sizeof(torsio_cogging);
  to.periods_per_rev = from.periods_per_rev;
  to.torque_nm = nullptr;
  to.torque_nm_count = 0;
  return to;
}
inline torsio_electrics to_c([[maybe_unused]] const Electrics& from) {
  torsio_electrics to{};
  to.struct_size = sizeof(torsio_electrics);
  to.winding_resistance_ohm = from.winding_resistance_ohm;
  to.winding_inductance_h = from.winding_inductance_h;
  to.torque_constant_nm_per_a = from.torque_constant_nm_per_a;
  to.motor_reversed = from.motor_reversed;
  to.coil_resistance_ohm = from.coil_resistance_ohm;
  to.coil_inductance_h = from.coil_inductance_h;
  to.coil_torque_constant_nm_per_a = from.coil_torque_constant_nm_per_a;
  to.supply_v = from.supply_v;
  to.supply_resistance_ohm = from.supply_resistance_ohm;
  to.supply_capacitance_f = from.supply_capacitance_f;
  to.supply_divider_ratio = from.supply_divider_ratio;
  to.ambient_c = from.ambient_c;
  to.winding_heat_j_per_k = from.winding_heat_j_per_k;
  to.winding_to_rotor_k_per_w = from.winding_to_rotor_k_per_w;
  to.rotor_heat_j_per_k = from.rotor_heat_j_per_k;
  to.rotor_to_air_k_per_w = from.rotor_to_air_k_per_w;
  to.coil_heat_j_per_k = from.coil_heat_j_per_k;
  to.coil_to_air_k_per_w = from.coil_to_air_k_per_w;
  to.pwm_steps = from.pwm_steps;
  to.current_period_s = from.current_period_s;
  to.output_delay_s = from.output_delay_s;
  to.predictive = from.predictive;
  to.sample_offset_s = from.sample_offset_s;
  to.sensor_v_per_a = from.sensor_v_per_a;
  to.sensor_zero_v = from.sensor_zero_v;
  to.sensor_noise_v = from.sensor_noise_v;
  to.sensor_range_v = from.sensor_range_v;
  to.sensor_bits = from.sensor_bits;
  to.sensor_state = static_cast<std::int32_t>(from.sensor_state);
  return to;
}
inline torsio_plant_params to_c([[maybe_unused]] const PlantParams& from) {
  torsio_plant_params to{};
  to.struct_size = sizeof(torsio_plant_params);
  to.knob_inertia_kg_m2 = from.knob_inertia_kg_m2;
  to.knob_viscous_nm_s_per_rad = from.knob_viscous_nm_s_per_rad;
  to.knob_coulomb_nm = from.knob_coulomb_nm;
  to.brake_inertia_kg_m2 = from.brake_inertia_kg_m2;
  to.brake_viscous_nm_s_per_rad = from.brake_viscous_nm_s_per_rad;
  to.brake_drag_nm = from.brake_drag_nm;
  to.shaft_stiffness_nm_per_rad = from.shaft_stiffness_nm_per_rad;
  to.shaft_damping_nm_s_per_rad = from.shaft_damping_nm_s_per_rad;
  to.brake_time_constant_s = from.brake_time_constant_s;
  to.motor_time_constant_s = from.motor_time_constant_s;
  to.motor_limit_nm = from.motor_limit_nm;
  to.brake_limit_nm = from.brake_limit_nm;
  to.counts_per_rev = from.counts_per_rev;
  to.encoder_rounding = static_cast<std::int32_t>(from.encoder_rounding);
  to.encoder_index = static_cast<std::int32_t>(from.encoder_index);
  to.encoder_phase_counts = from.encoder_phase_counts;
  to.encoder_noise_counts = from.encoder_noise_counts;
  to.spring_and_brake = from.spring_and_brake;
  to.shaft_hardening = nullptr;
  to.brake_hysteresis = nullptr;
  to.belt = nullptr;
  to.cogging = nullptr;
  to.electrics = nullptr;
  return to;
}
inline torsio_link_faults to_c([[maybe_unused]] const LinkFaults& from) {
  torsio_link_faults to{};
  to.struct_size = sizeof(torsio_link_faults);
  to.drop_output = from.drop_output;
  to.corrupt_output = from.corrupt_output;
  to.drop_input = from.drop_input;
  to.corrupt_input = from.corrupt_input;
  return to;
}
inline torsio_emulator_options to_c([[maybe_unused]] const EmulatorOptions& from) {
  torsio_emulator_options to{};
  to.struct_size = sizeof(torsio_emulator_options);
  to.seed = from.seed;
  to.control_rate_hz = from.control_rate_hz;
  to.plant = nullptr;
  to.serial = nullptr;
  to.actuator = nullptr;
  to.control = nullptr;
  to.board = nullptr;
  to.game = nullptr;
  to.shaft = nullptr;
  to.paced = from.paced;
  to.log_truth = from.log_truth;
  return to;
}
inline torsio_listed_device to_c([[maybe_unused]] const ListedDevice& from) {
  torsio_listed_device to{};
  copy(to.path, from.path);
  copy(to.serial, from.serial);
  copy(to.product, from.product);
  copy(to.board, from.board);
  copy(to.transport, from.transport);
  copy(to.problem, from.problem);
  return to;
}
inline torsio_device_info to_c([[maybe_unused]] const DeviceInfo& from) {
  torsio_device_info to{};
  to.struct_size = sizeof(torsio_device_info);
  copy(to.path, from.path);
  copy(to.serial, from.serial);
  copy(to.product, from.product);
  copy(to.board, from.board);
  copy(to.firmware_version, from.firmware_version);
  copy(to.transport, from.transport);
  to.protocol_version = from.protocol_version;
  to.fingerprint = from.fingerprint;
  to.axes = from.axes;
  to.effects = from.effects;
  to.curve_points = from.curve_points;
  to.control_rate_hz = from.control_rate_hz;
  to.counts_per_rev = from.counts_per_rev;
  to.torque_step_nm = from.torque_step_nm;
  to.speed_step_rad_s = from.speed_step_rad_s;
  return to;
}
inline torsio_clock to_c([[maybe_unused]] const Clock& from) {
  torsio_clock to{};
  to.struct_size = sizeof(torsio_clock);
  to.tick = from.tick;
  to.time_s = from.time_s;
  to.position_counts = from.position_counts;
  to.angle_rad = from.angle_rad;
  return to;
}
inline torsio_health to_c([[maybe_unused]] const Health& from) {
  torsio_health to{};
  to.struct_size = sizeof(torsio_health);
  to.state = static_cast<std::int32_t>(from.state);
  to.faults = fault_bits(from.faults);
  to.reports_accepted = from.reports_accepted;
  to.reports_refused = from.reports_refused;
  to.samples_dropped = from.samples_dropped;
  to.tick_overruns = from.tick_overruns;
  to.tick_time_s = from.tick_time_s;
  to.tick_time_max_s = from.tick_time_max_s;
  to.saves = from.saves;
  to.owner = static_cast<std::int32_t>(from.owner);
  to.reset_cause = static_cast<std::int32_t>(from.reset_cause);
  to.unexpected_swings = from.unexpected_swings;
  to.centre = static_cast<std::int32_t>(from.centre);
  return to;
}
inline torsio_energies to_c([[maybe_unused]] const Energies& from) {
  torsio_energies to{};
  to.struct_size = sizeof(torsio_energies);
  to.tick = from.tick;
  to.time_s = from.time_s;
  to.kept = from.kept;
  to.motor_j = from.motor_j;
  to.felt_j = from.felt_j;
  to.stored_j = from.stored_j;
  to.brake_j = from.brake_j;
  to.bound_nm_per_rad = from.bound_nm_per_rad;
  return to;
}
inline torsio_motor_current to_c([[maybe_unused]] const MotorCurrent& from) {
  torsio_motor_current to{};
  to.struct_size = sizeof(torsio_motor_current);
  to.measured = from.measured;
  to.time_s = from.time_s;
  to.angle_rad = from.angle_rad;
  to.period_s = from.period_s;
  to.delay_s = from.delay_s;
  to.periods = from.periods;
  to.current_a = from.current_a;
  to.zero_a = from.zero_a;
  to.step_a = from.step_a;
  to.current_sum_a = from.current_sum_a;
  to.share = from.share;
  to.share_before = from.share_before;
  to.share_sum = from.share_sum;
  to.torque_constant_nm_per_a = from.torque_constant_nm_per_a;
  return to;
}
inline torsio_limits to_c([[maybe_unused]] const Limits& from) {
  torsio_limits to{};
  to.struct_size = sizeof(torsio_limits);
  to.motor_torque_max_nm = from.motor_torque_max_nm;
  to.motor_torque_continuous_max_nm = from.motor_torque_continuous_max_nm;
  to.brake_torque_max_nm = from.brake_torque_max_nm;
  to.speed_limit_rad_s = from.speed_limit_rad_s;
  to.held_low = from.held_low;
  return to;
}
inline torsio_stable_stiffness to_c([[maybe_unused]] const StableStiffness& from) {
  torsio_stable_stiffness to{};
  to.struct_size = sizeof(torsio_stable_stiffness);
  to.stiffness_nm_per_rad = from.stiffness_nm_per_rad;
  copy(to.limited_by, from.limited_by);
  return to;
}
inline torsio_game_status to_c([[maybe_unused]] const GameStatus& from) {
  torsio_game_status to{};
  to.struct_size = sizeof(torsio_game_status);
  to.time_s = from.time_s;
  to.owner = static_cast<std::int32_t>(from.owner);
  to.paused = from.paused;
  to.enabled = from.enabled;
  to.gain = from.gain;
  to.torque_nm = from.torque_nm;
  to.updates = from.updates;
  to.effects = from.effects;
  to.clipped_ticks = from.clipped_ticks;
  to.asked_percent = from.asked_percent;
  return to;
}
inline torsio_game_effect to_c([[maybe_unused]] const GameEffect& from) {
  torsio_game_effect to{};
  to.block = from.block;
  to.kind = static_cast<std::int32_t>(from.kind);
  to.state = static_cast<std::int32_t>(from.state);
  to.torque_nm = from.torque_nm;
  to.updates = from.updates;
  to.silent_s = from.silent_s;
  return to;
}
inline torsio_link_statistics to_c([[maybe_unused]] const LinkStatistics& from) {
  torsio_link_statistics to{};
  to.struct_size = sizeof(torsio_link_statistics);
  to.reports_sent = from.reports_sent;
  to.reports_received = from.reports_received;
  to.reports_undecodable = from.reports_undecodable;
  to.samples_received = from.samples_received;
  to.samples_lost = from.samples_lost;
  to.events_lost = from.events_lost;
  to.local_models_refused = from.local_models_refused;
  copy(to.last_refusal, from.last_refusal);
  return to;
}
inline torsio_event to_c([[maybe_unused]] const Event& from) {
  torsio_event to{};
  to.struct_size = sizeof(torsio_event);
  copy(to.kind, from.kind);
  to.state = static_cast<std::int32_t>(from.state);
  to.owner = static_cast<std::int32_t>(from.owner);
  to.faults = fault_bits(from.faults);
  to.tick = from.tick;
  to.time_s = from.time_s;
  return to;
}
inline torsio_disarm to_c([[maybe_unused]] const Disarm& from) {
  torsio_disarm to{};
  to.struct_size = sizeof(torsio_disarm);
  to.reason = static_cast<std::int32_t>(from.reason);
  to.faults = fault_bits(from.faults);
  to.tick = from.tick;
  to.time_s = from.time_s;
  return to;
}
inline torsio_electrics_state to_c([[maybe_unused]] const ElectricsState& from) {
  torsio_electrics_state to{};
  to.struct_size = sizeof(torsio_electrics_state);
  to.motor_current_a = from.motor_current_a;
  to.coil_current_a = from.coil_current_a;
  to.supply_v = from.supply_v;
  to.winding_c = from.winding_c;
  to.rotor_c = from.rotor_c;
  to.coil_c = from.coil_c;
  return to;
}

// Samples go over as they are.
static_assert(sizeof(torsio_telemetry_sample) == sizeof(TelemetrySample));
static_assert(offsetof(torsio_telemetry_sample, tick) == offsetof(TelemetrySample, tick));
static_assert(offsetof(torsio_telemetry_sample, time_s) == offsetof(TelemetrySample, time_s));
static_assert(offsetof(torsio_telemetry_sample, position_counts) ==
              offsetof(TelemetrySample, position_counts));
static_assert(offsetof(torsio_telemetry_sample, angle_rad) == offsetof(TelemetrySample, angle_rad));
static_assert(offsetof(torsio_telemetry_sample, speed_rad_s) ==
              offsetof(TelemetrySample, speed_rad_s));
static_assert(offsetof(torsio_telemetry_sample, desired_torque_nm) ==
              offsetof(TelemetrySample, desired_torque_nm));
static_assert(offsetof(torsio_telemetry_sample, motor_command_nm) ==
              offsetof(TelemetrySample, motor_command_nm));
static_assert(offsetof(torsio_telemetry_sample, brake_capacity_nm) ==
              offsetof(TelemetrySample, brake_capacity_nm));
static_assert(offsetof(torsio_telemetry_sample, spring_torque_nm) ==
              offsetof(TelemetrySample, spring_torque_nm));
static_assert(offsetof(torsio_telemetry_sample, flags) == offsetof(TelemetrySample, flags));
static_assert(sizeof(torsio_truth_sample) == sizeof(TruthSample));
static_assert(offsetof(torsio_truth_sample, time_s) == offsetof(TruthSample, time_s));
static_assert(offsetof(torsio_truth_sample, angle_rad) == offsetof(TruthSample, angle_rad));
static_assert(offsetof(torsio_truth_sample, brake_angle_rad) ==
              offsetof(TruthSample, brake_angle_rad));
static_assert(offsetof(torsio_truth_sample, speed_rad_s) == offsetof(TruthSample, speed_rad_s));
static_assert(offsetof(torsio_truth_sample, spring_torque_nm) ==
              offsetof(TruthSample, spring_torque_nm));
static_assert(offsetof(torsio_truth_sample, brake_torque_nm) ==
              offsetof(TruthSample, brake_torque_nm));
static_assert(offsetof(torsio_truth_sample, brake_capacity_nm) ==
              offsetof(TruthSample, brake_capacity_nm));
static_assert(offsetof(torsio_truth_sample, motor_torque_nm) ==
              offsetof(TruthSample, motor_torque_nm));
static_assert(offsetof(torsio_truth_sample, hand_torque_nm) ==
              offsetof(TruthSample, hand_torque_nm));

}  // namespace torsio::c
