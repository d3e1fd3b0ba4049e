/// @file
/// Scenes: what the knob shall feel like. Torques are torques on the knob, positive along positive
/// angle. Angles are measured from the device's zero. docs/reference/protocol.md has the equation
/// of each effect.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

namespace torsio {

inline constexpr double kMaxTorqueNm = 100.0;  ///< of any effect; the actuator's limits are lower

/// On which side of its surface a wall is solid.
enum class Side : std::uint8_t { above, below };

/// Shape of a periodic torque.
enum class Waveform : std::uint8_t { sine, square, triangle, sawtooth_up, sawtooth_down };

/// Torque from one notch to the next: -T sin(2 pi u) at u pitches from a notch; -2 T u within half
/// a pitch; or linear within the width, beyond it T toward the notch.
enum class DetentProfile : std::uint8_t { sine, linear, click };

/// Shape of a texture's grains; noise draws a value for each and joins them smoothly.
enum class Grain : std::uint8_t { sine, square, triangle, noise };

/// A curve's torque outside its span.
enum class Ends : std::uint8_t { hold, repeat };

/// When an effect plays, and how its strength comes and goes.
struct Timing {
  double delay_s = 0.0;       ///< silence after the scene begins; 0 to 1e5
  double duration_s = 0.0;    ///< 0 plays without end; 0 to 1e5
  double attack_level = 1.0;  ///< share of the strength at the start; 0 to 1
  double attack_s = 0.0;      ///< time to full strength; 0 to 1e5
  double fade_level = 1.0;    ///< share of the strength at the end; 0 to 1
  double fade_s = 0.0;        ///< fading time before the end; 0 to 1e5
};

/// A virtual wall: inside it, stiffness times depth plus damping times inward speed, never a pull.
struct Wall {
  double angle_rad = 0.0;   ///< the wall's surface
  Side side = Side::above;  ///< on which side of the surface the wall is solid
  /// must be given; torque per depth; 0 to 1e6
  double stiffness_nm_per_rad = std::numeric_limits<double>::quiet_NaN();
  double damping_nm_s_per_rad = 0.0;  ///< torque per inward speed; 0 to 1000
};

/// A spring to an angle, with an optional dead band.
struct Spring {
  double angle_rad = 0.0;  ///< rest angle
  /// must be given; torque per distance from the rest angle; 0 to 1e6
  double stiffness_nm_per_rad = std::numeric_limits<double>::quiet_NaN();
  double deadband_rad = 0.0;       ///< no torque within this distance of the rest angle; 0 to 1000
  double torque_limit_nm = 100.0;  ///< the torque does not grow beyond this; 0 to 100
};

/// Torque against the speed.
struct Damper {
  /// must be given; torque per speed; 0 to 1000
  double damping_nm_s_per_rad = std::numeric_limits<double>::quiet_NaN();
  double torque_limit_nm = 100.0;  ///< the torque does not grow beyond this; 0 to 100
};

/// Dry friction that sticks: a spring to an anchor that is dragged along once the torque is
/// reached.
struct Friction {
  /// must be given; while sliding; 0 to 100
  double torque_nm = std::numeric_limits<double>::quiet_NaN();
  double stiffness_nm_per_rad = 1.0;  ///< while sticking; 1e-6 to 1e6
};

/// Torque against the acceleration.
struct Inertia {
  /// must be given; torque per acceleration; 0 to 10
  double inertia_kg_m2 = std::numeric_limits<double>::quiet_NaN();
  double torque_limit_nm = 100.0;  ///< the torque does not grow beyond this; 0 to 100
};

/// A constant torque.
struct Constant {
  /// must be given; at full strength; -100 to 100
  double torque_nm = std::numeric_limits<double>::quiet_NaN();
  Timing timing{};  ///< when it plays, and its envelope
};

/// A torque that goes from start to end over the duration in `timing`, which must not be 0.
struct Ramp {
  /// must be given; when the duration begins; -100 to 100
  double start_torque_nm = std::numeric_limits<double>::quiet_NaN();
  /// must be given; when it ends; -100 to 100
  double end_torque_nm = std::numeric_limits<double>::quiet_NaN();
  Timing timing{};  ///< when it plays, and its envelope
};

/// A torque that repeats in time. The envelope acts on the amplitude, not on the offset.
struct Periodic {
  Waveform waveform = Waveform::sine;  ///< starts at 0 and rises; the square starts high
  /// must be given; of the wave, from its middle; 0 to 100
  double amplitude_nm = std::numeric_limits<double>::quiet_NaN();
  double offset_nm = 0.0;  ///< the wave's middle; -100 to 100
  /// must be given; at most half the control rate; 0 to 1e4
  double frequency_hz = std::numeric_limits<double>::quiet_NaN();
  double phase_turns = 0.0;  ///< where in the period it starts; 0 to 1
  Timing timing{};           ///< when it plays, and its envelope
};

/// Notches at equal distances. Give exactly one of `per_turn` and `pitch_rad`.
struct Detents {
  double angle_rad = 0.0;             ///< where one of the notches is
  std::optional<double> per_turn{};   ///< notches in a turn, > 0; need not be whole
  std::optional<double> pitch_rad{};  ///< distance of two notches, > 0
  /// must be given; largest torque; 0 to 100
  double torque_nm = std::numeric_limits<double>::quiet_NaN();
  DetentProfile profile = DetentProfile::sine;  ///< torque from one notch to the next
  double width = 0.5;                           ///< share of the pitch; click only; 0.01 to 1
};

/// Two walls that bound the range between them.
struct EndStops {
  /// must be given; surface of the lower wall
  double lower_rad = std::numeric_limits<double>::quiet_NaN();
  /// must be given; surface of the upper one, not below the lower one
  double upper_rad = std::numeric_limits<double>::quiet_NaN();
  /// must be given; torque per depth, of either wall; 0 to 1e6
  double stiffness_nm_per_rad = std::numeric_limits<double>::quiet_NaN();
  double damping_nm_s_per_rad = 0.0;  ///< torque per inward speed, of either wall; 0 to 1000
};

/// A rough surface fixed to the knob, the same in every turn.
struct Texture {
  int grains_per_turn = 0;  ///< must be given; at most half the encoder's counts; 1 to 65535
  /// must be given; of the highest grain; 0 to 100
  double torque_nm = std::numeric_limits<double>::quiet_NaN();
  Grain grain = Grain::noise;  ///< shape of a grain
  std::uint32_t seed = 0;      ///< another seed, another surface; noise only
};

/// A torque over angle, linear between equally spaced points on [angle_rad, angle_rad + span_rad].
struct Curve {
  std::vector<double> torque_nm{};  ///< at least 2 points; all curves of a scene share 1024
  double angle_rad = 0.0;           ///< angle of the first point
  /// from the first point to the last; at least two of the encoder's counts; 0 to 804.247719
  double span_rad = 1.0;
  Ends ends = Ends::hold;  ///< its torque outside the span
};

/// The knock of something hard, in proportion to the knob's speed into the surface: a decaying
/// sine, and a pulse that brakes. It acts inside only. At control rates from 4 kHz it gives back no
/// more energy than it took, within one count, unless it needs the whole supply or the motor is
/// over 2.5 times as slow as configured.
struct Impact {
  double angle_rad = 0.0;   ///< the surface, usually a wall's
  Side side = Side::above;  ///< on which side of the surface it is solid
  /// the sine's torque at first, per speed of impact; 0 to 1000
  double strength_nm_s_per_rad = 0.0;
  double frequency_hz = 300.0;      ///< of the sine; at most half the control rate; 1 to 1000
  double decay_s = 0.005;           ///< in which the sine falls to 1/e; 1e-4 to 0.1
  double pulse_nm_s_per_rad = 0.0;  ///< the pulse's torque, per speed of impact; 0 to 1000
  double pulse_s = 0.005;  ///< how long the pulse lasts; it ends where the knob stops; 0 to 0.1
  double torque_limit_nm = 100.0;  ///< the torque does not grow beyond this; 0 to 100
};

/// Any effect.
using Effect = std::variant<Wall, Spring, Damper, Friction, Inertia, Constant, Ramp, Periodic,
                            Detents, EndStops, Texture, Curve, Impact>;

/// Up to 16 effects; their torques add up. An effect with the same place and the same values in the
/// next scene goes on playing. Any other starts anew.
using Scene = std::vector<Effect>;

/// A torque, a spring and a damper that the device renders at its own rate, on top of the scene,
/// until the next one comes: `torque - stiffness (angle - angle_rad) - damping speed`.
struct LocalModel {
  double torque_nm = 0.0;             ///< at the reference, at rest; -100 to 100
  double angle_rad = 0.0;             ///< reference position
  double stiffness_nm_per_rad = 0.0;  ///< 0 to 1e6
  double damping_nm_s_per_rad = 0.0;  ///< 0 to 1000
  double deadline_s = 0.02;  ///< how long it holds; 0 ends the stream in good order; 0 to 60
};

/// A bounded experiment: commands of motor and brake that go past scene and law. Both commands move
/// in a straight line from where the last excitation is now. The motor also gets a sine and the
/// torque of a servo, `servo_stiffness (reference - angle) + servo_damping (reference' - speed)`.
/// The device disarms when a bound is left, or when the time is over and no next one has come. It
/// also disarms when the servo asks for all of the motor for 50 ms and the encoder stands still.
struct Excitation {
  /// must be given; until it disarms, unless the next one comes first; 0.001 to 60
  double duration_s = std::numeric_limits<double>::quiet_NaN();
  /// must be given; further from its first angle disarms; 0.001 to 1000
  double travel_rad = std::numeric_limits<double>::quiet_NaN();
  /// must be given; faster disarms; 0.1 to 1e4
  double speed_limit_rad_s = std::numeric_limits<double>::quiet_NaN();
  /// must be given; largest torque of the motor; 0 to 100
  double torque_limit_nm = std::numeric_limits<double>::quiet_NaN();
  double motor_command_nm = 0.0;  ///< where the motor goes; -100 to 100
  double brake_command_nm = 0.0;  ///< where the brake's command goes; 0 to 100
  double ramp_s = 0.0;            ///< time that both take; 0 is a step; 0 to 60
  double sine_nm = 0.0;           ///< amplitude of the sine on top of `motor_command_nm`; 0 to 100
  double sine_begin_hz = 0.0;     ///< its frequency at the beginning; 0 to 1000
  double sine_end_hz = 0.0;       ///< and after `duration_s`; 0 to 1000
  double stiffness_nm_per_rad = 0.0;  ///< of the servo; 0 to 1e6
  double damping_nm_s_per_rad = 0.0;  ///< of the servo; 0 to 1000
  double servo_rad_s = 0.0;           ///< speed of the servo's reference; -1000 to 1000
};

}  // namespace torsio
