#ifndef TORSIO_BASE_H
#define TORSIO_BASE_H
#include <stdint.h>
#if defined(_WIN32) && defined(TORSIO_C_BUILD)
#define TORSIO_API __declspec(dllexport)
#elif defined(_WIN32)
#define TORSIO_API __declspec(dllimport)
#else
#define TORSIO_API __attribute__((visibility("default")))
#endif
#ifdef __cplusplus
extern "C" {
#endif
typedef enum torsio_result {
  TORSIO_OK = 0,
  TORSIO_INVALID_ARGUMENT = 1,
  TORSIO_DEVICE_NOT_FOUND = 2,
  TORSIO_PERMISSION_DENIED = 3,
  TORSIO_DEVICE_BUSY = 4,
  TORSIO_PROTOCOL_MISMATCH = 5,
  TORSIO_REFUSED = 6,
  TORSIO_DISARMED = 7,
  TORSIO_TIMEOUT = 8,
  TORSIO_DISCONNECTED = 9,
  TORSIO_CLOSED = 10,
  TORSIO_OUT_OF_MEMORY = 11,
  TORSIO_ERROR = 12,
} torsio_result;
#define TORSIO_TEXT_BYTES 256
typedef struct torsio_knob torsio_knob;
typedef struct torsio_scene torsio_scene;
typedef struct torsio_recording torsio_recording;
typedef struct torsio_steps torsio_steps;
typedef struct torsio_watch torsio_watch;
#ifdef __cplusplus
}
#endif
#endif
#ifndef TORSIO_TYPES_H
#define TORSIO_TYPES_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif
typedef enum torsio_side {
  TORSIO_SIDE_ABOVE = 0,
  TORSIO_SIDE_BELOW = 1,
} torsio_side;
TORSIO_API const char* torsio_side_name(int32_t value);
typedef enum torsio_waveform {
  TORSIO_WAVEFORM_SINE = 0,
  TORSIO_WAVEFORM_SQUARE = 1,
  TORSIO_WAVEFORM_TRIANGLE = 2,
  TORSIO_WAVEFORM_SAWTOOTH_UP = 3,
  TORSIO_WAVEFORM_SAWTOOTH_DOWN = 4,
} torsio_waveform;
TORSIO_API const char* torsio_waveform_name(int32_t value);
typedef enum torsio_detent_profile {
  TORSIO_DETENT_PROFILE_SINE = 0,
  TORSIO_DETENT_PROFILE_LINEAR = 1,
  TORSIO_DETENT_PROFILE_CLICK = 2,
} torsio_detent_profile;
TORSIO_API const char* torsio_detent_profile_name(int32_t value);
typedef enum torsio_grain {
  TORSIO_GRAIN_SINE = 0,
  TORSIO_GRAIN_SQUARE = 1,
  TORSIO_GRAIN_TRIANGLE = 2,
  TORSIO_GRAIN_NOISE = 3,
} torsio_grain;
TORSIO_API const char* torsio_grain_name(int32_t value);
typedef enum torsio_ends {
  TORSIO_ENDS_HOLD = 0,
  TORSIO_ENDS_REPEAT = 1,
} torsio_ends;
TORSIO_API const char* torsio_ends_name(int32_t value);
typedef enum torsio_law {
  TORSIO_LAW_PAPER = 0,
  TORSIO_LAW_COMPENSATED =
      1,
  TORSIO_LAW_PARALLEL =
      2,
  TORSIO_LAW_MOTOR_ONLY = 3,
  TORSIO_LAW_CALIBRATED =
      4,
} torsio_law;
TORSIO_API const char* torsio_law_name(int32_t value);
typedef enum torsio_basis {
  TORSIO_BASIS_ASSUMED =
      0,
  TORSIO_BASIS_STATED = 1,
  TORSIO_BASIS_MEASURED = 2,
} torsio_basis;
TORSIO_API const char* torsio_basis_name(int32_t value);
typedef enum torsio_personality {
  TORSIO_PERSONALITY_GAME_CONTROLLER = 0,
  TORSIO_PERSONALITY_DIAL = 1,
} torsio_personality;
TORSIO_API const char* torsio_personality_name(int32_t value);
typedef enum torsio_dial_use {
  TORSIO_DIAL_USE_WHEEL = 0,
  TORSIO_DIAL_USE_PAN = 1,
  TORSIO_DIAL_USE_VOLUME = 2,
} torsio_dial_use;
TORSIO_API const char* torsio_dial_use_name(int32_t value);
typedef enum torsio_state {
  TORSIO_STATE_DISARMED = 0,
  TORSIO_STATE_ARMED = 1,
  TORSIO_STATE_FAULT = 2,
  TORSIO_STATE_DISCONNECTED = 3,
} torsio_state;
TORSIO_API const char* torsio_state_name(int32_t value);
typedef enum torsio_owner {
  TORSIO_OWNER_NONE = 0,
  TORSIO_OWNER_SDK = 1,
  TORSIO_OWNER_GAME = 2,
  TORSIO_OWNER_DIAL = 3,
} torsio_owner;
TORSIO_API const char* torsio_owner_name(int32_t value);
typedef enum torsio_game_effect_kind {
  TORSIO_GAME_EFFECT_KIND_NONE = 0,
  TORSIO_GAME_EFFECT_KIND_CONSTANT = 1,
  TORSIO_GAME_EFFECT_KIND_RAMP = 2,
  TORSIO_GAME_EFFECT_KIND_SQUARE = 3,
  TORSIO_GAME_EFFECT_KIND_SINE = 4,
  TORSIO_GAME_EFFECT_KIND_TRIANGLE = 5,
  TORSIO_GAME_EFFECT_KIND_SAWTOOTH_UP = 6,
  TORSIO_GAME_EFFECT_KIND_SAWTOOTH_DOWN = 7,
  TORSIO_GAME_EFFECT_KIND_SPRING = 8,
  TORSIO_GAME_EFFECT_KIND_DAMPER = 9,
  TORSIO_GAME_EFFECT_KIND_INERTIA = 10,
  TORSIO_GAME_EFFECT_KIND_FRICTION = 11,
} torsio_game_effect_kind;
TORSIO_API const char* torsio_game_effect_kind_name(int32_t value);
typedef enum torsio_game_effect_state {
  TORSIO_GAME_EFFECT_STATE_STOPPED = 0,
  TORSIO_GAME_EFFECT_STATE_PLAYING = 1,
  TORSIO_GAME_EFFECT_STATE_SET_ASIDE =
      2,
} torsio_game_effect_state;
TORSIO_API const char* torsio_game_effect_state_name(int32_t value);
typedef enum torsio_reset_cause {
  TORSIO_RESET_CAUSE_UNKNOWN = 0,
  TORSIO_RESET_CAUSE_POWER = 1,
  TORSIO_RESET_CAUSE_BROWN_OUT = 2,
  TORSIO_RESET_CAUSE_RESET_PIN = 3,
  TORSIO_RESET_CAUSE_WATCHDOG = 4,
  TORSIO_RESET_CAUSE_HARD_FAULT = 5,
  TORSIO_RESET_CAUSE_STACK = 6,
} torsio_reset_cause;
TORSIO_API const char* torsio_reset_cause_name(int32_t value);
typedef enum torsio_disarm_reason {
  TORSIO_DISARM_REASON_ORDER = 0,
  TORSIO_DISARM_REASON_WATCHDOG = 1,
  TORSIO_DISARM_REASON_DEADLINE_MISSED = 2,
  TORSIO_DISARM_REASON_FAULT = 3,
  TORSIO_DISARM_REASON_GAME_IDLE = 4,
  TORSIO_DISARM_REASON_DISCONNECTED = 5,
  TORSIO_DISARM_REASON_UNKNOWN = 6,
  TORSIO_DISARM_REASON_EXCITATION_OVER =
      7,
  TORSIO_DISARM_REASON_EXCITATION_STOPPED =
      8,
  TORSIO_DISARM_REASON_DIAL_IDLE = 9,
} torsio_disarm_reason;
TORSIO_API const char* torsio_disarm_reason_name(int32_t value);
typedef enum torsio_encoder_rounding {
  TORSIO_ENCODER_ROUNDING_FLOOR = 0,
  TORSIO_ENCODER_ROUNDING_NEAREST = 1,
} torsio_encoder_rounding;
TORSIO_API const char* torsio_encoder_rounding_name(int32_t value);
typedef enum torsio_current_sensor_state {
  TORSIO_CURRENT_SENSOR_STATE_WORKS = 0,
  TORSIO_CURRENT_SENSOR_STATE_DEAD = 1,
  TORSIO_CURRENT_SENSOR_STATE_STUCK = 2,
  TORSIO_CURRENT_SENSOR_STATE_SATURATED = 3,
} torsio_current_sensor_state;
TORSIO_API const char* torsio_current_sensor_state_name(int32_t value);
enum {
  TORSIO_FLAG_STATE_MASK = 0x3,
  TORSIO_FLAG_MOTOR_SATURATED = 1 << 2,
  TORSIO_FLAG_BRAKE_SATURATED = 1 << 3,
  TORSIO_FLAG_LOCAL_MODEL = 1 << 4,
  TORSIO_FLAG_PASSIVE = 1 << 5,
  TORSIO_FLAG_GAME = 1 << 6,
  TORSIO_FLAG_BOUNDED = 1 << 7,
};
enum {
  TORSIO_FAULT_EMERGENCY_STOP = 1 << 0,
  TORSIO_FAULT_OVER_SPEED = 1 << 1,
  TORSIO_FAULT_ENCODER = 1 << 2,
  TORSIO_FAULT_ACTUATOR = 1 << 3,
  TORSIO_FAULT_OVERRUN = 1 << 4,
  TORSIO_FAULT_NUMERIC = 1 << 5,
  TORSIO_FAULT_CURRENT_SENSOR = 1 << 6,
  TORSIO_FAULT_WINDING = 1 << 7,
  TORSIO_FAULT_TEMPERATURE =
      1
      << 8,
  TORSIO_FAULT_SUPPLY =
      1 << 9,
};
typedef struct torsio_knot {
  double time_s;
  double value;
} torsio_knot;
typedef struct torsio_timing {
  double delay_s;
  double duration_s;
  double attack_level;
  double attack_s;
  double fade_level;
  double fade_s;
} torsio_timing;
typedef struct torsio_wall {
  uint32_t struct_size;
  double angle_rad;
  int32_t side;
  double stiffness_nm_per_rad;
  double damping_nm_s_per_rad;
} torsio_wall;
TORSIO_API torsio_result torsio_wall_init(torsio_wall* structure);
typedef struct torsio_spring {
  uint32_t struct_size;
  double angle_rad;
  double stiffness_nm_per_rad;
  double deadband_rad;
  double torque_limit_nm;
} torsio_spring;
TORSIO_API torsio_result torsio_spring_init(torsio_spring* structure);
typedef struct torsio_damper {
  uint32_t struct_size;
  double damping_nm_s_per_rad;
  double torque_limit_nm;
} torsio_damper;
TORSIO_API torsio_result torsio_damper_init(torsio_damper* structure);
typedef struct torsio_friction {
  uint32_t struct_size;
  double torque_nm;
  double stiffness_nm_per_rad;
} torsio_friction;
TORSIO_API torsio_result torsio_friction_init(torsio_friction* structure);
typedef struct torsio_inertia {
  uint32_t struct_size;
  double inertia_kg_m2;
  double torque_limit_nm;
} torsio_inertia;
TORSIO_API torsio_result torsio_inertia_init(torsio_inertia* structure);
typedef struct torsio_constant {
  uint32_t struct_size;
  double torque_nm;
  torsio_timing timing;
} torsio_constant;
TORSIO_API torsio_result torsio_constant_init(torsio_constant* structure);
typedef struct torsio_ramp {
  uint32_t struct_size;
  double start_torque_nm;
  double end_torque_nm;
  torsio_timing timing;
} torsio_ramp;
TORSIO_API torsio_result torsio_ramp_init(torsio_ramp* structure);
typedef struct torsio_periodic {
  uint32_t struct_size;
  int32_t waveform;
  double amplitude_nm;
  double offset_nm;
  double frequency_hz;
  double phase_turns;
  torsio_timing timing;
} torsio_periodic;
TORSIO_API torsio_result torsio_periodic_init(torsio_periodic* structure);
typedef struct torsio_detents {
  uint32_t struct_size;
  double angle_rad;
  double per_turn;
  double pitch_rad;
  double torque_nm;
  int32_t profile;
  double width;
} torsio_detents;
TORSIO_API torsio_result torsio_detents_init(torsio_detents* structure);
typedef struct torsio_end_stops {
  uint32_t struct_size;
  double lower_rad;
  double upper_rad;
  double stiffness_nm_per_rad;
  double damping_nm_s_per_rad;
} torsio_end_stops;
TORSIO_API torsio_result torsio_end_stops_init(torsio_end_stops* structure);
typedef struct torsio_texture {
  uint32_t struct_size;
  int32_t grains_per_turn;
  double torque_nm;
  int32_t grain;
  uint32_t seed;
} torsio_texture;
TORSIO_API torsio_result torsio_texture_init(torsio_texture* structure);
typedef struct torsio_curve {
  uint32_t struct_size;
  const double* torque_nm;
  size_t torque_nm_count;
  double angle_rad;
  double span_rad;
  int32_t ends;
} torsio_curve;
TORSIO_API torsio_result torsio_curve_init(torsio_curve* structure);
typedef struct torsio_impact {
  uint32_t struct_size;
  double angle_rad;
  int32_t side;
  double strength_nm_s_per_rad;
  double frequency_hz;
  double decay_s;
  double pulse_nm_s_per_rad;
  double pulse_s;
  double torque_limit_nm;
} torsio_impact;
TORSIO_API torsio_result torsio_impact_init(torsio_impact* structure);
typedef struct torsio_local_model {
  uint32_t struct_size;
  double torque_nm;
  double angle_rad;
  double stiffness_nm_per_rad;
  double damping_nm_s_per_rad;
  double deadline_s;
} torsio_local_model;
TORSIO_API torsio_result torsio_local_model_init(torsio_local_model* structure);
typedef struct torsio_excitation {
  uint32_t struct_size;
  double duration_s;
  double travel_rad;
  double speed_limit_rad_s;
  double torque_limit_nm;
  double motor_command_nm;
  double brake_command_nm;
  double ramp_s;
  double sine_nm;
  double sine_begin_hz;
  double sine_end_hz;
  double stiffness_nm_per_rad;
  double damping_nm_s_per_rad;
  double servo_rad_s;
} torsio_excitation;
TORSIO_API torsio_result torsio_excitation_init(torsio_excitation* structure);
typedef struct torsio_actuator_config {
  uint32_t struct_size;
  double motor_torque_max_nm;
  double brake_torque_max_nm;
  double brake_torque_min_nm;
  double brake_drag_nm;
  double brake_time_constant_s;
  double spring_stiffness_nm_per_rad;
  uint32_t counts_per_rev;
  int32_t counter_bits;
  bool encoder_reversed;
  double knob_inertia_kg_m2;
  double knob_coulomb_nm;
  double knob_viscous_nm_s_per_rad;
  double motor_time_constant_s;
  double brake_inertia_kg_m2;
  double brake_hysteresis_nm;
  double brake_release_time_constant_s;
} torsio_actuator_config;
TORSIO_API torsio_result torsio_actuator_config_init(torsio_actuator_config* structure);
typedef struct torsio_control_config {
  uint32_t struct_size;
  int32_t law;
  double beta;
  double speed_bandwidth_hz;
  double motor_torque_cap_nm;
  double brake_torque_cap_nm;
  double motor_slew_nm_per_s;
  double speed_limit_rad_s;
  double watchdog_s;
  double passive_ramp_s;
  double passive_brake_nm;
  bool autonomous;
  double free_assist_nm;
} torsio_control_config;
TORSIO_API torsio_result torsio_control_config_init(torsio_control_config* structure);
typedef struct torsio_board_config {
  uint32_t struct_size;
  double supply_v;
  double motor_torque_constant_nm_per_a;
  double motor_current_max_a;
  double motor_current_continuous_a;
  double motor_resistance_ohm;
  double motor_inductance_h;
  int32_t current_bandwidth_hz;
  double current_sense_v_per_a;
  double brake_torque_constant_nm_per_a;
  double brake_current_max_a;
  double brake_resistance_ohm;
  double brake_inductance_h;
  bool motor_reversed;
  bool confirmed;
  int32_t brake_continuous_percent;
  int32_t ambient_c;
  int32_t supply_sense_ratio;
  int32_t encoder_pin;
  int32_t motor_pin;
  int32_t brake_pin;
  int32_t enable_pin;
  int32_t emergency_stop_pin;
  int32_t driver_fault_pin;
  int32_t current_sense_pin;
  int32_t supply_sense_pin;
  int32_t light_pin;
} torsio_board_config;
TORSIO_API torsio_result torsio_board_config_init(torsio_board_config* structure);
typedef struct torsio_game_config {
  uint32_t struct_size;
  bool enabled;
  double range_deg;
  double torque_max_nm;
  double gain;
  double spring_gain;
  double speed_full_rad_s;
  double acceleration_full_rad_s2;
  double blend_s;
  double silence_s;
  bool join_updates;
  double end_stiffness_nm_per_rad;
  int32_t personality;
  int32_t dial_use;
  int32_t dial_detents;
  double dial_torque_nm;
} torsio_game_config;
TORSIO_API torsio_result torsio_game_config_init(torsio_game_config* structure);
typedef struct torsio_shaft_config {
  uint32_t struct_size;
  double knee_1_rad;
  double knee_1_nm_per_rad;
  double knee_2_rad;
  double knee_2_nm_per_rad;
  double knee_3_rad;
  double knee_3_nm_per_rad;
  double knee_4_rad;
  double knee_4_nm_per_rad;
} torsio_shaft_config;
TORSIO_API torsio_result torsio_shaft_config_init(torsio_shaft_config* structure);
typedef struct torsio_calibration_config {
  uint32_t struct_size;
  int32_t values_are;
  uint32_t calibrated_unix_s;
  double ambient_k;
  double calibrated_rate_hz;
  double sigma_knob_inertia_kg_m2;
  double sigma_knob_coulomb_nm;
  double sigma_knob_viscous_nm_s_per_rad;
  double sigma_spring_stiffness_nm_per_rad;
  double sigma_knee_1_rad;
  double sigma_knee_1_nm_per_rad;
  double sigma_brake_drag_nm;
  double sigma_brake_time_constant_s;
  double sigma_brake_release_time_constant_s;
  double sigma_brake_inertia_kg_m2;
  double sigma_brake_hysteresis_nm;
  int32_t sigma_motor_resistance_permille;
  int32_t sigma_motor_inductance_permille;
  int32_t sigma_motor_torque_constant_permille;
} torsio_calibration_config;
TORSIO_API torsio_result torsio_calibration_config_init(torsio_calibration_config* structure);
typedef struct torsio_torque_hand {
  uint32_t struct_size;
  const torsio_knot* torque_nm;
  size_t torque_nm_count;
} torsio_torque_hand;
TORSIO_API torsio_result torsio_torque_hand_init(torsio_torque_hand* structure);
typedef struct torsio_impedance_hand {
  uint32_t struct_size;
  double inertia_kg_m2;
  double stiffness_nm_per_rad;
  double damping_nm_s_per_rad;
  const torsio_knot* intended_angle_rad;
  size_t intended_angle_rad_count;
} torsio_impedance_hand;
TORSIO_API torsio_result torsio_impedance_hand_init(torsio_impedance_hand* structure);
typedef struct torsio_prescribed_motion {
  uint32_t struct_size;
  const torsio_knot* angle_rad;
  size_t angle_rad_count;
} torsio_prescribed_motion;
TORSIO_API torsio_result torsio_prescribed_motion_init(torsio_prescribed_motion* structure);
typedef struct torsio_shaft_hardening {
  uint32_t struct_size;
  double knee_rad;
  double stiffness_factor;
} torsio_shaft_hardening;
TORSIO_API torsio_result torsio_shaft_hardening_init(torsio_shaft_hardening* structure);
typedef struct torsio_brake_hysteresis {
  uint32_t struct_size;
  double half_width_nm;
} torsio_brake_hysteresis;
TORSIO_API torsio_result torsio_brake_hysteresis_init(torsio_brake_hysteresis* structure);
typedef struct torsio_belt {
  uint32_t struct_size;
  double stiffness_nm_per_rad;
  double damping_nm_s_per_rad;
  double pulley_inertia_kg_m2;
} torsio_belt;
TORSIO_API torsio_result torsio_belt_init(torsio_belt* structure);
typedef struct torsio_cogging {
  uint32_t struct_size;
  int32_t periods_per_rev;
  const double* torque_nm;
  size_t torque_nm_count;
} torsio_cogging;
TORSIO_API torsio_result torsio_cogging_init(torsio_cogging* structure);
typedef struct torsio_electrics {
  uint32_t struct_size;
  double winding_resistance_ohm;
  double winding_inductance_h;
  double torque_constant_nm_per_a;
  bool motor_reversed;
  double coil_resistance_ohm;
  double coil_inductance_h;
  double coil_torque_constant_nm_per_a;
  double supply_v;
  double supply_resistance_ohm;
  double supply_capacitance_f;
  double supply_divider_ratio;
  double ambient_c;
  double winding_heat_j_per_k;
  double winding_to_rotor_k_per_w;
  double rotor_heat_j_per_k;
  double rotor_to_air_k_per_w;
  double coil_heat_j_per_k;
  double coil_to_air_k_per_w;
  int32_t pwm_steps;
  double current_period_s;
  double output_delay_s;
  bool predictive;
  double sample_offset_s;
  double sensor_v_per_a;
  double sensor_zero_v;
  double sensor_noise_v;
  double sensor_range_v;
  int32_t sensor_bits;
  int32_t sensor_state;
} torsio_electrics;
TORSIO_API torsio_result torsio_electrics_init(torsio_electrics* structure);
typedef struct torsio_plant_params {
  uint32_t struct_size;
  double knob_inertia_kg_m2;
  double knob_viscous_nm_s_per_rad;
  double knob_coulomb_nm;
  double brake_inertia_kg_m2;
  double brake_viscous_nm_s_per_rad;
  double brake_drag_nm;
  double shaft_stiffness_nm_per_rad;
  double shaft_damping_nm_s_per_rad;
  double brake_time_constant_s;
  double motor_time_constant_s;
  double motor_limit_nm;
  double brake_limit_nm;
  uint32_t counts_per_rev;
  int32_t encoder_rounding;
  double encoder_phase_counts;
  double encoder_noise_counts;
  bool spring_and_brake;
  const torsio_shaft_hardening* shaft_hardening;
  const torsio_brake_hysteresis* brake_hysteresis;
  const torsio_belt* belt;
  const torsio_cogging* cogging;
  const torsio_electrics* electrics;
} torsio_plant_params;
TORSIO_API torsio_result torsio_plant_params_init(torsio_plant_params* structure);
typedef struct torsio_link_faults {
  uint32_t struct_size;
  double drop_output;
  double corrupt_output;
  double drop_input;
  double corrupt_input;
} torsio_link_faults;
TORSIO_API torsio_result torsio_link_faults_init(torsio_link_faults* structure);
typedef struct torsio_emulator_options {
  uint32_t struct_size;
  uint64_t seed;
  double control_rate_hz;
  const torsio_plant_params* plant;
  const char* serial;
  const torsio_actuator_config* actuator;
  const torsio_control_config* control;
  const torsio_board_config* board;
  const torsio_game_config* game;
  const torsio_shaft_config* shaft;
  bool paced;
  bool log_truth;
} torsio_emulator_options;
TORSIO_API torsio_result torsio_emulator_options_init(torsio_emulator_options* structure);
typedef struct torsio_listed_device {
  char path[TORSIO_TEXT_BYTES];
  char serial[TORSIO_TEXT_BYTES];
  char product[TORSIO_TEXT_BYTES];
  char board[TORSIO_TEXT_BYTES];
  char transport[TORSIO_TEXT_BYTES];
  char problem[TORSIO_TEXT_BYTES];
} torsio_listed_device;
typedef struct torsio_device_info {
  uint32_t struct_size;
  char path[TORSIO_TEXT_BYTES];
  char serial[TORSIO_TEXT_BYTES];
  char product[TORSIO_TEXT_BYTES];
  char board[TORSIO_TEXT_BYTES];
  char firmware_version[TORSIO_TEXT_BYTES];
  char transport[TORSIO_TEXT_BYTES];
  uint16_t protocol_version;
  uint32_t fingerprint;
  int32_t axes;
  int32_t effects;
  int32_t curve_points;
  double control_rate_hz;
  uint32_t counts_per_rev;
  double torque_step_nm;
  double speed_step_rad_s;
} torsio_device_info;
TORSIO_API torsio_result torsio_device_info_init(torsio_device_info* structure);
typedef struct torsio_clock {
  uint32_t struct_size;
  uint64_t tick;
  double time_s;
  int64_t position_counts;
  double angle_rad;
} torsio_clock;
TORSIO_API torsio_result torsio_clock_init(torsio_clock* structure);
typedef struct torsio_health {
  uint32_t struct_size;
  int32_t state;
  uint32_t faults;
  uint32_t reports_accepted;
  uint32_t reports_refused;
  uint32_t samples_dropped;
  uint32_t tick_overruns;
  double tick_time_s;
  double tick_time_max_s;
  uint32_t saves;
  int32_t owner;
  int32_t reset_cause;
} torsio_health;
TORSIO_API torsio_result torsio_health_init(torsio_health* structure);
typedef struct torsio_energies {
  uint32_t struct_size;
  uint64_t tick;
  double time_s;
  bool kept;
  double motor_j;
  double felt_j;
  double stored_j;
  double brake_j;
  double bound_nm_per_rad;
} torsio_energies;
TORSIO_API torsio_result torsio_energies_init(torsio_energies* structure);
typedef struct torsio_motor_current {
  uint32_t struct_size;
  bool measured;
  double time_s;
  double angle_rad;
  double period_s;
  double delay_s;
  uint64_t periods;
  double current_a;
  double zero_a;
  double step_a;
  double current_sum_a;
  double share;
  double share_before;
  double share_sum;
  double torque_constant_nm_per_a;
} torsio_motor_current;
TORSIO_API torsio_result torsio_motor_current_init(torsio_motor_current* structure);
typedef struct torsio_limits {
  uint32_t struct_size;
  double motor_torque_max_nm;
  double motor_torque_continuous_max_nm;
  double brake_torque_max_nm;
  double speed_limit_rad_s;
  bool held_low;
} torsio_limits;
TORSIO_API torsio_result torsio_limits_init(torsio_limits* structure);
typedef struct torsio_stable_stiffness {
  uint32_t struct_size;
  double stiffness_nm_per_rad;
  char limited_by[TORSIO_TEXT_BYTES];
} torsio_stable_stiffness;
TORSIO_API torsio_result torsio_stable_stiffness_init(torsio_stable_stiffness* structure);
typedef struct torsio_game_status {
  uint32_t struct_size;
  double time_s;
  int32_t owner;
  bool paused;
  bool enabled;
  double gain;
  double torque_nm;
  uint32_t updates;
  int32_t effects;
} torsio_game_status;
TORSIO_API torsio_result torsio_game_status_init(torsio_game_status* structure);
typedef struct torsio_game_effect {
  int32_t block;
  int32_t kind;
  int32_t state;
  double torque_nm;
  uint32_t updates;
  double silent_s;
} torsio_game_effect;
typedef struct torsio_link_statistics {
  uint32_t struct_size;
  uint64_t reports_sent;
  uint64_t reports_received;
  uint64_t reports_undecodable;
  uint64_t samples_received;
  uint64_t samples_lost;
  uint64_t events_lost;
  uint64_t local_models_refused;
  char last_refusal[TORSIO_TEXT_BYTES];
} torsio_link_statistics;
TORSIO_API torsio_result torsio_link_statistics_init(torsio_link_statistics* structure);
typedef struct torsio_event {
  uint32_t struct_size;
  char kind[TORSIO_TEXT_BYTES];
  int32_t state;
  int32_t owner;
  uint32_t faults;
  uint64_t tick;
  double time_s;
} torsio_event;
TORSIO_API torsio_result torsio_event_init(torsio_event* structure);
typedef struct torsio_disarm {
  uint32_t struct_size;
  int32_t reason;
  uint32_t faults;
  uint64_t tick;
  double time_s;
} torsio_disarm;
TORSIO_API torsio_result torsio_disarm_init(torsio_disarm* structure);
typedef struct torsio_electrics_state {
  uint32_t struct_size;
  double motor_current_a;
  double coil_current_a;
  double supply_v;
  double winding_c;
  double rotor_c;
  double coil_c;
} torsio_electrics_state;
TORSIO_API torsio_result torsio_electrics_state_init(torsio_electrics_state* structure);
typedef struct torsio_telemetry_sample {
  uint64_t tick;
  double time_s;
  int64_t position_counts;
  double angle_rad;
  float speed_rad_s;
  float desired_torque_nm;
  float motor_command_nm;
  float brake_capacity_nm;
  float spring_torque_nm;
  uint8_t flags;
} torsio_telemetry_sample;
typedef struct torsio_truth_sample {
  double time_s;
  double angle_rad;
  double brake_angle_rad;
  double speed_rad_s;
  double spring_torque_nm;
  double brake_torque_nm;
  double brake_capacity_nm;
  double motor_torque_nm;
  double hand_torque_nm;
} torsio_truth_sample;
TORSIO_API torsio_result torsio_scene_add_wall(torsio_scene* scene, const torsio_wall* effect);
TORSIO_API torsio_result torsio_scene_add_spring(torsio_scene* scene, const torsio_spring* effect);
TORSIO_API torsio_result torsio_scene_add_damper(torsio_scene* scene, const torsio_damper* effect);
TORSIO_API torsio_result torsio_scene_add_friction(torsio_scene* scene,
                                                   const torsio_friction* effect);
TORSIO_API torsio_result torsio_scene_add_inertia(torsio_scene* scene,
                                                  const torsio_inertia* effect);
TORSIO_API torsio_result torsio_scene_add_constant(torsio_scene* scene,
                                                   const torsio_constant* effect);
TORSIO_API torsio_result torsio_scene_add_ramp(torsio_scene* scene, const torsio_ramp* effect);
TORSIO_API torsio_result torsio_scene_add_periodic(torsio_scene* scene,
                                                   const torsio_periodic* effect);
TORSIO_API torsio_result torsio_scene_add_detents(torsio_scene* scene,
                                                  const torsio_detents* effect);
TORSIO_API torsio_result torsio_scene_add_end_stops(torsio_scene* scene,
                                                    const torsio_end_stops* effect);
TORSIO_API torsio_result torsio_scene_add_texture(torsio_scene* scene,
                                                  const torsio_texture* effect);
TORSIO_API torsio_result torsio_scene_add_curve(torsio_scene* scene, const torsio_curve* effect);
TORSIO_API torsio_result torsio_scene_add_impact(torsio_scene* scene, const torsio_impact* effect);
TORSIO_API torsio_result torsio_knob_actuator_config(torsio_knob* knob,
                                                     torsio_actuator_config* config);
TORSIO_API torsio_result torsio_knob_set_actuator_config(torsio_knob* knob,
                                                         const torsio_actuator_config* config);
TORSIO_API torsio_result torsio_knob_control_config(torsio_knob* knob,
                                                    torsio_control_config* config);
TORSIO_API torsio_result torsio_knob_set_control_config(torsio_knob* knob,
                                                        const torsio_control_config* config);
TORSIO_API torsio_result torsio_knob_board_config(torsio_knob* knob, torsio_board_config* config);
TORSIO_API torsio_result torsio_knob_set_board_config(torsio_knob* knob,
                                                      const torsio_board_config* config);
TORSIO_API torsio_result torsio_knob_game_config(torsio_knob* knob, torsio_game_config* config);
TORSIO_API torsio_result torsio_knob_set_game_config(torsio_knob* knob,
                                                     const torsio_game_config* config);
TORSIO_API torsio_result torsio_knob_shaft_config(torsio_knob* knob, torsio_shaft_config* config);
TORSIO_API torsio_result torsio_knob_set_shaft_config(torsio_knob* knob,
                                                      const torsio_shaft_config* config);
TORSIO_API torsio_result torsio_knob_calibration_config(torsio_knob* knob,
                                                        torsio_calibration_config* config);
TORSIO_API torsio_result
torsio_knob_set_calibration_config(torsio_knob* knob, const torsio_calibration_config* config);
#ifdef __cplusplus
}
#endif
#endif
#ifndef TORSIO_H
#define TORSIO_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif
TORSIO_API const char* torsio_last_error(void);
TORSIO_API const char* torsio_last_warning(void);
typedef struct torsio_refusal {
  uint32_t struct_size;
  char status[TORSIO_TEXT_BYTES];
  char report[TORSIO_TEXT_BYTES];
  char field[TORSIO_TEXT_BYTES];
  char reason[TORSIO_TEXT_BYTES];
} torsio_refusal;
TORSIO_API torsio_result torsio_refusal_init(torsio_refusal* structure);
TORSIO_API torsio_result torsio_last_refusal(torsio_refusal* refusal);
TORSIO_API const char* torsio_result_name(int32_t result);
TORSIO_API const char* torsio_version(void);
typedef struct torsio_open_options {
  uint32_t struct_size;
  double command_timeout_s;
  uint64_t ring_samples;
  const torsio_emulator_options* emulator;
} torsio_open_options;
TORSIO_API torsio_result torsio_open_options_init(torsio_open_options* structure);
TORSIO_API torsio_result torsio_list_devices(torsio_listed_device* devices, size_t capacity,
                                             size_t item_size, size_t* count);
TORSIO_API torsio_result torsio_knob_open(const char* selector, const torsio_open_options* options,
                                          torsio_knob** knob);
TORSIO_API torsio_result torsio_start_bootloader(const char* selector);
TORSIO_API void torsio_knob_close(torsio_knob* knob);
TORSIO_API void torsio_knob_free(torsio_knob* knob);
TORSIO_API bool torsio_knob_is_open(const torsio_knob* knob);
TORSIO_API bool torsio_knob_is_emulated(const torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_info(torsio_knob* knob, torsio_device_info* info);
TORSIO_API torsio_result torsio_knob_state(torsio_knob* knob, int32_t* state);
TORSIO_API torsio_result torsio_knob_last_disarm(torsio_knob* knob, torsio_disarm* disarm);
TORSIO_API torsio_result torsio_knob_faults(torsio_knob* knob, uint32_t* faults);
TORSIO_API torsio_result torsio_knob_health(torsio_knob* knob, torsio_health* health);
TORSIO_API torsio_result torsio_knob_energies(torsio_knob* knob, torsio_energies* energies);
TORSIO_API torsio_result torsio_knob_motor_current(torsio_knob* knob,
                                                   torsio_motor_current* motor_current);
TORSIO_API torsio_result torsio_knob_limits(torsio_knob* knob, torsio_limits* limits);
TORSIO_API torsio_result torsio_knob_clock(torsio_knob* knob, torsio_clock* clock);
TORSIO_API torsio_result torsio_knob_position_rad(torsio_knob* knob, double* position_rad);
TORSIO_API torsio_result torsio_knob_statistics(torsio_knob* knob,
                                                torsio_link_statistics* statistics);
TORSIO_API torsio_result torsio_knob_stable_stiffness(torsio_knob* knob,
                                                      torsio_stable_stiffness* stiffness);
TORSIO_API torsio_result torsio_knob_game_status(torsio_knob* knob, torsio_game_status* status);
TORSIO_API torsio_result torsio_knob_game_effects(torsio_knob* knob, torsio_game_effect* effects,
                                                  size_t capacity, size_t item_size, size_t* count);
TORSIO_API torsio_result torsio_knob_arm(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_disarm(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_stop(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_zero(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_relax(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_clear_fault(torsio_knob* knob);
TORSIO_API torsio_result torsio_scene_new(torsio_scene** scene);
TORSIO_API torsio_result torsio_scene_clear(torsio_scene* scene);
TORSIO_API size_t torsio_scene_count(const torsio_scene* scene);
TORSIO_API void torsio_scene_free(torsio_scene* scene);
TORSIO_API torsio_result torsio_knob_play(torsio_knob* knob, const torsio_scene* scene);
TORSIO_API torsio_result torsio_knob_stream_local_model(torsio_knob* knob,
                                                        const torsio_local_model* model);
TORSIO_API torsio_result torsio_knob_excite(torsio_knob* knob, const torsio_excitation* excitation);
TORSIO_API torsio_result torsio_knob_next_event(torsio_knob* knob, double timeout_s,
                                                torsio_event* event);
TORSIO_API torsio_result torsio_knob_save(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_load_defaults(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_start_telemetry(torsio_knob* knob, double rate_hz, bool prompt,
                                                     double* true_rate_hz);
TORSIO_API torsio_result torsio_knob_stop_telemetry(torsio_knob* knob);
TORSIO_API torsio_result torsio_knob_latest(torsio_knob* knob, torsio_telemetry_sample* sample,
                                            size_t item_size);
TORSIO_API torsio_result torsio_knob_read(torsio_knob* knob, torsio_telemetry_sample* samples,
                                          size_t capacity, size_t item_size, double timeout_s,
                                          size_t* count);
TORSIO_API torsio_result torsio_knob_record(torsio_knob* knob, double duration_s, double rate_hz,
                                            bool must_stay_armed, torsio_recording** recording);
TORSIO_API const torsio_telemetry_sample* torsio_recording_samples(
    const torsio_recording* recording);
TORSIO_API size_t torsio_recording_count(const torsio_recording* recording);
TORSIO_API bool torsio_recording_was_disarmed(const torsio_recording* recording,
                                              torsio_disarm* disarm);
TORSIO_API void torsio_recording_free(torsio_recording* recording);
TORSIO_API torsio_result torsio_knob_sleep(torsio_knob* knob, double duration_s);
TORSIO_API torsio_result torsio_knob_wait_for(torsio_knob* knob, int32_t state, double timeout_s);
TORSIO_API torsio_result torsio_knob_every(torsio_knob* knob, double period_s,
                                           torsio_steps** steps);
TORSIO_API torsio_result torsio_steps_wait(torsio_steps* steps, double* time_s,
                                           uint64_t* late_steps);
TORSIO_API void torsio_steps_free(torsio_steps* steps);
TORSIO_API torsio_result torsio_emulator_release_knob(torsio_knob* knob);
TORSIO_API torsio_result torsio_emulator_set_torque_hand(torsio_knob* knob,
                                                         const torsio_torque_hand* hand);
TORSIO_API torsio_result torsio_emulator_set_impedance_hand(torsio_knob* knob,
                                                            const torsio_impedance_hand* hand);
TORSIO_API torsio_result
torsio_emulator_set_prescribed_motion(torsio_knob* knob, const torsio_prescribed_motion* hand);
TORSIO_API torsio_result torsio_emulator_time_s(torsio_knob* knob, double* time_s);
TORSIO_API torsio_result torsio_emulator_advance(torsio_knob* knob, double duration_s);
TORSIO_API torsio_result torsio_emulator_truth(torsio_knob* knob, torsio_truth_sample* samples,
                                               size_t capacity, size_t item_size, size_t* count);
TORSIO_API torsio_result torsio_emulator_electrics(torsio_knob* knob,
                                                   torsio_electrics_state* state);
TORSIO_API torsio_result torsio_emulator_unplug(torsio_knob* knob);
TORSIO_API torsio_result torsio_emulator_set_emergency_stop(torsio_knob* knob, bool pressed);
TORSIO_API torsio_result torsio_emulator_set_actuator_fault(torsio_knob* knob, bool present);
TORSIO_API torsio_result torsio_emulator_set_current_sensor(torsio_knob* knob, int32_t state);
TORSIO_API torsio_result torsio_emulator_set_supply(torsio_knob* knob, double supply_v);
TORSIO_API torsio_result torsio_emulator_freeze_encoder(torsio_knob* knob, bool frozen);
TORSIO_API torsio_result torsio_emulator_jump_encoder(torsio_knob* knob, int32_t counts);
TORSIO_API torsio_result torsio_emulator_skip_ticks(torsio_knob* knob, uint32_t count);
TORSIO_API torsio_result torsio_emulator_set_link_faults(torsio_knob* knob,
                                                         const torsio_link_faults* faults);
TORSIO_API torsio_result torsio_emulator_cut_power_in_next_save(torsio_knob* knob,
                                                                uint32_t after_bytes);
TORSIO_API torsio_result torsio_watch_new(bool include_present, torsio_watch** watch);
TORSIO_API torsio_result torsio_watch_next(torsio_watch* watch, double timeout_s, bool* arrived,
                                           torsio_listed_device* device, size_t item_size);
TORSIO_API void torsio_watch_free(torsio_watch* watch);
#ifdef __cplusplus
}
#endif
#endif
