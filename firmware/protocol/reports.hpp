/// @file
/// Everything that is neither an effect nor configuration: identity, clock, health, commands,
/// telemetry; and the list of all reports.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "protocol/configuration.hpp"
#include "protocol/effects.hpp"
#include "protocol/enumerations.hpp"
#include "protocol/layout.hpp"
#include "protocol/status.hpp"

namespace torsio::protocol {

inline constexpr std::uint32_t min_control_period_ns = 50000;
inline constexpr std::uint32_t max_control_period_ns = 1000000;
inline constexpr std::uint32_t emulated_control_period_ns = 1000000;  // unless it is told another
inline constexpr double min_control_rate_hz = 1000.0;
inline constexpr double max_control_rate_hz = 2e4;

inline constexpr std::uint16_t protocol_version = 1;
inline constexpr std::uint8_t samples_per_report = 4;
inline constexpr std::array<std::uint32_t, 1> released_fingerprints{
    0x9DDBBA23};  // of older firmware that this library drives
inline constexpr std::uint8_t game_effects_per_report = 3;

/// Identity and abilities of the device. Read only.
struct Identity {
  std::uint32_t fingerprint = 0;
  std::uint16_t version = protocol_version;
  std::array<std::uint8_t, 3> firmware_version{};
  std::uint8_t board = 0;
  std::array<std::uint8_t, 16> serial{};
  std::uint8_t axes = 1;
  std::uint8_t effects = max_effects;
  std::uint16_t curve_points = curve_pool_points;
  std::uint32_t control_period_ns = emulated_control_period_ns;
  std::uint32_t counts_per_rev = 8192;
  float torque_step_nm = 1e-5F;
  float speed_step_rad_s = 0.01F;
};
template <>
struct Layout<Identity> {
  static constexpr std::uint8_t id = 0x01;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "identity";
  static constexpr std::string_view doc = "Identity and abilities of the device. Read only.";
  static constexpr FieldList fields{
      any_number("fingerprint", &Identity::fingerprint, "",
                 "of the report layouts, the same as the library's"),
      any_number("version", &Identity::version, "", "version of the protocol"),
      any_number("firmware_version", &Identity::firmware_version, "", "major, minor, patch"),
      any_number("board", &Identity::board, "",
                 "board of the firmware: 0 is the emulated device; firmware/boards/"),
      any_number("serial", &Identity::serial, "", "ASCII, padded with zeros"),
      number("axes", &Identity::axes, "", 1, 16, "actuators behind this interface"),
      number("effects", &Identity::effects, "", 1, max_effects, "places in a scene"),
      number("curve_points", &Identity::curve_points, "", 0, curve_pool_points,
             "shared by all curves of a scene"),
      number("control_period_ns", &Identity::control_period_ns, "ns", min_control_period_ns,
             max_control_period_ns, "length of a tick"),
      number("counts_per_rev", &Identity::counts_per_rev, "", 4, 1U << 24, "of the encoder"),
      number("torque_step_nm", &Identity::torque_step_nm, "N m", 1e-9F, 1,
             "resolution of telemetry's torques"),
      number("speed_step_rad_s", &Identity::speed_step_rad_s, "rad/s", 1e-9F, 100,
             "resolution of telemetry's speed"),
  };
};

/// The device's time and position in full. Read only.
struct Clock {
  std::uint64_t tick = 0;
  std::uint64_t time_ns = 0;
  std::int64_t position_counts = 0;
};
template <>
struct Layout<Clock> {
  static constexpr std::uint8_t id = 0x02;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "clock";
  static constexpr std::string_view doc = "The device's time and position in full. Read only.";
  static constexpr FieldList fields{
      number("tick", &Clock::tick, "", 0, std::uint64_t{1} << 62, "control periods since power-up"),
      number("time_ns", &Clock::time_ns, "ns", 0, std::uint64_t{1} << 62,
             "tick times the control period"),
      number("position_counts", &Clock::position_counts, "count", std::int64_t{-1} << 62,
             std::int64_t{1} << 62, "from the device's zero, never wraps"),
  };
};

/// State and counters since power-up. Read only.
struct Health {
  State state = State::disarmed;
  std::uint16_t faults = 0;
  std::uint32_t reports_accepted = 0;
  std::uint32_t reports_refused = 0;
  std::uint32_t samples_dropped = 0;
  std::uint32_t tick_overruns = 0;
  std::uint32_t tick_time_ns = 0;
  std::uint32_t tick_time_max_ns = 0;
  std::uint32_t saves = 0;
  Owner owner = Owner::none;
  ResetCause reset_cause = ResetCause::unknown;
  std::uint32_t unexpected_swings = 0;
  Centre centre = Centre::power_up;
};
template <>
struct Layout<Health> {
  static constexpr std::uint8_t id = 0x03;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "health";
  static constexpr std::string_view doc = "State and counters since power-up. Read only.";
  static constexpr FieldList fields{
      choice("state", &Health::state, "whether it makes torque"),
      any_number("faults", &Health::faults, "", "bits, see above"),
      any_number("reports_accepted", &Health::reports_accepted, "", "that did what they asked"),
      any_number("reports_refused", &Health::reports_refused, "", "that changed nothing"),
      any_number("samples_dropped", &Health::samples_dropped, "",
                 "telemetry that the host did not fetch in time"),
      any_number("tick_overruns", &Health::tick_overruns, "", "ticks that were missed"),
      any_number("tick_time_ns", &Health::tick_time_ns, "ns",
                 "time that the last control tick took"),
      any_number("tick_time_max_ns", &Health::tick_time_max_ns, "ns", "longest tick so far"),
      any_number("saves", &Health::saves, "", "how often the configuration was saved, ever"),
      choice("owner", &Health::owner, "owner of the actuator"),
      choice("reset_cause", &Health::reset_cause, "why the device started"),
      any_number(
          "unexpected_swings", &Health::unexpected_swings, "",
          "swings of the law `calibrated` that lasted in scenes which the configured parts can "
          "render, and four for a ring, since the knob was configured, less one for fifty turns"),
      choice("centre", &Health::centre, "where angle 0 comes from"),
  };
};

/// One effect of a game.
struct GameEffect {
  std::uint8_t block = 0;
  GameEffectKind kind = GameEffectKind::none;
  GameEffectState state = GameEffectState::stopped;
  std::int16_t torque = 0;
  std::uint32_t updates = 0;
  std::uint16_t silent_ms = 0;
};
template <>
struct Layout<GameEffect> {
  static constexpr std::string_view name = "game_effect";
  static constexpr std::string_view doc = "One effect of a game.";
  static constexpr FieldList fields{
      any_number("block", &GameEffect::block, "",
                 "its number, from 1; 0: an empty row of the report"),
      choice("kind", &GameEffect::kind, "its kind"),
      choice("state", &GameEffect::state, "whether it plays"),
      any_number("torque", &GameEffect::torque, "torque_step_nm",
                 "torque now, before the cap on all together"),
      any_number("updates", &GameEffect::updates, "", "reports about it since it was made"),
      any_number("silent_ms", &GameEffect::silent_ms, "ms",
                 "since the last of them; 65.535 s is that or longer"),
  };
};

/// Effects of games. Each reading shows the next of the effects, in turns. Read only.
struct GameMonitor {
  std::uint64_t tick = 0;
  Owner owner = Owner::none;
  Toggle paused = Toggle::off;
  Toggle enabled = Toggle::off;
  std::uint16_t gain = 0;
  std::int16_t torque = 0;
  std::uint32_t updates = 0;
  std::uint8_t effects = 0;
  std::uint32_t clipped_ticks = 0;
  std::uint16_t asked_percent = 0;
  std::array<GameEffect, game_effects_per_report> effect{};
};
template <>
struct Layout<GameMonitor> {
  static constexpr std::uint8_t id = 0x08;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "game_monitor";
  static constexpr std::string_view doc =
      "Effects of games. Each reading shows the next of the effects, in turns. Read only.";
  static constexpr FieldList fields{
      any_number("tick", &GameMonitor::tick, "", "of this moment"),
      choice("owner", &GameMonitor::owner, "owner of the actuator"),
      choice("paused", &GameMonitor::paused, "by the game"),
      choice("enabled", &GameMonitor::enabled, "the game wants the actuator on"),
      any_number("gain", &GameMonitor::gain, "1/32767",
                 "of the device, as the game set it, 0 to 1"),
      any_number("torque", &GameMonitor::torque, "torque_step_nm", "of all effects together"),
      any_number("updates", &GameMonitor::updates, "", "reports that games sent since power-up"),
      any_number("effects", &GameMonitor::effects, "", "that exist"),
      any_number("clipped_ticks", &GameMonitor::clipped_ticks, "",
                 "ticks in which effects asked for more than all together get, since power-up"),
      any_number("asked_percent", &GameMonitor::asked_percent, "",
                 "the most that effects asked for in the last half second, as a share of their "
                 "joint limit"),
      group("effect", &GameMonitor::effect, ""),
  };
};

/// The energy that motor and shaft have given to the knob since the law began to count. The numbers
/// are whole and lose nothing; `energies()` makes joules of them. Read only.
struct Ledger {
  std::uint64_t tick = 0;
  Toggle kept = Toggle::off;
  std::int64_t motor = 0;
  std::int64_t spring_twice = 0;
  std::int32_t spring = 0;
  float stored_j = 0;
  float bound_nm_per_rad = 0;
};
template <>
struct Layout<Ledger> {
  static constexpr std::uint8_t id = 0x09;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "ledger";
  static constexpr std::string_view doc =
      "The energy that motor and shaft have given to the knob since the law began to count. The "
      "numbers are whole and lose nothing; `energies()` makes joules of them. Read only.";
  static constexpr FieldList fields{
      any_number("tick", &Ledger::tick, "", "of this moment: control periods since power-up"),
      choice("kept", &Ledger::kept, "the law keeps count; else all stand still"),
      any_number(
          "motor", &Ledger::motor, "",
          "given to the knob by the motor: its command in 2^-23 N m, times the counts it moved"),
      any_number("spring_twice", &Ledger::spring_twice, "",
                 "given to the knob by the shaft's spring, twice the same"),
      any_number("spring", &Ledger::spring, "2^-23 N m", "that spring's torque on the knob now"),
      any_number("stored_j", &Ledger::stored_j, "J", "in the shaft's spring now"),
      any_number(
          "bound_nm_per_rad", &Ledger::bound_nm_per_rad, "N m/rad",
          "the stiffest that is rendered now, found out from the knob's swings; 0: no bound"),
  };
};

/// Sums over all periods of the current loop since the board started: readings of the motor's
/// current sensor and shares of its bridge. Read the report twice; the difference is what happened
/// between. Read only.
struct MotorCurrent {
  Toggle measured = Toggle::off;
  std::int64_t position_counts = 0;
  std::uint32_t period_ns = 0;
  std::uint32_t delay_ns = 0;
  std::uint64_t periods = 0;
  std::int64_t reading_sum = 0;
  std::int64_t share_sum = 0;
  std::int32_t reading = 0;
  std::int16_t share = 0;
  std::int16_t share_before = 0;
  float zero = 0;
  float a_per_step = 0;
  float a_per_nm = 0;
};
template <>
struct Layout<MotorCurrent> {
  static constexpr std::uint8_t id = 0x0C;
  static constexpr Direction direction = Direction::feature;
  static constexpr std::string_view name = "motor_current";
  static constexpr std::string_view doc =
      "Sums over all periods of the current loop since the board started: readings of the motor's "
      "current sensor and shares of its bridge. Read the report twice; the difference is what "
      "happened between. Read only.";
  static constexpr FieldList fields{
      choice("measured", &MotorCurrent::measured,
             "there is a current sensor; without one the other fields are 0"),
      number("position_counts", &MotorCurrent::position_counts, "count", std::int64_t{-1} << 62,
             std::int64_t{1} << 62, "at the newest tick"),
      any_number("period_ns", &MotorCurrent::period_ns, "ns", "of the current loop"),
      any_number("delay_ns", &MotorCurrent::delay_ns, "ns",
                 "from a measurement to the voltage that answers it"),
      number("periods", &MotorCurrent::periods, "", 0, std::uint64_t{1} << 62,
             "done, each with one measurement"),
      any_number("reading_sum", &MotorCurrent::reading_sum, "step",
                 "sum of the sensor's readings, one a period"),
      any_number("share_sum", &MotorCurrent::share_sum, "2^-14 of the supply",
                 "sum of all shares, positive to larger angles"),
      any_number("reading", &MotorCurrent::reading, "step", "newest reading"),
      any_number("share", &MotorCurrent::share, "2^-14 of the supply",
                 "share of the supply's voltage that answers it"),
      any_number("share_before", &MotorCurrent::share_before, "2^-14 of the supply",
                 "share before it"),
      any_number("zero", &MotorCurrent::zero, "step",
                 "reading without current, learnt while the power was off"),
      any_number("a_per_step", &MotorCurrent::a_per_step, "A",
                 "positive or negative, as the board was configured when it started"),
      any_number("a_per_nm", &MotorCurrent::a_per_nm, "A/(N m)",
                 "current asked of the motor for a torque"),
  };
};

/// An order without values.
struct Command {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  Op op = Op::keep_alive;
};
template <>
struct Layout<Command> {
  static constexpr std::uint8_t id = 0x10;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "command";
  static constexpr std::string_view doc = "An order without values.";
  static constexpr FieldList fields{
      any_number("sequence", &Command::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &Command::axis, "", "0: an interface has one axis"),
      choice("op", &Command::op, "the order"),
  };
};

/// Plays the whole scene as written from the next tick on. Slots written since the last commit
/// start anew, the others go on.
struct Commit {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  std::uint16_t active = 0;
};
template <>
struct Layout<Commit> {
  static constexpr std::uint8_t id = 0x11;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "commit";
  static constexpr std::string_view doc =
      "Plays the whole scene as written from the next tick on. Slots written since the last commit "
      "start anew, the others go on.";
  static constexpr FieldList fields{
      any_number("sequence", &Commit::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &Commit::axis, "", "0: an interface has one axis"),
      any_number("active", &Commit::active, "", "bit n: slot n plays"),
  };
};

/// Starts or stops telemetry.
struct Stream {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  std::uint8_t decimation = 0;
  Toggle prompt = Toggle::off;
};
template <>
struct Layout<Stream> {
  static constexpr std::uint8_t id = 0x12;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "stream";
  static constexpr std::string_view doc = "Starts or stops telemetry.";
  static constexpr FieldList fields{
      any_number("sequence", &Stream::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &Stream::axis, "", "0: an interface has one axis"),
      any_number("decimation", &Stream::decimation, "", "one sample every so many ticks; 0 stops"),
      choice("prompt", &Stream::prompt,
             "on: a report in every frame with the newest samples; off: full reports, a few frames "
             "later"),
  };
};

/// A torque, a spring and a damper that the device renders at its own rate, on top of the scene,
/// until the next one comes. A host that streams these renders stiff things without its own delay.
/// Only refusals are acknowledged. Past the deadline the device fails passive.
struct LocalModel {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  float torque_nm = 0;
  std::int64_t angle_turns_q32 = 0;
  float stiffness_nm_per_rad = 0;
  float damping_nm_s_per_rad = 0;
  float deadline_s = 0.02F;
};
template <>
struct Layout<LocalModel> {
  static constexpr std::uint8_t id = 0x13;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "local_model";
  static constexpr std::string_view doc =
      "A torque, a spring and a damper that the device renders at its own rate, on top of the "
      "scene, until the next one comes. A host that streams these renders stiff things without its "
      "own delay. Only refusals are acknowledged. Past the deadline the device fails passive.";
  static constexpr FieldList fields{
      any_number("sequence", &LocalModel::sequence, "",
                 "must be newer (modulo 2^16) than the last one"),
      any_number("axis", &LocalModel::axis, "", "0: an interface has one axis"),
      number("torque_nm", &LocalModel::torque_nm, "N m", -max_torque_nm, max_torque_nm,
             "at the reference, at rest"),
      number("angle_turns_q32", &LocalModel::angle_turns_q32, "2^-32 turn", -max_turns_q32,
             max_turns_q32, "reference position"),
      number("stiffness_nm_per_rad", &LocalModel::stiffness_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad, ""),
      number("damping_nm_s_per_rad", &LocalModel::damping_nm_s_per_rad, "N m s/rad", 0,
             max_damping_nm_s_per_rad, ""),
      number("deadline_s", &LocalModel::deadline_s, "s", 0, 60,
             "how long it holds; 0 ends the stream in good order"),
  };
};

/// A bounded experiment: commands of motor and brake that go past scene and law. Both commands move
/// in a straight line from where the last excitation is now. The motor also gets a sine and the
/// torque of a servo, `servo_stiffness (reference - angle) + servo_damping (reference' - speed)`.
/// The device disarms when a bound is left, or when the time is over and no next one has come. It
/// also disarms when the servo asks for all of the motor for 50 ms and the encoder stands still.
struct Excitation {
  std::uint16_t sequence = 0;
  std::uint8_t axis = 0;
  float duration_s = 0;
  float travel_rad = 0;
  float speed_limit_rad_s = 0;
  float torque_limit_nm = 0;
  float motor_command_nm = 0;
  float brake_command_nm = 0;
  float ramp_s = 0;
  float sine_nm = 0;
  float sine_begin_hz = 0;
  float sine_end_hz = 0;
  float stiffness_nm_per_rad = 0;
  float damping_nm_s_per_rad = 0;
  float servo_rad_s = 0;
};
template <>
struct Layout<Excitation> {
  static constexpr std::uint8_t id = 0x14;
  static constexpr Direction direction = Direction::output;
  static constexpr std::string_view name = "excitation";
  static constexpr std::string_view doc =
      "A bounded experiment: commands of motor and brake that go past scene and law. Both commands "
      "move in a straight line from where the last excitation is now. The motor also gets a sine "
      "and the torque of a servo, `servo_stiffness (reference - angle) + servo_damping (reference' "
      "- speed)`. The device disarms when a bound is left, or when the time is over and no next "
      "one has come. It also disarms when the servo asks for all of the motor for 50 ms and the "
      "encoder stands still.";
  static constexpr FieldList fields{
      any_number("sequence", &Excitation::sequence, "", "returned in the acknowledgement"),
      any_number("axis", &Excitation::axis, "", "0: an interface has one axis"),
      number("duration_s", &Excitation::duration_s, "s", 0.001F, 60,
             "until it disarms, unless the next one comes first"),
      number("travel_rad", &Excitation::travel_rad, "rad", 0.001F, 1000,
             "further from its first angle disarms"),
      number("speed_limit_rad_s", &Excitation::speed_limit_rad_s, "rad/s", 0.1F, 1e4F,
             "faster disarms"),
      number("torque_limit_nm", &Excitation::torque_limit_nm, "N m", 0, max_torque_nm,
             "largest torque of the motor"),
      number("motor_command_nm", &Excitation::motor_command_nm, "N m", -max_torque_nm,
             max_torque_nm, "where the motor goes"),
      number("brake_command_nm", &Excitation::brake_command_nm, "N m", 0, max_torque_nm,
             "where the brake's command goes"),
      number("ramp_s", &Excitation::ramp_s, "s", 0, 60, "time that both take; 0 is a step"),
      number("sine_nm", &Excitation::sine_nm, "N m", 0, max_torque_nm,
             "amplitude of the sine on top of `motor_command_nm`"),
      number("sine_begin_hz", &Excitation::sine_begin_hz, "Hz", 0, 1000,
             "its frequency at the beginning"),
      number("sine_end_hz", &Excitation::sine_end_hz, "Hz", 0, 1000, "and after `duration_s`"),
      number("stiffness_nm_per_rad", &Excitation::stiffness_nm_per_rad, "N m/rad", 0,
             max_stiffness_nm_per_rad, "of the servo"),
      number("damping_nm_s_per_rad", &Excitation::damping_nm_s_per_rad, "N m s/rad", 0,
             max_damping_nm_s_per_rad, "of the servo"),
      number("servo_rad_s", &Excitation::servo_rad_s, "rad/s", -1000, 1000,
             "speed of the servo's reference"),
  };
};

/// One moment of telemetry. Torques and speed are in the units that identity gives and hold at the
/// ends of the range.
struct Sample {
  std::int16_t offset_counts = 0;
  std::int16_t speed = 0;
  std::int16_t desired_torque = 0;
  std::int16_t motor_command = 0;
  std::int16_t brake_capacity = 0;
  std::int16_t spring_torque = 0;
};
template <>
struct Layout<Sample> {
  static constexpr std::string_view name = "sample";
  static constexpr std::string_view doc =
      "One moment of telemetry. Torques and speed are in the units that identity gives and hold at "
      "the ends of the range.";
  static constexpr FieldList fields{
      any_number("offset_counts", &Sample::offset_counts, "count", "position behind the base"),
      any_number("speed", &Sample::speed, "speed_step_rad_s", "estimated"),
      any_number("desired_torque", &Sample::desired_torque, "torque_step_nm",
                 "torque that the scene asks for"),
      any_number("motor_command", &Sample::motor_command, "torque_step_nm", "asked of the motor"),
      any_number("brake_capacity", &Sample::brake_capacity, "torque_step_nm",
                 "most that the brake can hold, estimated"),
      any_number("spring_torque", &Sample::spring_torque, "torque_step_nm",
                 "of the shaft on the knob, sensed"),
  };
};

/// Samples at equal distances. A gap between two reports shows in their ticks.
struct Telemetry {
  std::uint8_t axis_samples = 16;
  std::uint8_t decimation = 0;
  std::uint8_t flags = 0;
  std::uint64_t tick = 0;
  std::int32_t base_counts = 0;
  std::array<Sample, samples_per_report> sample{};
};
template <>
struct Layout<Telemetry> {
  static constexpr std::uint8_t id = 0x40;
  static constexpr Direction direction = Direction::input;
  static constexpr std::string_view name = "telemetry";
  static constexpr std::string_view doc =
      "Samples at equal distances. A gap between two reports shows in their ticks.";
  static constexpr FieldList fields{
      number("axis_samples", &Telemetry::axis_samples, "", 16, 79,
             "low four bits: axis, 0; high four bits: how many samples are filled"),
      any_number("decimation", &Telemetry::decimation, "", "ticks from one sample to the next"),
      any_number("flags", &Telemetry::flags, "", "bits, see above, of all samples together"),
      any_number("tick", &Telemetry::tick, "", "of the first sample"),
      any_number("base_counts", &Telemetry::base_counts, "count",
                 "low 32 bits of the first sample's position"),
      group("sample", &Telemetry::sample, ""),
  };
};

/// Answer to a report.
struct Acknowledgement {
  std::uint16_t sequence = 0;
  std::uint8_t report = 0;
  std::uint8_t status = 0;
  std::uint8_t field = kNoField;
  State state = State::disarmed;
  std::uint64_t tick = 0;
  Owner owner = Owner::none;
};
template <>
struct Layout<Acknowledgement> {
  static constexpr std::uint8_t id = 0x41;
  static constexpr Direction direction = Direction::input;
  static constexpr std::string_view name = "acknowledgement";
  static constexpr std::string_view doc = "Answer to a report.";
  static constexpr FieldList fields{
      any_number("sequence", &Acknowledgement::sequence, "", "of the report that is answered"),
      any_number("report", &Acknowledgement::report, "", "its id"),
      any_number("status", &Acknowledgement::status, "",
                 "0: accepted; otherwise the reason, see above"),
      any_number("field", &Acknowledgement::field, "",
                 "index of the offending field, nested fields opened; 255 is none"),
      choice("state", &Acknowledgement::state, "after the report"),
      any_number("tick", &Acknowledgement::tick, "", "when it took effect or was refused"),
      choice("owner", &Acknowledgement::owner, "owner of the actuator after the report"),
  };
};

/// Something that the host did not ask for.
struct Event {
  EventKind kind = EventKind::state_changed;
  State state = State::disarmed;
  std::uint16_t faults = 0;
  std::uint64_t tick = 0;
  Owner owner = Owner::none;
};
template <>
struct Layout<Event> {
  static constexpr std::uint8_t id = 0x42;
  static constexpr Direction direction = Direction::input;
  static constexpr std::string_view name = "event";
  static constexpr std::string_view doc = "Something that the host did not ask for.";
  static constexpr FieldList fields{
      choice("kind", &Event::kind, "kind of event"),
      choice("state", &Event::state, "after the event"),
      any_number("faults", &Event::faults, "", "bits, see above"),
      any_number("tick", &Event::tick, "", "when: control periods since power-up"),
      choice("owner", &Event::owner, "owner of the actuator after the event"),
  };
};

/// Every report, in the order of the documentation.
using AllReports =
    std::tuple<Identity, Clock, Health, ActuatorConfig, ControlConfig, BoardConfig, GameConfig,
               ShaftConfig, CalibrationConfig, GameMonitor, Ledger, MotorCurrent, Command, Commit,
               Stream, LocalModel, Excitation, Wall, Spring, Damper, Friction, Inertia, Constant,
               Ramp, Periodic, Detents, EndStops, Texture, Curve, Impact, CurvePoints, Telemetry,
               Acknowledgement, Event>;

// The sizes as literals: a change of the wire must be seen in a diff.
static_assert(wire_size<Identity>() == 46);
static_assert(wire_size<Clock>() == 24);
static_assert(wire_size<Health>() == 38);
static_assert(wire_size<GameMonitor>() == 59);
static_assert(wire_size<Ledger>() == 37);
static_assert(wire_size<MotorCurrent>() == 61);
static_assert(wire_size<Command>() == 4);
static_assert(wire_size<Commit>() == 5);
static_assert(wire_size<Stream>() == 5);
static_assert(wire_size<LocalModel>() == 27);
static_assert(wire_size<Excitation>() == 55);
static_assert(wire_size<Telemetry>() == 63);
static_assert(wire_size<Acknowledgement>() == 15);
static_assert(wire_size<Event>() == 13);

}  // namespace torsio::protocol
