/// @file
/// Every enumeration and every set of bits that travels.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "protocol/layout.hpp"

namespace torsio::protocol {

enum class Toggle : std::uint8_t { off, on };
template <>
struct Enumerators<Toggle> {
  static constexpr std::array<std::string_view, 2> names{"off", "on"};
  static constexpr bool open = false;
};

/// On which side of its surface a wall is solid.
enum class Side : std::uint8_t { above, below };
template <>
struct Enumerators<Side> {
  static constexpr std::array<std::string_view, 2> names{"above", "below"};
  static constexpr bool open = false;
};

/// Shape of a periodic torque.
enum class Waveform : std::uint8_t { sine, square, triangle, sawtooth_up, sawtooth_down };
template <>
struct Enumerators<Waveform> {
  static constexpr std::array<std::string_view, 5> names{"sine", "square", "triangle",
                                                         "sawtooth_up", "sawtooth_down"};
  static constexpr bool open = false;
};

/// Torque from one notch to the next: -T sin(2 pi u) at u pitches from a notch; -2 T u within half
/// a pitch; or linear within the width, beyond it T toward the notch.
enum class DetentProfile : std::uint8_t { sine, linear, click };
template <>
struct Enumerators<DetentProfile> {
  static constexpr std::array<std::string_view, 3> names{"sine", "linear", "click"};
  static constexpr bool open = false;
};

/// Shape of a texture's grains; noise draws a value for each and joins them smoothly.
enum class Grain : std::uint8_t { sine, square, triangle, noise };
template <>
struct Enumerators<Grain> {
  static constexpr std::array<std::string_view, 4> names{"sine", "square", "triangle", "noise"};
  static constexpr bool open = false;
};

/// A curve's torque outside its span.
enum class Ends : std::uint8_t { hold, repeat };
template <>
struct Enumerators<Ends> {
  static constexpr std::array<std::string_view, 2> names{"hold", "repeat"};
  static constexpr bool open = false;
};

/// How the desired torque is shared between motor and brake; docs/explanation/theory.md.
enum class Law : std::uint8_t {
  paper,        // the printed law, as it must be read
  compensated,  // the motor fills in what the brake does not hold, with its drag counted
  parallel,     // fixed shares without the sensor: it sticks, and is here to show that
  motor_only,   // no brake
  calibrated,   // as compensated, with a stiffness that is bounded by the parts
};
template <>
struct Enumerators<Law> {
  static constexpr std::array<std::string_view, 5> names{"paper", "compensated", "parallel",
                                                         "motor_only", "calibrated"};
  static constexpr bool open = false;
};

/// On what the values of actuator and shaft are based.
enum class Basis : std::uint8_t {
  assumed,   // on data sheets, or a value was changed since
  stated,    // on the word of a user who answers for them
  measured,  // on a calibration
};
template <>
struct Enumerators<Basis> {
  static constexpr std::array<std::string_view, 3> names{"assumed", "stated", "measured"};
  static constexpr bool open = false;
};

/// The second interface, as the computer sees it.
enum class Personality : std::uint8_t {
  game_controller,  // a joystick's axis with force feedback
  dial,             // a wheel of the desktop, with detents
};
template <>
struct Enumerators<Personality> {
  static constexpr std::array<std::string_view, 2> names{"game_controller", "dial"};
  static constexpr bool open = false;
};

/// Effect of a dial: clockwise, to larger angles, is down, right or louder.
enum class DialUse : std::uint8_t {
  wheel,            // scrolls, in 120 steps a detent where the system can
  pan,              // scrolls sideways, as finely
  volume,           // a key press for each detent
  radial,           // turns Windows' radial controller; the first button is the controller's
  wheel_or_pan,     // scrolls; sideways while the first button is pressed
  wheel_or_volume,  // scrolls; presses the keys while the first button is pressed
  volume_or_wheel,  // presses the keys; scrolls while the first button is pressed
};
template <>
struct Enumerators<DialUse> {
  static constexpr std::array<std::string_view, 7> names{
      "wheel", "pan", "volume", "radial", "wheel_or_pan", "wheel_or_volume", "volume_or_wheel"};
  static constexpr bool open = false;
};

/// Whether the device makes torque.
enum class State : std::uint8_t {
  disarmed,  // no torque
  armed,     // the scene acts
  fault,     // no torque until the fault is cleared
};
template <>
struct Enumerators<State> {
  static constexpr std::array<std::string_view, 3> names{"disarmed", "armed", "fault"};
  static constexpr bool open = false;
};

/// Owner of the actuator: none unless it is armed.
enum class Owner : std::uint8_t { none, sdk, game, dial };
template <>
struct Enumerators<Owner> {
  static constexpr std::array<std::string_view, 4> names{"none", "sdk", "game", "dial"};
  static constexpr bool open = false;
};

/// Kind of a game's effect.
enum class GameEffectKind : std::uint8_t {
  none,
  constant,
  ramp,
  square,
  sine,
  triangle,
  sawtooth_up,
  sawtooth_down,
  spring,
  damper,
  inertia,
  friction
};
template <>
struct Enumerators<GameEffectKind> {
  static constexpr std::array<std::string_view, 12> names{
      "none",        "constant",      "ramp",   "square", "sine",    "triangle",
      "sawtooth_up", "sawtooth_down", "spring", "damper", "inertia", "friction"};
  static constexpr bool open = false;
};

/// Whether a game's effect plays.
enum class GameEffectState : std::uint8_t {
  stopped,    // never started, stopped by the game, or at its end
  playing,    // it plays, or waits for its delay
  set_aside,  // ended by the device: the game's next update brings it back
};
template <>
struct Enumerators<GameEffectState> {
  static constexpr std::array<std::string_view, 3> names{"stopped", "playing", "set_aside"};
  static constexpr bool open = false;
};

/// Why the device started.
enum class ResetCause : std::uint8_t {
  unknown,     // the board cannot tell
  power,       // it was switched on
  brown_out,   // its supply was too low for a moment
  reset_pin,   // somebody pressed reset
  watchdog,    // the main loop or the control interrupt hung
  hard_fault,  // the program did what the processor refuses
  stack,       // the program needed more stack than there is
};
template <>
struct Enumerators<ResetCause> {
  static constexpr std::array<std::string_view, 7> names{
      "unknown", "power", "brown_out", "reset_pin", "watchdog", "hard_fault", "stack"};
  static constexpr bool open = false;
};

/// Where angle 0 comes from.
enum class Centre : std::uint8_t {
  power_up,      // the knob's place at power-up, or at the last zero; there is no index
  awaits_index,  // the same, until a slow turn has passed the index twice
  index,         // the encoder's index: a save keeps angle 0 over power cycles
};
template <>
struct Enumerators<Centre> {
  static constexpr std::array<std::string_view, 3> names{"power_up", "awaits_index", "index"};
  static constexpr bool open = false;
};

/// Command: what the host asks the device to do.
enum class Op : std::uint8_t {
  keep_alive,  // nothing but a sign of life, not acknowledged
  arm,
  disarm,
  stop,           // disarm and empty the scene
  zero,           // this position becomes angle 0; only while disarmed
  relax,          // the shaft's spring is known to be relaxed now; only while disarmed
  save,           // keep the configuration; only while disarmed
  load_defaults,  // configuration of a new device; only while disarmed
  clear_fault,
  bootloader,  // wait for new firmware, nobody can arm after it; only while disarmed
};
template <>
struct Enumerators<Op> {
  static constexpr std::array<std::string_view, 10> names{
      "keep_alive", "arm",  "disarm",        "stop",        "zero",
      "relax",      "save", "load_defaults", "clear_fault", "bootloader"};
  static constexpr bool open = false;
};

/// Kind of an event.
enum class EventKind : std::uint8_t {
  state_changed,       // by an order, a fault or the end of a soft stop
  watchdog,            // the host was silent for too long
  deadline_missed,     // a streamed local model outlived its deadline
  owner_changed,       // somebody else has the actuator now
  excitation_over,     // the time of an excitation was over
  excitation_stopped,  // an excitation left its bounds of travel or speed
};
template <>
struct Enumerators<EventKind> {
  static constexpr std::array<std::string_view, 6> names{"state_changed",   "watchdog",
                                                         "deadline_missed", "owner_changed",
                                                         "excitation_over", "excitation_stopped"};
  static constexpr bool open = true;
};

/// Why a report was refused. The device sends the code, the library turns it into a sentence.
enum class [[nodiscard]] Status : std::uint8_t {
  ok,              // accepted
  bad_length,      // not exactly 64 bytes
  bad_padding,     // bytes behind the last field are not zero: a newer layout, or garbage
  unknown_report,  // no report of this id in this direction
  not_finite,      // a number is not finite
  out_of_range,    // a value is outside the range given below, or beyond what this encoder or rate
                   // can do
  inconsistent,    // each field is in range, but not together
  bad_axis,        // the device has no such axis
  empty_slot,      // a commit names a slot that was never written
  not_armed,       // only while armed
  not_disarmed,    // only while disarmed
  fault_latched,   // a fault must be cleared first
  fault_persists,  // the cause of the fault is still there
  stale,           // older than what the device already has
  busy,            // cannot be taken now; try again
  not_owner,       // somebody else owns the actuator
  unsupported,     // this board cannot do it
};
template <>
struct Enumerators<Status> {
  static constexpr std::array<std::string_view, 17> names{
      "ok",           "bad_length",    "bad_padding",    "unknown_report", "not_finite",
      "out_of_range", "inconsistent",  "bad_axis",       "empty_slot",     "not_armed",
      "not_disarmed", "fault_latched", "fault_persists", "stale",          "busy",
      "not_owner",    "unsupported"};
  /// For the user whom it stops.
  static constexpr std::array<std::string_view, 17> advice{
      "accepted",
      "the report has the wrong length; it was damaged on the way",
      "the report has bytes too many; it was damaged on the way",
      "the device does not know this report",
      "a value is not a finite number",
      "a value is outside the range that docs/reference/protocol.md gives",
      "the values do not fit each other",
      "the device has no such axis",
      "the scene names a slot that was never written",
      "the device must be armed for this: call arm() first",
      "the device must be disarmed for this: call disarm() first",
      "a fault is latched: faults() names it, clear_fault() clears it once its cause is gone",
      "the cause of the fault is still there: faults() names it",
      "the device already has something newer",
      "the device has no room for it now: send it again",
      "somebody else owns the actuator now",
      "this board cannot do it"};
  static constexpr bool open = true;
};

/// Faults, latched until cleared: bits of every `faults` field.
namespace fault {
inline constexpr std::uint16_t emergency_stop = 1 << 0;  // the input is open or pressed
inline constexpr std::uint16_t over_speed = 1 << 1;      // faster than speed_limit_rad_s
inline constexpr std::uint16_t encoder = 1 << 2;   // a jump, a dead channel, or two changes at once
inline constexpr std::uint16_t actuator = 1 << 3;  // the power stage reports an error
inline constexpr std::uint16_t overrun = 1 << 4;   // ticks were missed or took too long
inline constexpr std::uint16_t numeric = 1 << 5;   // the control law gave no finite torque
inline constexpr std::uint16_t current_sensor = 1
                                                << 6;  // its zero leaves no room for the trip level
inline constexpr std::uint16_t winding = 1 << 7;  // voltage, current and speed do not fit together
inline constexpr std::uint16_t temperature =
    1 << 8;  // the motor's winding or the brake's coil is too hot, computed from its current
inline constexpr std::uint16_t supply =
    1 << 9;  // the measured voltage of the supply is not the configured one
inline constexpr std::array<std::string_view, 10> names{
    "emergency_stop", "over_speed",     "encoder", "actuator",    "overrun",
    "numeric",        "current_sensor", "winding", "temperature", "supply"};  // from bit 0 on
}  // namespace fault

/// Bits of telemetry's `flags`; the two lowest are the state.
namespace flag {
inline constexpr std::uint8_t state_mask = 0x3;          // the state
inline constexpr std::uint8_t motor_saturated = 1 << 2;  // the motor gives all it can
inline constexpr std::uint8_t brake_saturated = 1 << 3;  // the brake holds all it can
inline constexpr std::uint8_t local_model = 1 << 4;      // a streamed local model is in force
inline constexpr std::uint8_t passive = 1 << 5;          // fading out after silence or a deadline
inline constexpr std::uint8_t game = 1 << 6;             // a game has the actuator
inline constexpr std::uint8_t bounded =
    1 << 7;  // less than the scene asks, so that the knob does not buzz
inline constexpr std::array<std::string_view, 6> names{
    "motor_saturated", "brake_saturated", "local_model", "passive", "game",
    "bounded"};  // from bit 2 on
}  // namespace flag

}  // namespace torsio::protocol
