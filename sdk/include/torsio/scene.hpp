/// @file
/// Scenes: what the knob shall feel like. Torques are torques on the knob, positive along positive
/// angle. Angles are measured from the device's zero. docs/protocol.md has the equation of each
/// effect and the range of each field; the ranges here are the same.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

namespace torsio {

inline constexpr double kMaxTorqueNm = 100.0;  ///< of any effect; the actuator's limits are lower

/// When an effect plays, and how its strength comes and goes.
struct Timing {
  double delay_s = 0.0;       ///< silence after play(), >= 0
  double duration_s = 0.0;    ///< 0 plays without end
  double attack_level = 1.0;  ///< share of the strength at the start, 0 to 1
  double attack_s = 0.0;      ///< time to full strength
  double fade_level = 1.0;    ///< share of the strength at the end, 0 to 1
  double fade_s = 0.0;        ///< fading time before the end
};

enum class Side : std::uint8_t { above, below };
enum class Waveform : std::uint8_t { sine, square, triangle, sawtooth_up, sawtooth_down };
enum class DetentProfile : std::uint8_t { sine, linear, click };
enum class Grain : std::uint8_t { sine, square, triangle, noise };
enum class Ends : std::uint8_t { hold, repeat };

/// A virtual wall: inside it, stiffness times depth plus damping times inward speed, never a pull.
struct Wall {
  double angle_rad = 0.0;  ///< the wall's surface
  double stiffness_nm_per_rad = 0.0;
  double damping_nm_s_per_rad = 0.0;
  Side side = Side::above;  ///< on which side of the surface the wall is solid
};

/// A spring to an angle, with an optional dead band.
struct Spring {
  double angle_rad = 0.0;  ///< rest angle
  double stiffness_nm_per_rad = 0.0;
  double deadband_rad = 0.0;  ///< no torque within this distance of the rest angle
  double torque_limit_nm = kMaxTorqueNm;
};

/// Torque against the speed.
struct Damper {
  double damping_nm_s_per_rad = 0.0;
  double torque_limit_nm = kMaxTorqueNm;
};

/// Dry friction that sticks: a spring to an anchor that is dragged along once `torque_nm` is
/// reached.
struct Friction {
  double torque_nm = 0.0;             ///< while sliding
  double stiffness_nm_per_rad = 1.0;  ///< while sticking, > 0
};

/// Torque against the acceleration.
struct Inertia {
  double inertia_kg_m2 = 0.0;
  double torque_limit_nm = kMaxTorqueNm;
};

/// A constant torque.
struct Constant {
  double torque_nm = 0.0;
  Timing timing{};
};

/// A torque that goes from start to end over `timing.duration_s`, which must not be 0.
struct Ramp {
  double start_torque_nm = 0.0;
  double end_torque_nm = 0.0;
  Timing timing{};
};

/// A torque that repeats in time. The envelope acts on the amplitude, not on the offset.
struct Periodic {
  Waveform waveform = Waveform::sine;
  double amplitude_nm = 0.0;
  double offset_nm = 0.0;
  double frequency_hz = 0.0;  ///< at most half the control rate
  double phase_turns = 0.0;   ///< where in the period it starts, 0 to 1
  Timing timing{};
};

/// Notches at equal distances. Give exactly one of `per_turn` and `pitch_rad`.
struct Detents {
  std::optional<double> per_turn{};   ///< notches in a turn, > 0; need not be whole
  std::optional<double> pitch_rad{};  ///< distance of two notches, > 0
  double torque_nm = 0.0;             ///< largest torque
  double angle_rad = 0.0;             ///< where one of the notches is
  DetentProfile profile = DetentProfile::sine;
  double width = 0.5;  ///< share of the pitch, 0.01 to 1; click only
};

/// Two walls that bound the range between them.
struct EndStops {
  double lower_rad = 0.0;
  double upper_rad = 0.0;  ///< not below the lower one
  double stiffness_nm_per_rad = 0.0;
  double damping_nm_s_per_rad = 0.0;
};

/// A rough surface fixed to the knob, the same in every turn.
struct Texture {
  int grains_per_turn = 1;  ///< 1 to half the encoder's counts
  double torque_nm = 0.0;
  Grain grain = Grain::noise;
  std::uint32_t seed = 0;  ///< another seed, another surface; noise only
};

/// A torque over angle, linear between equally spaced points on [angle_rad, angle_rad + span_rad].
/// Outside it holds its end values or repeats.
struct Curve {
  std::vector<double> torque_nm{};  ///< at least 2 points; all curves of a scene share 1024
  double angle_rad = 0.0;           ///< of the first point
  double span_rad = 1.0;            ///< from the first point to the last
  Ends ends = Ends::hold;
};

using Effect = std::variant<Wall, Spring, Damper, Friction, Inertia, Constant, Ramp, Periodic,
                            Detents, EndStops, Texture, Curve>;

/// Up to 16 effects; their torques add up. The place in the list is the effect's identity: an
/// effect that stands at the same place with the same values in the next scene goes on playing,
/// any other starts anew.
using Scene = std::vector<Effect>;

/// A torque, a spring and a damper that the device renders at its own rate, on top of the scene,
/// until the next one comes: `torque - stiffness (angle - angle_rad) - damping speed`.
struct LocalModel {
  double torque_nm = 0.0;
  double angle_rad = 0.0;
  double stiffness_nm_per_rad = 0.0;
  double damping_nm_s_per_rad = 0.0;
  double deadline_s = 0.02;  ///< how long it holds, to 60; 0 ends the stream in good order
};

}  // namespace torsio
