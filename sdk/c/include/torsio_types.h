/// @file
/// The enumerations and structures of torsio.h, which includes this. Quantities are in SI units,
/// torques are torques on the knob, positive along positive angle. `torsio_..._init` fills in a
/// structure's size and defaults; a structure whose size is wrong is refused. `torsio_..._name`
/// gives the name of an enumeration's value as messages have it, NULL if there is none.
///
/// Printed from the field lists in firmware/protocol/definition/ and emulator/definition/ by `./dev
/// generate`; change those instead.
#ifndef TORSIO_TYPES_H
#define TORSIO_TYPES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "torsio_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// On which side of its surface a wall is solid.
typedef enum torsio_side {
  TORSIO_SIDE_ABOVE = 0,
  TORSIO_SIDE_BELOW = 1,
} torsio_side;
TORSIO_API const char* torsio_side_name(int32_t value);

/// Shape of a periodic torque.
typedef enum torsio_waveform {
  TORSIO_WAVEFORM_SINE = 0,
  TORSIO_WAVEFORM_SQUARE = 1,
  TORSIO_WAVEFORM_TRIANGLE = 2,
  TORSIO_WAVEFORM_SAWTOOTH_UP = 3,
  TORSIO_WAVEFORM_SAWTOOTH_DOWN = 4,
} torsio_waveform;
TORSIO_API const char* torsio_waveform_name(int32_t value);

/// Torque from one notch to the next: -T sin(2 pi u) at u pitches from a notch; -2 T u within half
/// a pitch; or linear within the width, beyond it T toward the notch.
typedef enum torsio_detent_profile {
  TORSIO_DETENT_PROFILE_SINE = 0,
  TORSIO_DETENT_PROFILE_LINEAR = 1,
  TORSIO_DETENT_PROFILE_CLICK = 2,
} torsio_detent_profile;
TORSIO_API const char* torsio_detent_profile_name(int32_t value);

/// Shape of a texture's grains; noise draws a value for each and joins them smoothly.
typedef enum torsio_grain {
  TORSIO_GRAIN_SINE = 0,
  TORSIO_GRAIN_SQUARE = 1,
  TORSIO_GRAIN_TRIANGLE = 2,
  TORSIO_GRAIN_NOISE = 3,
} torsio_grain;
TORSIO_API const char* torsio_grain_name(int32_t value);

/// A curve's torque outside its span.
typedef enum torsio_ends {
  TORSIO_ENDS_HOLD = 0,
  TORSIO_ENDS_REPEAT = 1,
} torsio_ends;
TORSIO_API const char* torsio_ends_name(int32_t value);

/// How the desired torque is shared between motor and brake; docs/explanation/theory.md.
typedef enum torsio_law {
  TORSIO_LAW_PAPER = 0,  ///< the printed law, as it must be read
  TORSIO_LAW_COMPENSATED =
      1,  ///< the motor fills in what the brake does not hold, with its drag counted
  TORSIO_LAW_PARALLEL =
      2,  ///< fixed shares without the sensor: it sticks, and is here to show that
  TORSIO_LAW_MOTOR_ONLY = 3,  ///< no brake
  TORSIO_LAW_CALIBRATED = 4,  ///< as compensated, with a stiffness that is bounded by the parts
} torsio_law;
TORSIO_API const char* torsio_law_name(int32_t value);

/// On what the values of actuator and shaft are based.
typedef enum torsio_basis {
  TORSIO_BASIS_ASSUMED = 0,   ///< on data sheets, or a value was changed since
  TORSIO_BASIS_STATED = 1,    ///< on the word of a user who answers for them
  TORSIO_BASIS_MEASURED = 2,  ///< on a calibration
} torsio_basis;
TORSIO_API const char* torsio_basis_name(int32_t value);

/// The second interface, as the computer sees it.
typedef enum torsio_personality {
  TORSIO_PERSONALITY_GAME_CONTROLLER = 0,  ///< a joystick's axis with force feedback
  TORSIO_PERSONALITY_DIAL = 1,             ///< a wheel of the desktop, with detents
} torsio_personality;
TORSIO_API const char* torsio_personality_name(int32_t value);

/// Effect of a dial: clockwise, to larger angles, is down, right or louder.
typedef enum torsio_dial_use {
  TORSIO_DIAL_USE_WHEEL = 0,   ///< scrolls, in 120 steps a detent where the system can
  TORSIO_DIAL_USE_PAN = 1,     ///< scrolls sideways, as finely
  TORSIO_DIAL_USE_VOLUME = 2,  ///< a key press for each detent
  TORSIO_DIAL_USE_RADIAL =
      3,  ///< turns Windows' radial controller; the first button is the controller's
  TORSIO_DIAL_USE_WHEEL_OR_PAN = 4,  ///< scrolls; sideways while the first button is pressed
  TORSIO_DIAL_USE_WHEEL_OR_VOLUME =
      5,  ///< scrolls; presses the keys while the first button is pressed
  TORSIO_DIAL_USE_VOLUME_OR_WHEEL =
      6,  ///< presses the keys; scrolls while the first button is pressed
} torsio_dial_use;
TORSIO_API const char* torsio_dial_use_name(int32_t value);

/// Whether the device makes torque.
typedef enum torsio_state {
  TORSIO_STATE_DISARMED = 0,      ///< no torque
  TORSIO_STATE_ARMED = 1,         ///< the scene acts
  TORSIO_STATE_FAULT = 2,         ///< no torque until the fault is cleared
  TORSIO_STATE_DISCONNECTED = 3,  ///< the device is unplugged, or does not answer any more
} torsio_state;
TORSIO_API const char* torsio_state_name(int32_t value);

/// Owner of the actuator: none unless it is armed.
typedef enum torsio_owner {
  TORSIO_OWNER_NONE = 0,
  TORSIO_OWNER_SDK = 1,
  TORSIO_OWNER_GAME = 2,
  TORSIO_OWNER_DIAL = 3,
} torsio_owner;
TORSIO_API const char* torsio_owner_name(int32_t value);

/// Kind of a game's effect.
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

/// Whether a game's effect plays.
typedef enum torsio_game_effect_state {
  TORSIO_GAME_EFFECT_STATE_STOPPED = 0,  ///< never started, stopped by the game, or at its end
  TORSIO_GAME_EFFECT_STATE_PLAYING = 1,  ///< it plays, or waits for its delay
  TORSIO_GAME_EFFECT_STATE_SET_ASIDE =
      2,  ///< ended by the device: the game's next update brings it back
} torsio_game_effect_state;
TORSIO_API const char* torsio_game_effect_state_name(int32_t value);

/// Why the device started.
typedef enum torsio_reset_cause {
  TORSIO_RESET_CAUSE_UNKNOWN = 0,     ///< the board cannot tell
  TORSIO_RESET_CAUSE_POWER = 1,       ///< it was switched on
  TORSIO_RESET_CAUSE_BROWN_OUT = 2,   ///< its supply was too low for a moment
  TORSIO_RESET_CAUSE_RESET_PIN = 3,   ///< somebody pressed reset
  TORSIO_RESET_CAUSE_WATCHDOG = 4,    ///< the main loop or the control interrupt hung
  TORSIO_RESET_CAUSE_HARD_FAULT = 5,  ///< the program did what the processor refuses
  TORSIO_RESET_CAUSE_STACK = 6,       ///< the program needed more stack than there is
} torsio_reset_cause;
TORSIO_API const char* torsio_reset_cause_name(int32_t value);

/// Where angle 0 comes from.
typedef enum torsio_centre {
  TORSIO_CENTRE_POWER_UP =
      0,  ///< the knob's place at power-up, or at the last zero; there is no index
  TORSIO_CENTRE_AWAITS_INDEX = 1,  ///< the same, until a slow turn has passed the index twice
  TORSIO_CENTRE_INDEX = 2,         ///< the encoder's index: a save keeps angle 0 over power cycles
} torsio_centre;
TORSIO_API const char* torsio_centre_name(int32_t value);

/// Why the torque went.
typedef enum torsio_disarm_reason {
  TORSIO_DISARM_REASON_ORDER = 0,     ///< a program called disarm() or stop()
  TORSIO_DISARM_REASON_WATCHDOG = 1,  ///< the host was silent for too long, or the bus was lost
  TORSIO_DISARM_REASON_DEADLINE_MISSED = 2,  ///< a streamed local model outlived its deadline
  TORSIO_DISARM_REASON_FAULT = 3,            ///< a fault was latched
  TORSIO_DISARM_REASON_GAME_IDLE = 4,     ///< a game had the actuator and has nothing more to play
  TORSIO_DISARM_REASON_DISCONNECTED = 5,  ///< the device was unplugged or lost its power
  TORSIO_DISARM_REASON_UNKNOWN = 6,       ///< the device's message was lost on the way
  TORSIO_DISARM_REASON_EXCITATION_OVER =
      7,  ///< the time of an excitation was over and no next one had come
  TORSIO_DISARM_REASON_EXCITATION_STOPPED =
      8,                               ///< an excitation left its bounds of travel or speed
  TORSIO_DISARM_REASON_DIAL_IDLE = 9,  ///< the dial had the actuator and nobody turns it
} torsio_disarm_reason;
TORSIO_API const char* torsio_disarm_reason_name(int32_t value);

/// The count of an angle between two counts.
typedef enum torsio_encoder_rounding {
  TORSIO_ENCODER_ROUNDING_FLOOR = 0,
  TORSIO_ENCODER_ROUNDING_NEAREST = 1,
} torsio_encoder_rounding;
TORSIO_API const char* torsio_encoder_rounding_name(int32_t value);

/// State of a current sensor.
typedef enum torsio_current_sensor_state {
  TORSIO_CURRENT_SENSOR_STATE_WORKS = 0,
  TORSIO_CURRENT_SENSOR_STATE_DEAD = 1,
  TORSIO_CURRENT_SENSOR_STATE_STUCK = 2,
  TORSIO_CURRENT_SENSOR_STATE_SATURATED = 3,
} torsio_current_sensor_state;
TORSIO_API const char* torsio_current_sensor_state_name(int32_t value);

/// Bits of telemetry's `flags`; the two lowest are the state.
enum {
  TORSIO_FLAG_STATE_MASK = 0x3,
  TORSIO_FLAG_MOTOR_SATURATED = 1 << 2,  ///< the motor gives all it can
  TORSIO_FLAG_BRAKE_SATURATED = 1 << 3,  ///< the brake holds all it can
  TORSIO_FLAG_LOCAL_MODEL = 1 << 4,      ///< a streamed local model is in force
  TORSIO_FLAG_PASSIVE = 1 << 5,          ///< fading out after silence or a deadline
  TORSIO_FLAG_GAME = 1 << 6,             ///< a game has the actuator
  TORSIO_FLAG_BOUNDED = 1 << 7,  ///< less than the scene asks, so that the knob does not buzz
};

/// Faults, latched until cleared: bits of every `faults` field.
enum {
  TORSIO_FAULT_EMERGENCY_STOP = 1 << 0,  ///< the input is open or pressed
  TORSIO_FAULT_OVER_SPEED = 1 << 1,      ///< faster than speed_limit_rad_s
  TORSIO_FAULT_ENCODER = 1 << 2,         ///< a jump, a dead channel, or two changes at once
  TORSIO_FAULT_ACTUATOR = 1 << 3,        ///< the power stage reports an error
  TORSIO_FAULT_OVERRUN = 1 << 4,         ///< ticks were missed or took too long
  TORSIO_FAULT_NUMERIC = 1 << 5,         ///< the control law gave no finite torque
  TORSIO_FAULT_CURRENT_SENSOR = 1 << 6,  ///< its zero leaves no room for the trip level
  TORSIO_FAULT_WINDING = 1 << 7,         ///< voltage, current and speed do not fit together
  TORSIO_FAULT_TEMPERATURE =
      1 << 8,  ///< the motor's winding or the brake's coil is too hot, computed from its current
  TORSIO_FAULT_SUPPLY = 1 << 9,  ///< the measured voltage of the supply is not the configured one
};

/// One corner of a piecewise-linear function of time. The first value holds before the first knot,
/// the last one after the last. Two knots at the same time make a jump.
typedef struct torsio_knot {
  double time_s;
  double value;
} torsio_knot;

/// When an effect plays, and how its strength comes and goes.
typedef struct torsio_timing {
  /// silence after the scene begins; 0 to 1e5
  double delay_s;
  /// 0 plays without end; 0 to 1e5
  double duration_s;
  /// share of the strength at the start; 0 to 1; at first 1
  double attack_level;
  /// time to full strength; 0 to 1e5
  double attack_s;
  /// share of the strength at the end; 0 to 1; at first 1
  double fade_level;
  /// fading time before the end; 0 to 1e5
  double fade_s;
} torsio_timing;

/// A virtual wall: inside it, stiffness times depth plus damping times inward speed, never a pull.
typedef struct torsio_wall {
  uint32_t struct_size;  ///< bytes of a torsio_wall
  /// the wall's surface
  double angle_rad;
  /// a torsio_side: on which side of the surface the wall is solid; at first above
  int32_t side;
  /// must be given; torque per depth; 0 to 1e6
  double stiffness_nm_per_rad;
  /// torque per inward speed; 0 to 1000
  double damping_nm_s_per_rad;
} torsio_wall;
TORSIO_API torsio_result torsio_wall_init(torsio_wall* structure);

/// A spring to an angle, with an optional dead band.
typedef struct torsio_spring {
  uint32_t struct_size;  ///< bytes of a torsio_spring
  /// rest angle
  double angle_rad;
  /// must be given; torque per distance from the rest angle; 0 to 1e6
  double stiffness_nm_per_rad;
  /// no torque within this distance of the rest angle; 0 to 1000
  double deadband_rad;
  /// the torque does not grow beyond this; 0 to 100; at first 100
  double torque_limit_nm;
} torsio_spring;
TORSIO_API torsio_result torsio_spring_init(torsio_spring* structure);

/// Torque against the speed.
typedef struct torsio_damper {
  uint32_t struct_size;  ///< bytes of a torsio_damper
  /// must be given; torque per speed; 0 to 1000
  double damping_nm_s_per_rad;
  /// the torque does not grow beyond this; 0 to 100; at first 100
  double torque_limit_nm;
} torsio_damper;
TORSIO_API torsio_result torsio_damper_init(torsio_damper* structure);

/// Dry friction that sticks: a spring to an anchor that is dragged along once the torque is
/// reached.
typedef struct torsio_friction {
  uint32_t struct_size;  ///< bytes of a torsio_friction
  /// must be given; while sliding; 0 to 100
  double torque_nm;
  /// while sticking; 1e-6 to 1e6; at first 1
  double stiffness_nm_per_rad;
} torsio_friction;
TORSIO_API torsio_result torsio_friction_init(torsio_friction* structure);

/// Torque against the acceleration.
typedef struct torsio_inertia {
  uint32_t struct_size;  ///< bytes of a torsio_inertia
  /// must be given; torque per acceleration; 0 to 10
  double inertia_kg_m2;
  /// the torque does not grow beyond this; 0 to 100; at first 100
  double torque_limit_nm;
} torsio_inertia;
TORSIO_API torsio_result torsio_inertia_init(torsio_inertia* structure);

/// A constant torque.
typedef struct torsio_constant {
  uint32_t struct_size;  ///< bytes of a torsio_constant
  /// must be given; at full strength; -100 to 100
  double torque_nm;
  /// when it plays, and its envelope
  torsio_timing timing;
} torsio_constant;
TORSIO_API torsio_result torsio_constant_init(torsio_constant* structure);

/// A torque that goes from start to end over the duration in `timing`, which must not be 0.
typedef struct torsio_ramp {
  uint32_t struct_size;  ///< bytes of a torsio_ramp
  /// must be given; when the duration begins; -100 to 100
  double start_torque_nm;
  /// must be given; when it ends; -100 to 100
  double end_torque_nm;
  /// when it plays, and its envelope
  torsio_timing timing;
} torsio_ramp;
TORSIO_API torsio_result torsio_ramp_init(torsio_ramp* structure);

/// A torque that repeats in time. The envelope acts on the amplitude, not on the offset.
typedef struct torsio_periodic {
  uint32_t struct_size;  ///< bytes of a torsio_periodic
  /// a torsio_waveform: starts at 0 and rises; the square starts high; at first sine
  int32_t waveform;
  /// must be given; of the wave, from its middle; 0 to 100
  double amplitude_nm;
  /// the wave's middle; -100 to 100
  double offset_nm;
  /// must be given; at most half the control rate; 0 to 1e4
  double frequency_hz;
  /// where in the period it starts; 0 to 1
  double phase_turns;
  /// when it plays, and its envelope
  torsio_timing timing;
} torsio_periodic;
TORSIO_API torsio_result torsio_periodic_init(torsio_periodic* structure);

/// Notches at equal distances. Give exactly one of `per_turn` and `pitch_rad`.
typedef struct torsio_detents {
  uint32_t struct_size;  ///< bytes of a torsio_detents
  /// where one of the notches is
  double angle_rad;
  /// notches in a turn, > 0; need not be whole; 0: without
  double per_turn;
  /// distance of two notches, > 0; 0: without
  double pitch_rad;
  /// must be given; largest torque; 0 to 100
  double torque_nm;
  /// a torsio_detent_profile: torque from one notch to the next; at first sine
  int32_t profile;
  /// share of the pitch; click only; 0.01 to 1; at first 0.5
  double width;
} torsio_detents;
TORSIO_API torsio_result torsio_detents_init(torsio_detents* structure);

/// Two walls that bound the range between them.
typedef struct torsio_end_stops {
  uint32_t struct_size;  ///< bytes of a torsio_end_stops
  /// must be given; surface of the lower wall
  double lower_rad;
  /// must be given; surface of the upper one, not below the lower one
  double upper_rad;
  /// must be given; torque per depth, of either wall; 0 to 1e6
  double stiffness_nm_per_rad;
  /// torque per inward speed, of either wall; 0 to 1000
  double damping_nm_s_per_rad;
} torsio_end_stops;
TORSIO_API torsio_result torsio_end_stops_init(torsio_end_stops* structure);

/// A rough surface fixed to the knob, the same in every turn.
typedef struct torsio_texture {
  uint32_t struct_size;  ///< bytes of a torsio_texture
  /// must be given; at most half the encoder's counts; 1 to 65535
  int32_t grains_per_turn;
  /// must be given; of the highest grain; 0 to 100
  double torque_nm;
  /// a torsio_grain: shape of a grain; at first noise
  int32_t grain;
  /// another seed, another surface; noise only
  uint32_t seed;
} torsio_texture;
TORSIO_API torsio_result torsio_texture_init(torsio_texture* structure);

/// A torque over angle, linear between equally spaced points on [angle_rad, angle_rad + span_rad].
typedef struct torsio_curve {
  uint32_t struct_size;  ///< bytes of a torsio_curve
  /// at least 2 points; all curves of a scene share 1024
  const double* torque_nm;
  size_t torque_nm_count;
  /// angle of the first point
  double angle_rad;
  /// from the first point to the last; at least two of the encoder's counts; 0 to 804.247719; at
  /// first 1
  double span_rad;
  /// a torsio_ends: its torque outside the span; at first hold
  int32_t ends;
} torsio_curve;
TORSIO_API torsio_result torsio_curve_init(torsio_curve* structure);

/// The knock of something hard, in proportion to the knob's speed into the surface: a decaying
/// sine, and a pulse that brakes. It acts inside only. At control rates from 4 kHz it gives back no
/// more energy than it took, within one count, unless it needs the whole supply or the motor is
/// over 2.5 times as slow as configured.
typedef struct torsio_impact {
  uint32_t struct_size;  ///< bytes of a torsio_impact
  /// the surface, usually a wall's
  double angle_rad;
  /// a torsio_side: on which side of the surface it is solid; at first above
  int32_t side;
  /// the sine's torque at first, per speed of impact; 0 to 1000
  double strength_nm_s_per_rad;
  /// of the sine; at most half the control rate; 1 to 1000; at first 300
  double frequency_hz;
  /// in which the sine falls to 1/e; 1e-4 to 0.1; at first 0.005
  double decay_s;
  /// the pulse's torque, per speed of impact; 0 to 1000
  double pulse_nm_s_per_rad;
  /// how long the pulse lasts; it ends where the knob stops; 0 to 0.1; at first 0.005
  double pulse_s;
  /// the torque does not grow beyond this; 0 to 100; at first 100
  double torque_limit_nm;
} torsio_impact;
TORSIO_API torsio_result torsio_impact_init(torsio_impact* structure);

/// A torque, a spring and a damper that the device renders at its own rate, on top of the scene,
/// until the next one comes: `torque - stiffness (angle - angle_rad) - damping speed`.
typedef struct torsio_local_model {
  uint32_t struct_size;  ///< bytes of a torsio_local_model
  /// at the reference, at rest; -100 to 100
  double torque_nm;
  /// reference position
  double angle_rad;
  /// 0 to 1e6
  double stiffness_nm_per_rad;
  /// 0 to 1000
  double damping_nm_s_per_rad;
  /// how long it holds; 0 ends the stream in good order; 0 to 60; at first 0.02
  double deadline_s;
} torsio_local_model;
TORSIO_API torsio_result torsio_local_model_init(torsio_local_model* structure);

/// A bounded experiment: commands of motor and brake that go past scene and law. Both commands move
/// in a straight line from where the last excitation is now. The motor also gets a sine and the
/// torque of a servo, `servo_stiffness (reference - angle) + servo_damping (reference' - speed)`.
/// The device disarms when a bound is left, or when the time is over and no next one has come. It
/// also disarms when the servo asks for all of the motor for 50 ms and the encoder stands still.
typedef struct torsio_excitation {
  uint32_t struct_size;  ///< bytes of a torsio_excitation
  /// must be given; until it disarms, unless the next one comes first; 0.001 to 60
  double duration_s;
  /// must be given; further from its first angle disarms; 0.001 to 1000
  double travel_rad;
  /// must be given; faster disarms; 0.1 to 1e4
  double speed_limit_rad_s;
  /// must be given; largest torque of the motor; 0 to 100
  double torque_limit_nm;
  /// where the motor goes; -100 to 100
  double motor_command_nm;
  /// where the brake's command goes; 0 to 100
  double brake_command_nm;
  /// time that both take; 0 is a step; 0 to 60
  double ramp_s;
  /// amplitude of the sine on top of `motor_command_nm`; 0 to 100
  double sine_nm;
  /// its frequency at the beginning; 0 to 1000
  double sine_begin_hz;
  /// and after `duration_s`; 0 to 1000
  double sine_end_hz;
  /// of the servo; 0 to 1e6
  double stiffness_nm_per_rad;
  /// of the servo; 0 to 1000
  double damping_nm_s_per_rad;
  /// speed of the servo's reference; -1000 to 1000
  double servo_rad_s;
} torsio_excitation;
TORSIO_API torsio_result torsio_excitation_init(torsio_excitation* structure);

/// The actuator as built. The defaults are the reference actuator. Set only while disarmed; another
/// encoder empties the scene.
typedef struct torsio_actuator_config {
  uint32_t struct_size;  ///< bytes of a torsio_actuator_config
  /// largest torque of the motor; 0 to 100; at first 0.085
  double motor_torque_max_nm;
  /// largest torque of the brake; 0 to 100; at first 0.11
  double brake_torque_max_nm;
  /// least brake torque that the sensor assumes; 0 to 100; at first 0.0033
  double brake_torque_min_nm;
  /// drag of the brake without current; 0 to 100; at first 0.002
  double brake_drag_nm;
  /// the brake's lag from command to torque; 0 to 100; at first 0.06
  double brake_time_constant_s;
  /// stiffness of the shaft between knob and brake; 0 to 1e6; at first 2.873
  double spring_stiffness_nm_per_rad;
  /// the encoder's counts in a turn; 4 to 16777216; at first 8192
  uint32_t counts_per_rev;
  /// width at which the encoder's counter wraps; 8 to 32; at first 32
  int32_t counter_bits;
  /// true: it counts down where the angle grows
  bool encoder_reversed;
  /// inertia of motor and knob; this and the next three bound a game's effects; 1e-9 to 1; at first
  /// 6e-05
  double knob_inertia_kg_m2;
  /// dry friction of motor and knob; 0 to 100; at first 0.006
  double knob_coulomb_nm;
  /// viscous friction of motor and knob; 0 to 1000; at first 2.6e-05
  double knob_viscous_nm_s_per_rad;
  /// the motor's lag from command to torque; 0 to 1; at first 4.4e-05
  double motor_time_constant_s;
  /// inertia of pulleys and brake; 0: not counted. This and the next two are for the law
  /// calibrated; 0 to 1; at first 4e-05
  double brake_inertia_kg_m2;
  /// half the width of the brake's hysteresis loop; 0 to 100
  double brake_hysteresis_nm;
  /// the brake's lag while its torque falls; 0: as `brake_time_constant_s`; 0 to 100
  double brake_release_time_constant_s;
  /// GPIO of the encoder's index, one pulse a turn; 0: none. Save it: it takes effect at the next
  /// start; 0 to 29
  int32_t encoder_index_pin;
} torsio_actuator_config;
TORSIO_API torsio_result torsio_actuator_config_init(torsio_actuator_config* structure);

/// How the device controls, and what it does when the host goes silent. Set only while disarmed.
typedef struct torsio_control_config {
  uint32_t struct_size;  ///< bytes of a torsio_control_config
  /// a torsio_law: how the desired torque is shared between motor and brake; at first paper
  int32_t law;
  /// the brake's share of the desired torque; 0 to 1; at first 0.5
  double beta;
  /// bandwidth of the speed estimate; 1 to 1e4; at first 100
  double speed_bandwidth_hz;
  /// the user's limit, below the actuator's; 0 to 100; at first 100
  double motor_torque_cap_nm;
  /// the user's limit, below the actuator's; 0 to 100; at first 100
  double brake_torque_cap_nm;
  /// largest rate of the motor's torque; 0 is no limit; 0 to 1e6
  double motor_slew_nm_per_s;
  /// a faster knob is a fault; 0: no limit; 0 to 1e4
  double speed_limit_rad_s;
  /// silence of the host after which the knob disarms; 0.01 to 60; at first 0.25
  double watchdog_s;
  /// time of the motor's torque to zero when the host is lost; 0 to 10; at first 0.05
  double passive_ramp_s;
  /// the brake's torque during the ramp; 0 releases it; 0 to 100
  double passive_brake_nm;
  /// true: no watchdog, plays on without a host
  bool autonomous;
  /// friction that the motor cancels where the scene asks for nothing, at most three quarters of
  /// the configured friction, for four turns without a rest at most; law calibrated only; 0 to 100
  double free_assist_nm;
} torsio_control_config;
TORSIO_API torsio_result torsio_control_config_init(torsio_control_config* structure);

/// The board's wiring, and the electrical values of motor and brake; docs/how-to/hardware.md. A pin
/// is the number of its GPIO. Set only while disarmed, then save: it takes effect at the next
/// start. The emulated device uses it where it has Electrics.
typedef struct torsio_board_config {
  uint32_t struct_size;  ///< bytes of a torsio_board_config
  /// voltage of both H-bridges; 3 to 60; at first 12
  double supply_v;
  /// the motor's torque an ampere, at the knob; 1e-4 to 100; at first 0.05
  double motor_torque_constant_nm_per_a;
  /// largest current the firmware asks for; a measured current of 1.5 times as much is a fault; 0
  /// to 100; at first 2
  double motor_current_max_a;
  /// continuous current of the winding in air of 25 degrees; more is given for seconds only; 0 to
  /// 100; at first 1
  double motor_current_continuous_a;
  /// resistance of the winding; 0.001 to 1000; at first 2.5
  double motor_resistance_ohm;
  /// inductance of the winding; 1e-6 to 1; at first 0.0015
  double motor_inductance_h;
  /// of the current loop; on a pico held at a tenth of the control rate; 1 to 65535; at first 10000
  int32_t current_bandwidth_hz;
  /// of the current sensor; its zero is measured while the power is off; 0.001 to 10; at first 0.2
  double current_sense_v_per_a;
  /// the brake's torque an ampere, on its pulley; 1e-4 to 1000; at first 0.44
  double brake_torque_constant_nm_per_a;
  /// largest current of the coil; 0 to 100; at first 0.3
  double brake_current_max_a;
  /// resistance of the coil; 0.001 to 1e4; at first 40
  double brake_resistance_ohm;
  /// inductance of the coil. Above 0 the bridge drives the coil both ways, with the actuator's
  /// brake_time_constant_s. 0: the current follows as the coil lets it; 0 to 1000
  double brake_inductance_h;
  /// true: a current into the first motor pin turns the knob to smaller angles
  bool motor_reversed;
  /// true: somebody has checked the parts. A real board holds torques and speed low until this is
  /// on and `values_are` is not `assumed`. Acts at once
  bool confirmed;
  /// continuous current of the coil in air of 25 degrees, of brake_current_max_a; more is given for
  /// a while only; 0 to 100; at first 100
  int32_t brake_continuous_percent;
  /// highest temperature of the air around motor and brake; 0 to 100; at first 25
  int32_t ambient_c;
  /// of the divider at supply_sense_pin: the supply's voltage over the pin's; 1 to 255; at first 11
  int32_t supply_sense_ratio;
  /// GPIO of A; B is the next one; 0 to 28; at first 2
  int32_t encoder_pin;
  /// GPIO of the first input of the motor's bridge, even; the second is the next one; 0 to 28; at
  /// first 6
  int32_t motor_pin;
  /// GPIO of the first input of the brake's bridge, even; the second is the next one; 0 to 28; at
  /// first 8
  int32_t brake_pin;
  /// GPIO, high while the power stages are on; 0 to 29; at first 10
  int32_t enable_pin;
  /// GPIO, low to run; an open wire stops; 0 to 29; at first 11
  int32_t emergency_stop_pin;
  /// GPIO, low when a bridge reports an error; 0 to 29; at first 12
  int32_t driver_fault_pin;
  /// GPIO of the motor's current sensor; 26 to 28; at first 26
  int32_t current_sense_pin;
  /// GPIO of a divider at the supply, 26 to 28; the supply is then watched. 0: none; 0 to 28
  int32_t supply_sense_pin;
  /// GPIO of the status light; 0 to 29; at first 25
  int32_t light_pin;
} torsio_board_config;
TORSIO_API torsio_result torsio_board_config_init(torsio_board_config* structure);

/// Permissions of games on the game interface, and the scale of their torques;
/// docs/reference/games.md. Set only while disarmed.
typedef struct torsio_game_config {
  uint32_t struct_size;  ///< bytes of a torsio_game_config
  /// false: games see the axis but move nothing; at first true
  bool enabled;
  /// angle from one end of the game's axis to the other, round angle 0; 10 to 36000; at first 900
  double range_deg;
  /// torque at full level, and the limit of all effects together; never more than the motor's; 0 to
  /// 100; at first 100
  double torque_max_nm;
  /// strength of all games' effects, times their own gains; 0 to 1; at first 1
  double gain;
  /// 1: a full spring reaches full torque at the end of the axis; 0 to 1000; at first 20
  double spring_gain;
  /// speed at which a full damper reaches full torque; 0.1 to 1e4; at first 20
  double speed_full_rad_s;
  /// acceleration at which a full inertia reaches full torque; 1 to 1e7; at first 3000
  double acceleration_full_rad_s2;
  /// in which a change of an effect, its beginning or its end takes full effect; 0 to 0.1; at first
  /// 0.002
  double blend_s;
  /// silence of the game after which forces without end stop; 0: never; 0 to 3600; at first 10
  double silence_s;
  /// true: updates of a steady force are joined by lines, half a frame of the game late; hits pass;
  /// at first true
  bool join_updates;
  /// stiffness of walls at both ends of the axis, while a game has the actuator; 0: none; 0 to 1e6
  double end_stiffness_nm_per_rad;
  /// a torsio_personality: the computer's view of the knob; save it: it takes effect at the next
  /// start; at first game_controller
  int32_t personality;
  /// a torsio_dial_use: use of a dial; at first wheel
  int32_t dial_use;
  /// detents of a dial in a turn; 1 to 240; at first 24
  int32_t dial_detents;
  /// torque between two detents of a dial, held down to a stable one; 0: it turns freely; 0 to 100;
  /// at first 0.02
  double dial_torque_nm;
  /// share of a full damper, always felt while somebody turns the knob, with a game and without; 0
  /// to 100
  int32_t own_damper_percent;
  /// share of full torque as friction, always felt, with a game and without; 0 to 100
  int32_t own_friction_percent;
  /// share of a full inertia, always felt, with a game and without; 0 to 100
  int32_t own_inertia_percent;
  /// share of a full spring to the middle, while no game plays; 0 to 100
  int32_t own_spring_percent;
  /// strength of games' constant forces and ramps; 0 to 100; at first 100
  int32_t constants_gain_percent;
  /// strength of games' waves; 0 to 100; at first 100
  int32_t waves_gain_percent;
  /// strength of games' springs; 0 to 100; at first 100
  int32_t springs_gain_percent;
  /// strength of games' dampers; 0 to 100; at first 100
  int32_t dampers_gain_percent;
  /// strength of games' inertias; 0 to 100; at first 100
  int32_t inertias_gain_percent;
  /// strength of games' frictions; 0 to 100; at first 100
  int32_t frictions_gain_percent;
  /// share of the motor's torque that all effects together get at most; the smaller of this and
  /// `torque_max_nm` counts; 1 to 100; at first 100
  int32_t torque_max_percent;
  /// true: axis, games' forces and the dial go the other way
  bool reversed;
  /// true: a dial tells whole detents, although the host asks for fine ones
  bool dial_coarse;
  /// steps of a wheel for a detent that is turned at two turns a second or faster; in proportion
  /// below, down to one; 1 to 20; at first 1
  int32_t dial_fast_steps;
  /// true: turning or pressing wakes a host that sleeps, if it lets; from the next start on
  bool remote_wakeup;
} torsio_game_config;
TORSIO_API torsio_result torsio_game_config_init(torsio_game_config* structure);

/// The curve of the shaft's spring beyond its first straight piece. Up to the first knee the
/// stiffness is the actuator's `spring_stiffness_nm_per_rad`. Both directions are alike. Set only
/// while disarmed.
typedef struct torsio_shaft_config {
  uint32_t struct_size;  ///< bytes of a torsio_shaft_config
  /// twist of the first knee; 0: the spring is one straight line; 0 to 100
  double knee_1_rad;
  /// stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6
  double knee_1_nm_per_rad;
  /// twist of the second knee, beyond the first; 0: none; 0 to 100
  double knee_2_rad;
  /// stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6
  double knee_2_nm_per_rad;
  /// twist of the third knee; 0 to 100
  double knee_3_rad;
  /// stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6
  double knee_3_nm_per_rad;
  /// twist of the fourth knee; 0 to 100
  double knee_4_rad;
  /// stiffness beyond this knee; more than 0, so that the torque always grows; 0 to 1e6
  double knee_4_nm_per_rad;
} torsio_shaft_config;
TORSIO_API torsio_result torsio_shaft_config_init(torsio_shaft_config* structure);

/// How well the values of actuator and shaft are known, and since when. It belongs to the values
/// that the device has when it takes this report. When one of them changes, `values_are` reads
/// `assumed`. A `sigma` is the standard uncertainty of a value; 0: it was not measured. Set only
/// while disarmed.
typedef struct torsio_calibration_config {
  uint32_t struct_size;  ///< bytes of a torsio_calibration_config
  /// a torsio_basis: source of the values of actuator and shaft; at first assumed
  int32_t values_are;
  /// time of the measurement, in seconds since 1970; 0: never; 0 to 4294967300
  uint32_t calibrated_unix_s;
  /// the room's temperature, as the user gave it; 0: not given; 0 to 1000
  double ambient_k;
  /// control rate of the measurement; 0 to 1e6
  double calibrated_rate_hz;
  /// of `knob_inertia_kg_m2`; 0 to 1e6
  double sigma_knob_inertia_kg_m2;
  /// of `knob_coulomb_nm`; 0 to 1e6
  double sigma_knob_coulomb_nm;
  /// of `knob_viscous_nm_s_per_rad`; 0 to 1e6
  double sigma_knob_viscous_nm_s_per_rad;
  /// of `spring_stiffness_nm_per_rad`; 0 to 1e6
  double sigma_spring_stiffness_nm_per_rad;
  /// of `knee_1_rad`; 0 to 1e6
  double sigma_knee_1_rad;
  /// of `knee_1_nm_per_rad`; 0 to 1e6
  double sigma_knee_1_nm_per_rad;
  /// of `brake_drag_nm`; 0 to 1e6
  double sigma_brake_drag_nm;
  /// of `brake_time_constant_s`; 0 to 1e6
  double sigma_brake_time_constant_s;
  /// of `brake_release_time_constant_s`; 0 to 1e6
  double sigma_brake_release_time_constant_s;
  /// of `brake_inertia_kg_m2`; 0 to 1e6
  double sigma_brake_inertia_kg_m2;
  /// of `brake_hysteresis_nm`; 0 to 1e6
  double sigma_brake_hysteresis_nm;
  /// standard uncertainty of the board's `motor_resistance_ohm` in thousandths of it; 0: it was not
  /// measured; 0 to 255
  int32_t sigma_motor_resistance_permille;
  /// standard uncertainty of the board's `motor_inductance_h` in thousandths of it; 0: it was not
  /// measured; 0 to 255
  int32_t sigma_motor_inductance_permille;
  /// standard uncertainty of the board's `motor_torque_constant_nm_per_a` in thousandths of it; 0:
  /// it was not measured; 0 to 255
  int32_t sigma_motor_torque_constant_permille;
} torsio_calibration_config;
TORSIO_API torsio_result torsio_calibration_config_init(torsio_calibration_config* structure);

/// A torque on the knob that does not depend on its motion, such as a weight on a string.
typedef struct torsio_torque_hand {
  uint32_t struct_size;  ///< bytes of a torsio_torque_hand
  /// two knots at the same time make a jump; none: 0 for ever
  const torsio_knot* torque_nm;
  size_t torque_nm_count;
} torsio_torque_hand;
TORSIO_API torsio_result torsio_torque_hand_init(torsio_torque_hand* structure);

/// A hand that holds the knob and means to move it along a path: `torque = stiffness (intended -
/// angle) + damping (intended' - speed)`, with the hand's own inertia fixed to the knob.
typedef struct torsio_impedance_hand {
  uint32_t struct_size;  ///< bytes of a torsio_impedance_hand
  /// of the hand; 0 to 10
  double inertia_kg_m2;
  /// must be given; of the hand; 0 to 1e6
  double stiffness_nm_per_rad;
  /// of the hand; 0 to 1000
  double damping_nm_s_per_rad;
  /// without jumps; none: 0 for ever
  const torsio_knot* intended_angle_rad;
  size_t intended_angle_rad_count;
} torsio_impedance_hand;
TORSIO_API torsio_result torsio_impedance_hand_init(torsio_impedance_hand* structure);

/// The knob follows the path whatever torque that takes.
typedef struct torsio_prescribed_motion {
  uint32_t struct_size;  ///< bytes of a torsio_prescribed_motion
  /// without jumps; none: 0 for ever
  const torsio_knot* angle_rad;
  size_t angle_rad_count;
} torsio_prescribed_motion;
TORSIO_API torsio_result torsio_prescribed_motion_init(torsio_prescribed_motion* structure);

/// Part of a plant: the shaft spring is stiffer, or softer, beyond a knee of twist on both sides.
typedef struct torsio_shaft_hardening {
  uint32_t struct_size;  ///< bytes of a torsio_shaft_hardening
  /// the spring is linear up to here; > 0; at first 0.015
  double knee_rad;
  /// stiffness beyond the knee over stiffness before it; > 0; at first 2
  double stiffness_factor;
} torsio_shaft_hardening;
TORSIO_API torsio_result torsio_shaft_hardening_init(torsio_shaft_hardening* structure);

/// Part of a plant: magnetic hysteresis of the brake, a play between its current, which has the
/// lag, and its torque.
typedef struct torsio_brake_hysteresis {
  uint32_t struct_size;  ///< bytes of a torsio_brake_hysteresis
  /// of the play; the default is 5 % of the brake's limit; >= 0; at first 0.0055
  double half_width_nm;
} torsio_brake_hysteresis;
TORSIO_API torsio_result torsio_brake_hysteresis_init(torsio_brake_hysteresis* structure);

/// Part of a plant: a belt that stretches, between the spring's pulley and the brake.
typedef struct torsio_belt {
  uint32_t struct_size;  ///< bytes of a torsio_belt
  /// of the belt; > 0; at first 60
  double stiffness_nm_per_rad;
  /// of the belt; >= 0; at first 0.001
  double damping_nm_s_per_rad;
  /// the share of brake_inertia_kg_m2 that lies before the belt; > 0; at first 1e-05
  double pulley_inertia_kg_m2;
} torsio_belt;
TORSIO_API torsio_result torsio_belt_init(torsio_belt* structure);

/// Part of a plant: cogging of the motor, a torque on the knob that repeats along the turn.
typedef struct torsio_cogging {
  uint32_t struct_size;  ///< bytes of a torsio_cogging
  /// must be given; of the torque; 1 to 65535
  int32_t periods_per_rev;
  /// 2 to 64 torques at equal distances over one period, from angle 0; straight lines between
  const double* torque_nm;
  size_t torque_nm_count;
} torsio_cogging;
TORSIO_API torsio_result torsio_cogging_init(torsio_cogging* structure);

/// Part of a plant: windings, bridges, supply and current sensor. With it the emulated device runs
/// the board's own power stage; without it motor and brake are the lags that are given.
typedef struct torsio_electrics {
  uint32_t struct_size;  ///< bytes of a torsio_electrics
  /// of the motor, at 25 degrees; > 0; at first 2.5
  double winding_resistance_ohm;
  /// of the motor; > 0; at first 0.0015
  double winding_inductance_h;
  /// of the motor, at the knob; V s/rad of back EMF as well; > 0; at first 0.05
  double torque_constant_nm_per_a;
  /// a current into the first pin turns the knob to smaller angles
  bool motor_reversed;
  /// of the brake; > 0; at first 40
  double coil_resistance_ohm;
  /// of the brake; > 0; at first 2.4
  double coil_inductance_h;
  /// of the brake, on the pulley; > 0; at first 0.44
  double coil_torque_constant_nm_per_a;
  /// without load; > 0; at first 12
  double supply_v;
  /// of the supply; it takes no current back; >= 0; at first 0.1
  double supply_resistance_ohm;
  /// behind that; > 0; at first 0.0022
  double supply_capacitance_f;
  /// the supply's voltage over what a board with supply_sense_pin measures of it; > 0; at first 11
  double supply_divider_ratio;
  /// of the air; everything begins there; -100 to 300; at first 25
  double ambient_c;
  /// heat capacity of the motor's winding; > 0; at first 12
  double winding_heat_j_per_k;
  /// from there to the rotor; > 0; at first 4
  double winding_to_rotor_k_per_w;
  /// heat capacity of the rotor; > 0; at first 60
  double rotor_heat_j_per_k;
  /// from there to the air; > 0; at first 8
  double rotor_to_air_k_per_w;
  /// heat capacity of the brake's coil; > 0; at first 40
  double coil_heat_j_per_k;
  /// from there to the air; > 0; at first 20
  double coil_to_air_k_per_w;
  /// of a bridge's full share; 1 to 65535; at first 1875
  int32_t pwm_steps;
  /// of the current loop, rounded to a whole part of the control period, which 0 is; 0 to 0.001; at
  /// first 2.5e-05
  double current_period_s;
  /// from a measurement to the voltage that answers it; at most a period of the current loop; 1e-6
  /// to 0.001; at first 2.5e-05
  double output_delay_s;
  /// the current loop of the RP2350; false: the one of the RP2040; at first true
  bool predictive;
  /// from the beginning of a measurement until it takes the current; boards begin 1 us before the
  /// middle of the bridge's pulse; 0 to 1e-5; at first 1e-06
  double sample_offset_s;
  /// of the current sensor; > 0; at first 0.2
  double sensor_v_per_a;
  /// its output without current; -10 to 10; at first 1.65
  double sensor_zero_v;
  /// standard deviation; >= 0; at first 0.001
  double sensor_noise_v;
  /// of its converter, from 0; > 0; at first 3.3
  double sensor_range_v;
  /// of its converter; 1 to 24; at first 12
  int32_t sensor_bits;
  /// a torsio_current_sensor_state: dead: 0 V; stuck: at its zero; saturated: at the end of its
  /// range; at first works
  int32_t sensor_state;
} torsio_electrics;
TORSIO_API torsio_result torsio_electrics_init(torsio_electrics* structure);

/// Motor, knob, shaft spring, brake and encoder of an emulated knob. Torques are at the knob. The
/// defaults are the reference actuator; docs/explanation/theory.md has the equations. Parts that
/// are not named cost nothing; the lags of motor and brake are always carried.
typedef struct torsio_plant_params {
  uint32_t struct_size;  ///< bytes of a torsio_plant_params
  /// motor and knob; > 0; at first 6e-05
  double knob_inertia_kg_m2;
  /// viscous friction there; >= 0; at first 2.6e-05
  double knob_viscous_nm_s_per_rad;
  /// dry friction there; >= 0; at first 0.006
  double knob_coulomb_nm;
  /// pulleys and brake; > 0; at first 4e-05
  double brake_inertia_kg_m2;
  /// viscous friction there; >= 0; at first 2e-06
  double brake_viscous_nm_s_per_rad;
  /// drag of the released brake; >= 0; at first 0.002
  double brake_drag_nm;
  /// 0: the shaft is cut; >= 0; at first 2.873
  double shaft_stiffness_nm_per_rad;
  /// of the shaft; >= 0; at first 0.0002
  double shaft_damping_nm_s_per_rad;
  /// from command to torque; 0: no lag; >= 0; at first 0.06
  double brake_time_constant_s;
  /// from command to torque; 0: no lag; >= 0; at first 4.4e-05
  double motor_time_constant_s;
  /// commands are clipped to it, both ways; >= 0; at first 0.085
  double motor_limit_nm;
  /// commands are clipped to it; >= 0; at first 0.11
  double brake_limit_nm;
  /// of the encoder; 1 to 16777216; at first 8192
  uint32_t counts_per_rev;
  /// a torsio_encoder_rounding: how the encoder counts; at first floor
  int32_t encoder_rounding;
  /// a torsio_index_pulse: the pulse at the encoder's count 0, for a device with encoder_index_pin;
  /// at first works
  int32_t encoder_index;
  /// where in a count angle 0 lies
  double encoder_phase_counts;
  /// standard deviation; 0 leaves the noise out; >= 0
  double encoder_noise_counts;
  /// part: spring and brake. Without it knob and brake are one rigid body and the brake never
  /// engages. This suits the law motor_only and saves about a third of the plant's time. All parts
  /// below except cogging need it; at first true
  bool spring_and_brake;
  /// part: the spring has knees; NULL: without
  const torsio_shaft_hardening* shaft_hardening;
  /// part: play in the brake; NULL: without
  const torsio_brake_hysteresis* brake_hysteresis;
  /// part: the belt stretches; NULL: without
  const torsio_belt* belt;
  /// part: the motor cogs; NULL: without
  const torsio_cogging* cogging;
  /// part: windings, bridges, supply, sensor; NULL: without
  const torsio_electrics* electrics;
} torsio_plant_params;
TORSIO_API torsio_result torsio_plant_params_init(torsio_plant_params* structure);

/// Damage to reports on the cable of an emulated knob, as probabilities for each report.
typedef struct torsio_link_faults {
  uint32_t struct_size;  ///< bytes of a torsio_link_faults
  /// host to device; 0 to 1
  double drop_output;
  /// a bit of it is another; 0 to 1
  double corrupt_output;
  /// device to host; 0 to 1
  double drop_input;
  /// a bit of it is another; 0 to 1
  double corrupt_input;
} torsio_link_faults;
TORSIO_API torsio_result torsio_link_faults_init(torsio_link_faults* structure);

/// Options of an emulated knob: parts, hand and records.
typedef struct torsio_emulator_options {
  uint32_t struct_size;  ///< bytes of a torsio_emulator_options
  /// of everything random: encoder noise, damaged reports
  uint64_t seed;
  /// ticks in a second; 1000 to 2e4; at first 1000
  double control_rate_hz;
  /// its parts; NULL: as torsio_plant_params_init() has it
  const torsio_plant_params* plant;
  /// at most 16 ASCII characters; empty: derived from the device's name
  const char* serial;
  /// configuration at power-up; it replaces the stored one and the defaults; NULL: without
  const torsio_actuator_config* actuator;
  /// the same; NULL: without
  const torsio_control_config* control;
  /// the same; a plant with electrics has use for it; NULL: without
  const torsio_board_config* board;
  /// the same; NULL: without
  const torsio_game_config* game;
  /// the same; NULL: without
  const torsio_shaft_config* shaft;
  /// true: real time, as with hardware; false: virtual time, which passes only inside calls that
  /// wait, as fast as the computer can. The same calls with the same seed give the same bytes
  bool paced;
  /// record what no sensor sees, once a tick
  bool log_truth;
} torsio_emulator_options;
TORSIO_API torsio_result torsio_emulator_options_init(torsio_emulator_options* structure);

/// A device that could be opened.
typedef struct torsio_listed_device {
  /// path for open()
  char path[TORSIO_TEXT_BYTES];
  /// serial number
  char serial[TORSIO_TEXT_BYTES];
  /// as its maker calls it
  char product[TORSIO_TEXT_BYTES];
  /// empty if the device could not be asked
  char board[TORSIO_TEXT_BYTES];
  /// "hid" or "emulated"
  char transport[TORSIO_TEXT_BYTES];
  /// why it cannot be opened now; empty if it can
  char problem[TORSIO_TEXT_BYTES];
} torsio_listed_device;

/// Identity and abilities of the device.
typedef struct torsio_device_info {
  uint32_t struct_size;  ///< bytes of a torsio_device_info
  /// path for open()
  char path[TORSIO_TEXT_BYTES];
  /// serial number
  char serial[TORSIO_TEXT_BYTES];
  /// as its maker calls it
  char product[TORSIO_TEXT_BYTES];
  /// "pico2", "emulated", ...
  char board[TORSIO_TEXT_BYTES];
  /// "major.minor.patch"
  char firmware_version[TORSIO_TEXT_BYTES];
  /// "hid", "emulated" or "own", a transport that the program brings
  char transport[TORSIO_TEXT_BYTES];
  /// of the reports
  uint16_t protocol_version;
  /// of the report layouts, the same as the library's
  uint32_t fingerprint;
  /// actuators behind this interface
  int32_t axes;
  /// places in a scene
  int32_t effects;
  /// shared by all curves of a scene
  int32_t curve_points;
  /// ticks in a second
  double control_rate_hz;
  /// of the encoder
  uint32_t counts_per_rev;
  /// resolution of telemetry's torques
  double torque_step_nm;
  /// resolution of telemetry's speed
  double speed_step_rad_s;
} torsio_device_info;
TORSIO_API torsio_result torsio_device_info_init(torsio_device_info* structure);

/// The device's time and position, both exact.
typedef struct torsio_clock {
  uint32_t struct_size;  ///< bytes of a torsio_clock
  /// control periods since power-up
  uint64_t tick;
  /// tick times the control period
  double time_s;
  /// from the device's zero, never wraps
  int64_t position_counts;
  /// the same as an angle
  double angle_rad;
} torsio_clock;
TORSIO_API torsio_result torsio_clock_init(torsio_clock* structure);

/// State and counters of the device since its power-up.
typedef struct torsio_health {
  uint32_t struct_size;  ///< bytes of a torsio_health
  /// a torsio_state: whether it makes torque
  int32_t state;
  /// TORSIO_FAULT_...: the latched faults
  uint32_t faults;
  /// that did what they asked
  uint32_t reports_accepted;
  /// that changed nothing
  uint32_t reports_refused;
  /// telemetry that the host did not fetch in time
  uint32_t samples_dropped;
  /// ticks that were missed
  uint32_t tick_overruns;
  /// time that the last control tick took
  double tick_time_s;
  /// longest tick so far
  double tick_time_max_s;
  /// how often the configuration was saved, ever
  uint32_t saves;
  /// a torsio_owner: owner of the actuator
  int32_t owner;
  /// a torsio_reset_cause: why the device started
  int32_t reset_cause;
  /// swings of the law `calibrated` that lasted in scenes which the configured parts can render,
  /// and four for a ring, since the knob was configured, less one for fifty turns
  uint32_t unexpected_swings;
  /// a torsio_centre: where angle 0 comes from
  int32_t centre;
} torsio_health;
TORSIO_API torsio_result torsio_health_init(torsio_health* structure);

/// Energies that the law `calibrated` has counted since it was chosen. The hand feels the motor's
/// energy, the shaft stores it, or the brake takes it.
typedef struct torsio_energies {
  uint32_t struct_size;  ///< bytes of a torsio_energies
  /// of this moment: control periods since power-up
  uint64_t tick;
  /// tick times the control period
  double time_s;
  /// the law keeps count; else all stand still
  bool kept;
  /// given to the knob by the motor
  double motor_j;
  /// given to the knob by motor and shaft together, which a hand feels
  double felt_j;
  /// in the shaft's spring now
  double stored_j;
  /// taken by the brake
  double brake_j;
  /// the stiffest that is rendered now, found out from the knob's swings; 0: no bound
  double bound_nm_per_rad;
} torsio_energies;
TORSIO_API torsio_result torsio_energies_init(torsio_energies* structure);

/// Sums of the motor's current readings and of its bridge's shares since the board started. The
/// difference of two readings covers everything in between.
typedef struct torsio_motor_current {
  uint32_t struct_size;  ///< bytes of a torsio_motor_current
  /// there is a current sensor; without one the other fields are 0
  bool measured;
  /// periods of the current loop since the board started
  double time_s;
  /// at the newest tick
  double angle_rad;
  /// of the current loop
  double period_s;
  /// from a measurement to the voltage that answers it
  double delay_s;
  /// done, each with one measurement
  uint64_t periods;
  /// the newest measurement, without its zero
  double current_a;
  /// reading without current
  double zero_a;
  /// of the converter
  double step_a;
  /// of all measurements, each with its zero
  double current_sum_a;
  /// share of the supply's voltage that answers it
  double share;
  /// share before it
  double share_before;
  /// sum of all shares, positive to larger angles
  double share_sum;
  /// that the board reckons with: what it was configured to when it started
  double torque_constant_nm_per_a;
} torsio_motor_current;
TORSIO_API torsio_result torsio_motor_current_init(torsio_motor_current* structure);

/// The most that the device gives, by its configuration as it is now.
typedef struct torsio_limits {
  uint32_t struct_size;  ///< bytes of a torsio_limits
  /// of the motor, for seconds
  double motor_torque_max_nm;
  /// the same for ever, as its winding stands it
  double motor_torque_continuous_max_nm;
  /// of the brake
  double brake_torque_max_nm;
  /// more is a fault; 0: no limit
  double speed_limit_rad_s;
  /// the board gives little, because nobody has confirmed its parts, or because their values are
  /// assumed; `confirmed` and a calibration end it
  bool held_low;
} torsio_limits;
TORSIO_API torsio_result torsio_limits_init(torsio_limits* structure);

/// How stiff a spring can be that a knob swings in and still comes to rest.
typedef struct torsio_stable_stiffness {
  uint32_t struct_size;  ///< bytes of a torsio_stable_stiffness
  /// the stiffest such spring
  double stiffness_nm_per_rad;
  /// the limit to improve: "rate" of the control, "lag" of the motor, "counts" of the encoder
  char limited_by[TORSIO_TEXT_BYTES];
} torsio_stable_stiffness;
TORSIO_API torsio_result torsio_stable_stiffness_init(torsio_stable_stiffness* structure);

/// Effects of games on the device.
typedef struct torsio_game_status {
  uint32_t struct_size;  ///< bytes of a torsio_game_status
  /// of this moment: the device's tick times the control period
  double time_s;
  /// a torsio_owner: owner of the actuator
  int32_t owner;
  /// by the game
  bool paused;
  /// the game wants the actuator on
  bool enabled;
  /// of the device, as the game set it, 0 to 1
  double gain;
  /// of all effects together
  double torque_nm;
  /// reports that games sent since power-up
  uint32_t updates;
  /// that exist
  int32_t effects;
  /// ticks in which effects asked for more than all together get, since power-up
  uint32_t clipped_ticks;
  /// the most that effects asked for in the last half second, as a share of their joint limit
  int32_t asked_percent;
} torsio_game_status;
TORSIO_API torsio_result torsio_game_status_init(torsio_game_status* structure);

/// One effect that a game has made.
typedef struct torsio_game_effect {
  /// its number, from 1; 0: an empty row of the report
  int32_t block;
  /// a torsio_game_effect_kind: its kind
  int32_t kind;
  /// a torsio_game_effect_state: whether it plays
  int32_t state;
  /// torque now, before the cap on all together
  double torque_nm;
  /// reports about it since it was made
  uint32_t updates;
  /// since the last of them; 65.535 s is that or longer
  double silent_s;
} torsio_game_effect;

/// Counters of this end of the cable, since the knob was opened.
typedef struct torsio_link_statistics {
  uint32_t struct_size;  ///< bytes of a torsio_link_statistics
  /// to the device
  uint64_t reports_sent;
  /// from the device
  uint64_t reports_received;
  /// damaged on the way, and ignored
  uint64_t reports_undecodable;
  /// of telemetry
  uint64_t samples_received;
  /// never arrived, or not read before the ring was full
  uint64_t samples_lost;
  /// not taken before there were 1,024 of them
  uint64_t events_lost;
  /// by the device
  uint64_t local_models_refused;
  /// of a local model, in words
  char last_refusal[TORSIO_TEXT_BYTES];
} torsio_link_statistics;
TORSIO_API torsio_result torsio_link_statistics_init(torsio_link_statistics* structure);

/// Something that the device did without being asked, or that somebody else asked for.
typedef struct torsio_event {
  uint32_t struct_size;  ///< bytes of a torsio_event
  /// kind of event: "state_changed", "watchdog", "deadline_missed", ...
  char kind[TORSIO_TEXT_BYTES];
  /// a torsio_state: after the event
  int32_t state;
  /// a torsio_owner: owner of the actuator after the event
  int32_t owner;
  /// TORSIO_FAULT_...: the faults that are latched after it
  uint32_t faults;
  /// when: control periods since power-up
  uint64_t tick;
  /// tick times the control period
  double time_s;
} torsio_event;
TORSIO_API torsio_result torsio_event_init(torsio_event* structure);

/// How the torque went the last time.
typedef struct torsio_disarm {
  uint32_t struct_size;  ///< bytes of a torsio_disarm
  /// a torsio_disarm_reason: why it went
  int32_t reason;
  /// TORSIO_FAULT_...: the faults that were latched then
  uint32_t faults;
  /// when: control periods since power-up
  uint64_t tick;
  /// tick times the control period
  double time_s;
} torsio_disarm;
TORSIO_API torsio_result torsio_disarm_init(torsio_disarm* structure);

/// True electric values of an emulated knob, now.
typedef struct torsio_electrics_state {
  uint32_t struct_size;  ///< bytes of a torsio_electrics_state
  /// positive turns the knob to larger angles
  double motor_current_a;
  /// of the brake
  double coil_current_a;
  /// at the bridges
  double supply_v;
  /// temperature of the motor's winding
  double winding_c;
  /// of its rotor
  double rotor_c;
  /// of the brake's coil
  double coil_c;
} torsio_electrics_state;
TORSIO_API torsio_result torsio_electrics_state_init(torsio_electrics_state* structure);

/// One moment of the control loop. Torques are on the knob.
typedef struct torsio_telemetry_sample {
  /// control periods since power-up
  uint64_t tick;
  /// tick times the control period
  double time_s;
  /// from the device's zero, never wraps
  int64_t position_counts;
  /// the same as an angle
  double angle_rad;
  /// estimated
  float speed_rad_s;
  /// torque that the scene asks for
  float desired_torque_nm;
  /// asked of the motor
  float motor_command_nm;
  /// most that the brake can hold, estimated
  float brake_capacity_nm;
  /// of the shaft on the knob, sensed
  float spring_torque_nm;
  /// of this sample or a neighbour in the same report
  uint8_t flags;
} torsio_telemetry_sample;

/// True values of an emulated knob at the start of a control tick. Torques on the knob.
typedef struct torsio_truth_sample {
  /// device time
  double time_s;
  /// of the knob
  double angle_rad;
  /// of the far side of the shaft spring
  double brake_angle_rad;
  /// of the knob
  double speed_rad_s;
  /// of the shaft spring
  double spring_torque_nm;
  /// torque that the brake transmits, drag included
  double brake_torque_nm;
  /// most that it could transmit, drag included, >= 0
  double brake_capacity_nm;
  /// after the motor's lag
  double motor_torque_nm;
  /// of the hand on the knob
  double hand_torque_nm;
} torsio_truth_sample;

/// Put an effect behind those that a scene has; ranges are checked when it is played.
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

/// Read a configuration, or set a whole one, which the device takes while it is disarmed: to change
/// a field, read, change, set. `torsio_knob_save` keeps it over power-off.
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
