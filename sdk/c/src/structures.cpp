// The functions of torsio_types.h.
//
// Printed from the field lists in firmware/protocol/definition/ and emulator/definition/ by `./dev
// generate`; change those instead.
#include "structures.hpp"

#include "handles.hpp"
#include "torsio.h"
#include "torsio/fields.hpp"
#include "torsio/plant_fields.hpp"

const char* torsio_side_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Side>(value);
}
const char* torsio_waveform_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Waveform>(value);
}
const char* torsio_detent_profile_name(std::int32_t value) {
  return torsio::c::value_name<torsio::DetentProfile>(value);
}
const char* torsio_grain_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Grain>(value);
}
const char* torsio_ends_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Ends>(value);
}
const char* torsio_law_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Law>(value);
}
const char* torsio_basis_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Basis>(value);
}
const char* torsio_personality_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Personality>(value);
}
const char* torsio_dial_use_name(std::int32_t value) {
  return torsio::c::value_name<torsio::DialUse>(value);
}
const char* torsio_state_name(std::int32_t value) {
  return torsio::c::value_name<torsio::State>(value);
}
const char* torsio_owner_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Owner>(value);
}
const char* torsio_game_effect_kind_name(std::int32_t value) {
  return torsio::c::value_name<torsio::GameEffectKind>(value);
}
const char* torsio_game_effect_state_name(std::int32_t value) {
  return torsio::c::value_name<torsio::GameEffectState>(value);
}
const char* torsio_reset_cause_name(std::int32_t value) {
  return torsio::c::value_name<torsio::ResetCause>(value);
}
const char* torsio_centre_name(std::int32_t value) {
  return torsio::c::value_name<torsio::Centre>(value);
}
const char* torsio_disarm_reason_name(std::int32_t value) {
  return torsio::c::value_name<torsio::DisarmReason>(value);
}
const char* torsio_encoder_rounding_name(std::int32_t value) {
  return torsio::c::value_name<torsio::EncoderRounding>(value);
}
const char* torsio_current_sensor_state_name(std::int32_t value) {
  return torsio::c::value_name<torsio::CurrentSensorState>(value);
}

torsio_result torsio_wall_init(torsio_wall* structure) {
  return torsio::c::init<torsio::Wall>(structure);
}
torsio_result torsio_spring_init(torsio_spring* structure) {
  return torsio::c::init<torsio::Spring>(structure);
}
torsio_result torsio_damper_init(torsio_damper* structure) {
  return torsio::c::init<torsio::Damper>(structure);
}
torsio_result torsio_friction_init(torsio_friction* structure) {
  return torsio::c::init<torsio::Friction>(structure);
}
torsio_result torsio_inertia_init(torsio_inertia* structure) {
  return torsio::c::init<torsio::Inertia>(structure);
}
torsio_result torsio_constant_init(torsio_constant* structure) {
  return torsio::c::init<torsio::Constant>(structure);
}
torsio_result torsio_ramp_init(torsio_ramp* structure) {
  return torsio::c::init<torsio::Ramp>(structure);
}
torsio_result torsio_periodic_init(torsio_periodic* structure) {
  return torsio::c::init<torsio::Periodic>(structure);
}
torsio_result torsio_detents_init(torsio_detents* structure) {
  return torsio::c::init<torsio::Detents>(structure);
}
torsio_result torsio_end_stops_init(torsio_end_stops* structure) {
  return torsio::c::init<torsio::EndStops>(structure);
}
torsio_result torsio_texture_init(torsio_texture* structure) {
  return torsio::c::init<torsio::Texture>(structure);
}
torsio_result torsio_curve_init(torsio_curve* structure) {
  return torsio::c::init<torsio::Curve>(structure);
}
torsio_result torsio_impact_init(torsio_impact* structure) {
  return torsio::c::init<torsio::Impact>(structure);
}
torsio_result torsio_local_model_init(torsio_local_model* structure) {
  return torsio::c::init<torsio::LocalModel>(structure);
}
torsio_result torsio_excitation_init(torsio_excitation* structure) {
  return torsio::c::init<torsio::Excitation>(structure);
}
torsio_result torsio_actuator_config_init(torsio_actuator_config* structure) {
  return torsio::c::init<torsio::ActuatorConfig>(structure);
}
torsio_result torsio_control_config_init(torsio_control_config* structure) {
  return torsio::c::init<torsio::ControlConfig>(structure);
}
torsio_result torsio_board_config_init(torsio_board_config* structure) {
  return torsio::c::init<torsio::BoardConfig>(structure);
}
torsio_result torsio_game_config_init(torsio_game_config* structure) {
  return torsio::c::init<torsio::GameConfig>(structure);
}
torsio_result torsio_shaft_config_init(torsio_shaft_config* structure) {
  return torsio::c::init<torsio::ShaftConfig>(structure);
}
torsio_result torsio_calibration_config_init(torsio_calibration_config* structure) {
  return torsio::c::init<torsio::CalibrationConfig>(structure);
}
torsio_result torsio_torque_hand_init(torsio_torque_hand* structure) {
  return torsio::c::init<torsio::TorqueHand>(structure);
}
torsio_result torsio_impedance_hand_init(torsio_impedance_hand* structure) {
  return torsio::c::init<torsio::ImpedanceHand>(structure);
}
torsio_result torsio_prescribed_motion_init(torsio_prescribed_motion* structure) {
  return torsio::c::init<torsio::PrescribedMotion>(structure);
}
torsio_result torsio_shaft_hardening_init(torsio_shaft_hardening* structure) {
  return torsio::c::init<torsio::ShaftHardening>(structure);
}
torsio_result torsio_brake_hysteresis_init(torsio_brake_hysteresis* structure) {
  return torsio::c::init<torsio::BrakeHysteresis>(structure);
}
torsio_result torsio_belt_init(torsio_belt* structure) {
  return torsio::c::init<torsio::Belt>(structure);
}
torsio_result torsio_cogging_init(torsio_cogging* structure) {
  return torsio::c::init<torsio::Cogging>(structure);
}
torsio_result torsio_electrics_init(torsio_electrics* structure) {
  return torsio::c::init<torsio::Electrics>(structure);
}
torsio_result torsio_plant_params_init(torsio_plant_params* structure) {
  return torsio::c::init<torsio::PlantParams>(structure);
}
torsio_result torsio_link_faults_init(torsio_link_faults* structure) {
  return torsio::c::init<torsio::LinkFaults>(structure);
}
torsio_result torsio_emulator_options_init(torsio_emulator_options* structure) {
  return torsio::c::init<torsio::EmulatorOptions>(structure);
}
torsio_result torsio_device_info_init(torsio_device_info* structure) {
  return torsio::c::init<torsio::DeviceInfo>(structure);
}
torsio_result torsio_clock_init(torsio_clock* structure) {
  return torsio::c::init<torsio::Clock>(structure);
}
torsio_result torsio_health_init(torsio_health* structure) {
  return torsio::c::init<torsio::Health>(structure);
}
torsio_result torsio_energies_init(torsio_energies* structure) {
  return torsio::c::init<torsio::Energies>(structure);
}
torsio_result torsio_motor_current_init(torsio_motor_current* structure) {
  return torsio::c::init<torsio::MotorCurrent>(structure);
}
torsio_result torsio_limits_init(torsio_limits* structure) {
  return torsio::c::init<torsio::Limits>(structure);
}
torsio_result torsio_stable_stiffness_init(torsio_stable_stiffness* structure) {
  return torsio::c::init<torsio::StableStiffness>(structure);
}
torsio_result torsio_game_status_init(torsio_game_status* structure) {
  return torsio::c::init<torsio::GameStatus>(structure);
}
torsio_result torsio_link_statistics_init(torsio_link_statistics* structure) {
  return torsio::c::init<torsio::LinkStatistics>(structure);
}
torsio_result torsio_event_init(torsio_event* structure) {
  return torsio::c::init<torsio::Event>(structure);
}
torsio_result torsio_disarm_init(torsio_disarm* structure) {
  return torsio::c::init<torsio::Disarm>(structure);
}
torsio_result torsio_electrics_state_init(torsio_electrics_state* structure) {
  return torsio::c::init<torsio::ElectricsState>(structure);
}

torsio_result torsio_scene_add_wall(torsio_scene* scene, const torsio_wall* effect) {
  return torsio::c::add(scene, effect, "torsio_wall");
}
torsio_result torsio_scene_add_spring(torsio_scene* scene, const torsio_spring* effect) {
  return torsio::c::add(scene, effect, "torsio_spring");
}
torsio_result torsio_scene_add_damper(torsio_scene* scene, const torsio_damper* effect) {
  return torsio::c::add(scene, effect, "torsio_damper");
}
torsio_result torsio_scene_add_friction(torsio_scene* scene, const torsio_friction* effect) {
  return torsio::c::add(scene, effect, "torsio_friction");
}
torsio_result torsio_scene_add_inertia(torsio_scene* scene, const torsio_inertia* effect) {
  return torsio::c::add(scene, effect, "torsio_inertia");
}
torsio_result torsio_scene_add_constant(torsio_scene* scene, const torsio_constant* effect) {
  return torsio::c::add(scene, effect, "torsio_constant");
}
torsio_result torsio_scene_add_ramp(torsio_scene* scene, const torsio_ramp* effect) {
  return torsio::c::add(scene, effect, "torsio_ramp");
}
torsio_result torsio_scene_add_periodic(torsio_scene* scene, const torsio_periodic* effect) {
  return torsio::c::add(scene, effect, "torsio_periodic");
}
torsio_result torsio_scene_add_detents(torsio_scene* scene, const torsio_detents* effect) {
  return torsio::c::add(scene, effect, "torsio_detents");
}
torsio_result torsio_scene_add_end_stops(torsio_scene* scene, const torsio_end_stops* effect) {
  return torsio::c::add(scene, effect, "torsio_end_stops");
}
torsio_result torsio_scene_add_texture(torsio_scene* scene, const torsio_texture* effect) {
  return torsio::c::add(scene, effect, "torsio_texture");
}
torsio_result torsio_scene_add_curve(torsio_scene* scene, const torsio_curve* effect) {
  return torsio::c::add(scene, effect, "torsio_curve");
}
torsio_result torsio_scene_add_impact(torsio_scene* scene, const torsio_impact* effect) {
  return torsio::c::add(scene, effect, "torsio_impact");
}

torsio_result torsio_knob_actuator_config(torsio_knob* knob, torsio_actuator_config* config) {
  return torsio::c::get(knob, config, "torsio_actuator_config", &torsio::Knob::actuator_config);
}
torsio_result torsio_knob_set_actuator_config(torsio_knob* knob,
                                              const torsio_actuator_config* config) {
  return torsio::c::configure<torsio::ActuatorConfig>(knob, config, "torsio_actuator_config");
}
torsio_result torsio_knob_control_config(torsio_knob* knob, torsio_control_config* config) {
  return torsio::c::get(knob, config, "torsio_control_config", &torsio::Knob::control_config);
}
torsio_result torsio_knob_set_control_config(torsio_knob* knob,
                                             const torsio_control_config* config) {
  return torsio::c::configure<torsio::ControlConfig>(knob, config, "torsio_control_config");
}
torsio_result torsio_knob_board_config(torsio_knob* knob, torsio_board_config* config) {
  return torsio::c::get(knob, config, "torsio_board_config", &torsio::Knob::board_config);
}
torsio_result torsio_knob_set_board_config(torsio_knob* knob, const torsio_board_config* config) {
  return torsio::c::configure<torsio::BoardConfig>(knob, config, "torsio_board_config");
}
torsio_result torsio_knob_game_config(torsio_knob* knob, torsio_game_config* config) {
  return torsio::c::get(knob, config, "torsio_game_config", &torsio::Knob::game_config);
}
torsio_result torsio_knob_set_game_config(torsio_knob* knob, const torsio_game_config* config) {
  return torsio::c::configure<torsio::GameConfig>(knob, config, "torsio_game_config");
}
torsio_result torsio_knob_shaft_config(torsio_knob* knob, torsio_shaft_config* config) {
  return torsio::c::get(knob, config, "torsio_shaft_config", &torsio::Knob::shaft_config);
}
torsio_result torsio_knob_set_shaft_config(torsio_knob* knob, const torsio_shaft_config* config) {
  return torsio::c::configure<torsio::ShaftConfig>(knob, config, "torsio_shaft_config");
}
torsio_result torsio_knob_calibration_config(torsio_knob* knob, torsio_calibration_config* config) {
  return torsio::c::get(knob, config, "torsio_calibration_config",
                        &torsio::Knob::calibration_config);
}
torsio_result torsio_knob_set_calibration_config(torsio_knob* knob,
                                                 const torsio_calibration_config* config) {
  return torsio::c::configure<torsio::CalibrationConfig>(knob, config, "torsio_calibration_config");
}
