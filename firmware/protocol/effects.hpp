/// @file
/// The effects of a scene as they travel: one report each. Angles that may lie many turns away are
/// fixed-point turns, which stay exact after any amount of turning. Every other quantity is a float
/// in SI units. Torques are torques on the knob, positive along positive angle.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <variant>

#include "protocol/enumerations.hpp"
#include "protocol/layout.hpp"

namespace torsio::protocol {

inline constexpr std::uint8_t max_effects = 16;
inline constexpr std::uint16_t curve_pool_points = 1024;
inline constexpr std::uint8_t curve_points_per_report = 13;
inline constexpr float max_torque_nm = 100;
inline constexpr float max_stiffness_nm_per_rad = 1e6F;
inline constexpr float max_damping_nm_s_per_rad = 1000;
inline constexpr float max_inertia_kg_m2 = 10;
inline constexpr float max_time_s = 1e5F;
inline constexpr std::int64_t max_turns_q32 = std::int64_t{1} << 58;  // 2^26 turns either way
inline constexpr std::uint64_t min_span_turns_q32 = 1U << 16;
inline constexpr std::uint64_t max_span_turns_q32 = std::uint64_t{1} << 39;  // 128 turns
inline constexpr std::uint64_t max_cycles_per_turn_q32 = std::uint64_t{1} << 48;

/// Where an effect belongs.
struct Target {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  std::uint8_t slot = 0;
};
template <>
struct Layout<Target> {
  static constexpr std::string_view name = "target";
  static constexpr std::string_view doc = "Where an effect belongs.";
  static constexpr FieldList fields{
      any_number("sequence", &Target::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &Target::axis, "", "0: an interface has one axis"),
      number("slot", &Target::slot, "", 0, 15, "place in the scene"),
  };
};

/// When an effect plays, and how its strength comes and goes.
struct Timing {
  float delay_s = 0;
  float duration_s = 0;
  float attack_level = 1;
  float attack_s = 0;
  float fade_level = 1;
  float fade_s = 0;
};
template <>
struct Layout<Timing> {
  static constexpr std::string_view name = "timing";
  static constexpr std::string_view doc =
      "When an effect plays, and how its strength comes and goes.";
  static constexpr FieldList fields{
      number("delay_s", &Timing::delay_s, "s", 0, max_time_s, "silence after the scene begins"),
      number("duration_s", &Timing::duration_s, "s", 0, max_time_s, "0 plays without end"),
      number("attack_level", &Timing::attack_level, "", 0, 1, "share of the strength at the start"),
      number("attack_s", &Timing::attack_s, "s", 0, max_time_s, "time to full strength"),
      number("fade_level", &Timing::fade_level, "", 0, 1, "share of the strength at the end"),
      number("fade_s", &Timing::fade_s, "s", 0, max_time_s, "fading time before the end"),
  };
};

/// A virtual wall: inside it, stiffness times depth plus damping times inward speed, never a pull.
struct Wall {
  Target target;
  std::int64_t angle_turns_q32 = 0;
  Side side = Side::above;
  float stiffness_nm_per_rad = 0;
  float damping_nm_s_per_rad = 0;
};
template <>
struct Layout<Wall> {
  static constexpr std::uint8_t id = 0x20;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "wall";
  static constexpr std::string_view doc =
      "A virtual wall: inside it, stiffness times depth plus damping times inward speed, never a "
      "pull.";
  static constexpr FieldList fields{
      group("target", &Wall::target, ""),
      number("angle_turns_q32", &Wall::angle_turns_q32, "2^-32 turn", -max_turns_q32, max_turns_q32,
             "the wall's surface"),
      choice("side", &Wall::side, "on which side of the surface the wall is solid"),
      number("stiffness_nm_per_rad", &Wall::stiffness_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad, "torque per depth"),
      number("damping_nm_s_per_rad", &Wall::damping_nm_s_per_rad, "N m s/rad", 0,
             max_damping_nm_s_per_rad, "torque per inward speed"),
  };
};

/// A spring to an angle, with an optional dead band.
struct Spring {
  Target target;
  std::int64_t angle_turns_q32 = 0;
  float stiffness_nm_per_rad = 0;
  float deadband_rad = 0;
  float torque_limit_nm = max_torque_nm;
};
template <>
struct Layout<Spring> {
  static constexpr std::uint8_t id = 0x21;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "spring";
  static constexpr std::string_view doc = "A spring to an angle, with an optional dead band.";
  static constexpr FieldList fields{
      group("target", &Spring::target, ""),
      number("angle_turns_q32", &Spring::angle_turns_q32, "2^-32 turn", -max_turns_q32,
             max_turns_q32, "rest angle"),
      number("stiffness_nm_per_rad", &Spring::stiffness_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad, "torque per distance from the rest angle"),
      number("deadband_rad", &Spring::deadband_rad, "rad", 0, 1000,
             "no torque within this distance of the rest angle"),
      number("torque_limit_nm", &Spring::torque_limit_nm, "N m", 0, max_torque_nm,
             "the torque does not grow beyond this"),
  };
};

/// Torque against the speed.
struct Damper {
  Target target;
  float damping_nm_s_per_rad = 0;
  float torque_limit_nm = max_torque_nm;
};
template <>
struct Layout<Damper> {
  static constexpr std::uint8_t id = 0x22;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "damper";
  static constexpr std::string_view doc = "Torque against the speed.";
  static constexpr FieldList fields{
      group("target", &Damper::target, ""),
      number("damping_nm_s_per_rad", &Damper::damping_nm_s_per_rad, "N m s/rad", 0,
             max_damping_nm_s_per_rad, "torque per speed"),
      number("torque_limit_nm", &Damper::torque_limit_nm, "N m", 0, max_torque_nm,
             "the torque does not grow beyond this"),
  };
};

/// Dry friction that sticks: a spring to an anchor that is dragged along once the torque is
/// reached.
struct Friction {
  Target target;
  float torque_nm = 0;
  float stiffness_nm_per_rad = 1;
};
template <>
struct Layout<Friction> {
  static constexpr std::uint8_t id = 0x23;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "friction";
  static constexpr std::string_view doc =
      "Dry friction that sticks: a spring to an anchor that is dragged along once the torque is "
      "reached.";
  static constexpr FieldList fields{
      group("target", &Friction::target, ""),
      number("torque_nm", &Friction::torque_nm, "N m", 0, max_torque_nm, "while sliding"),
      number("stiffness_nm_per_rad", &Friction::stiffness_nm_per_rad, "N m/rad", 1e-6F,
             max_stiffness_nm_per_rad, "while sticking"),
  };
};

/// Torque against the acceleration.
struct Inertia {
  Target target;
  float inertia_kg_m2 = 0;
  float torque_limit_nm = max_torque_nm;
};
template <>
struct Layout<Inertia> {
  static constexpr std::uint8_t id = 0x24;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "inertia";
  static constexpr std::string_view doc = "Torque against the acceleration.";
  static constexpr FieldList fields{
      group("target", &Inertia::target, ""),
      number("inertia_kg_m2", &Inertia::inertia_kg_m2, "kg m^2", 0, max_inertia_kg_m2,
             "torque per acceleration"),
      number("torque_limit_nm", &Inertia::torque_limit_nm, "N m", 0, max_torque_nm,
             "the torque does not grow beyond this"),
  };
};

/// A constant torque.
struct Constant {
  Target target;
  float torque_nm = 0;
  Timing timing;
};
template <>
struct Layout<Constant> {
  static constexpr std::uint8_t id = 0x25;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "constant";
  static constexpr std::string_view doc = "A constant torque.";
  static constexpr FieldList fields{
      group("target", &Constant::target, ""),
      number("torque_nm", &Constant::torque_nm, "N m", -max_torque_nm, max_torque_nm,
             "at full strength"),
      group("timing", &Constant::timing, "when it plays, and its envelope"),
  };
};

/// A torque that goes from start to end over the duration in `timing`, which must not be 0.
struct Ramp {
  Target target;
  float start_torque_nm = 0;
  float end_torque_nm = 0;
  Timing timing;
};
template <>
struct Layout<Ramp> {
  static constexpr std::uint8_t id = 0x26;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "ramp";
  static constexpr std::string_view doc =
      "A torque that goes from start to end over the duration in `timing`, which must not be 0.";
  static constexpr FieldList fields{
      group("target", &Ramp::target, ""),
      number("start_torque_nm", &Ramp::start_torque_nm, "N m", -max_torque_nm, max_torque_nm,
             "when the duration begins"),
      number("end_torque_nm", &Ramp::end_torque_nm, "N m", -max_torque_nm, max_torque_nm,
             "when it ends"),
      group("timing", &Ramp::timing, "when it plays, and its envelope"),
  };
};

/// A torque that repeats in time. The envelope acts on the amplitude, not on the offset.
struct Periodic {
  Target target;
  Waveform waveform = Waveform::sine;
  float amplitude_nm = 0;
  float offset_nm = 0;
  float frequency_hz = 0;
  float phase_turns = 0;
  Timing timing;
};
template <>
struct Layout<Periodic> {
  static constexpr std::uint8_t id = 0x27;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "periodic";
  static constexpr std::string_view doc =
      "A torque that repeats in time. The envelope acts on the amplitude, not on the offset.";
  static constexpr FieldList fields{
      group("target", &Periodic::target, ""),
      choice("waveform", &Periodic::waveform, "starts at 0 and rises; the square starts high"),
      number("amplitude_nm", &Periodic::amplitude_nm, "N m", 0, max_torque_nm,
             "of the wave, from its middle"),
      number("offset_nm", &Periodic::offset_nm, "N m", -max_torque_nm, max_torque_nm,
             "the wave's middle"),
      number("frequency_hz", &Periodic::frequency_hz, "Hz", 0, 1e4F,
             "at most half the control rate"),
      number("phase_turns", &Periodic::phase_turns, "turn", 0, 1, "where in the period it starts"),
      group("timing", &Periodic::timing, "when it plays, and its envelope"),
  };
};

/// Notches at equal distances. Torque at u pitches from a notch: sine -T sin(2 pi u), linear -2 T u
/// within half a pitch, click linear within the width and T toward the notch beyond it.
struct Detents {
  Target target;
  std::int64_t angle_turns_q32 = 0;
  std::uint64_t per_turn_q32 = std::uint64_t{3} << 35;
  float torque_nm = 0;
  DetentProfile profile = DetentProfile::sine;
  float width = 0.5F;
};
template <>
struct Layout<Detents> {
  static constexpr std::uint8_t id = 0x28;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "detents";
  static constexpr std::string_view doc =
      "Notches at equal distances. Torque at u pitches from a notch: sine -T sin(2 pi u), linear "
      "-2 T u within half a pitch, click linear within the width and T toward the notch beyond it.";
  static constexpr FieldList fields{
      group("target", &Detents::target, ""),
      number("angle_turns_q32", &Detents::angle_turns_q32, "2^-32 turn", -max_turns_q32,
             max_turns_q32, "where one of the notches is"),
      number("per_turn_q32", &Detents::per_turn_q32, "2^-32", 1, max_cycles_per_turn_q32,
             "notches in a turn; at most half the encoder's counts"),
      number("torque_nm", &Detents::torque_nm, "N m", 0, max_torque_nm, "largest torque"),
      choice("profile", &Detents::profile, "torque from one notch to the next"),
      number("width", &Detents::width, "", 0.01F, 1, "share of the pitch; click only"),
  };
};

/// Two walls that bound the range between them.
struct EndStops {
  Target target;
  std::int64_t lower_turns_q32 = 0;
  std::int64_t upper_turns_q32 = 0;
  float stiffness_nm_per_rad = 0;
  float damping_nm_s_per_rad = 0;
};
template <>
struct Layout<EndStops> {
  static constexpr std::uint8_t id = 0x29;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "end_stops";
  static constexpr std::string_view doc = "Two walls that bound the range between them.";
  static constexpr FieldList fields{
      group("target", &EndStops::target, ""),
      number("lower_turns_q32", &EndStops::lower_turns_q32, "2^-32 turn", -max_turns_q32,
             max_turns_q32, "surface of the lower wall"),
      number("upper_turns_q32", &EndStops::upper_turns_q32, "2^-32 turn", -max_turns_q32,
             max_turns_q32, "surface of the upper one, not below the lower one"),
      number("stiffness_nm_per_rad", &EndStops::stiffness_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad, "torque per depth, of either wall"),
      number("damping_nm_s_per_rad", &EndStops::damping_nm_s_per_rad, "N m s/rad", 0,
             max_damping_nm_s_per_rad, "torque per inward speed, of either wall"),
  };
};

/// A rough surface fixed to the knob, the same in every turn. sine, square and triangle repeat with
/// each grain; noise draws a value between -T and T per grain and joins them smoothly.
struct Texture {
  Target target;
  std::uint16_t grains_per_turn = 1;
  float torque_nm = 0;
  Grain grain = Grain::noise;
  std::uint32_t seed = 0;
};
template <>
struct Layout<Texture> {
  static constexpr std::uint8_t id = 0x2A;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "texture";
  static constexpr std::string_view doc =
      "A rough surface fixed to the knob, the same in every turn. sine, square and triangle repeat "
      "with each grain; noise draws a value between -T and T per grain and joins them smoothly.";
  static constexpr FieldList fields{
      group("target", &Texture::target, ""),
      number("grains_per_turn", &Texture::grains_per_turn, "", 1, 65535,
             "at most half the encoder's counts"),
      number("torque_nm", &Texture::torque_nm, "N m", 0, max_torque_nm, "of the highest grain"),
      choice("grain", &Texture::grain, "shape of a grain"),
      any_number("seed", &Texture::seed, "", "another seed, another surface; noise only"),
  };
};

/// A torque over angle, linear between points of the pool. Outside its span it holds its end values
/// or repeats.
struct Curve {
  Target target;
  std::int64_t angle_turns_q32 = 0;
  std::uint64_t span_turns_q32 = std::uint64_t{1} << 32;
  Ends ends = Ends::hold;
  std::uint16_t first_point = 0;
  std::uint16_t points = 2;
};
template <>
struct Layout<Curve> {
  static constexpr std::uint8_t id = 0x2B;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "curve";
  static constexpr std::string_view doc =
      "A torque over angle, linear between points of the pool. Outside its span it holds its end "
      "values or repeats.";
  static constexpr FieldList fields{
      group("target", &Curve::target, ""),
      number("angle_turns_q32", &Curve::angle_turns_q32, "2^-32 turn", -max_turns_q32,
             max_turns_q32, "angle of the first point"),
      number("span_turns_q32", &Curve::span_turns_q32, "2^-32 turn", min_span_turns_q32,
             max_span_turns_q32,
             "from the first point to the last; at least two of the encoder's counts"),
      choice("ends", &Curve::ends, "its torque outside the span"),
      number("first_point", &Curve::first_point, "", 0, 1022, "index in the pool"),
      number("points", &Curve::points, "", 2, curve_pool_points, ""),
  };
};

/// The knock of something hard, in proportion to the knob's speed into the surface: a decaying
/// sine, and a pulse that brakes. It acts inside only. At control rates from 4 kHz it gives back no
/// more energy than it took, within one count, unless it needs the whole supply or the motor is
/// over 2.5 times as slow as configured.
struct Impact {
  Target target;
  std::int64_t angle_turns_q32 = 0;
  Side side = Side::above;
  float strength_nm_s_per_rad = 0;
  float frequency_hz = 300;
  float decay_s = 0.005F;
  float pulse_nm_s_per_rad = 0;
  float pulse_s = 0.005F;
  float torque_limit_nm = max_torque_nm;
};
template <>
struct Layout<Impact> {
  static constexpr std::uint8_t id = 0x2C;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "impact";
  static constexpr std::string_view doc =
      "The knock of something hard, in proportion to the knob's speed into the surface: a decaying "
      "sine, and a pulse that brakes. It acts inside only. At control rates from 4 kHz it gives "
      "back no more energy than it took, within one count, unless it needs the whole supply or the "
      "motor is over 2.5 times as slow as configured.";
  static constexpr FieldList fields{
      group("target", &Impact::target, ""),
      number("angle_turns_q32", &Impact::angle_turns_q32, "2^-32 turn", -max_turns_q32,
             max_turns_q32, "the surface, usually a wall's"),
      choice("side", &Impact::side, "on which side of the surface it is solid"),
      number("strength_nm_s_per_rad", &Impact::strength_nm_s_per_rad, "N m s/rad", 0,
             max_damping_nm_s_per_rad, "the sine's torque at first, per speed of impact"),
      number("frequency_hz", &Impact::frequency_hz, "Hz", 1, 1000,
             "of the sine; at most half the control rate"),
      number("decay_s", &Impact::decay_s, "s", 1e-4F, 0.1F, "in which the sine falls to 1/e"),
      number("pulse_nm_s_per_rad", &Impact::pulse_nm_s_per_rad, "N m s/rad", 0,
             max_damping_nm_s_per_rad, "the pulse's torque, per speed of impact"),
      number("pulse_s", &Impact::pulse_s, "s", 0, 0.1F,
             "how long the pulse lasts; it ends where the knob stops"),
      number("torque_limit_nm", &Impact::torque_limit_nm, "N m", 0, max_torque_nm,
             "the torque does not grow beyond this"),
  };
};

/// Writes points into the pool of the scene that is being built.
struct CurvePoints {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  std::uint16_t first_point = 0;
  std::uint8_t points = 1;
  std::array<float, curve_points_per_report> torque_nm{};
};
template <>
struct Layout<CurvePoints> {
  static constexpr std::uint8_t id = 0x2F;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "curve_points";
  static constexpr std::string_view doc =
      "Writes points into the pool of the scene that is being built.";
  static constexpr FieldList fields{
      any_number("sequence", &CurvePoints::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &CurvePoints::axis, "", "0: an interface has one axis"),
      number("first_point", &CurvePoints::first_point, "", 0, 1023, "index in the pool"),
      number("points", &CurvePoints::points, "", 1, curve_points_per_report,
             "how many of the values count"),
      number("torque_nm", &CurvePoints::torque_nm, "N m", -max_torque_nm, max_torque_nm, ""),
  };
};

/// Reports that put an effect into a slot.
using EffectReports = std::tuple<Wall, Spring, Damper, Friction, Inertia, Constant, Ramp, Periodic,
                                 Detents, EndStops, Texture, Curve, Impact>;

/// Any of them.
using EffectReport = std::variant<Wall, Spring, Damper, Friction, Inertia, Constant, Ramp, Periodic,
                                  Detents, EndStops, Texture, Curve, Impact>;

// The sizes as literals: a change of the wire must be seen in a diff.
static_assert(wire_size<Wall>() == 21);
static_assert(wire_size<Spring>() == 24);
static_assert(wire_size<Damper>() == 12);
static_assert(wire_size<Friction>() == 12);
static_assert(wire_size<Inertia>() == 12);
static_assert(wire_size<Constant>() == 32);
static_assert(wire_size<Ramp>() == 36);
static_assert(wire_size<Periodic>() == 45);
static_assert(wire_size<Detents>() == 29);
static_assert(wire_size<EndStops>() == 28);
static_assert(wire_size<Texture>() == 15);
static_assert(wire_size<Curve>() == 25);
static_assert(wire_size<Impact>() == 37);
static_assert(wire_size<CurvePoints>() == 58);

}  // namespace torsio::protocol
