/// @file
/// The device's reports about itself.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace torsio {

/// Whether the device makes torque.
enum class State : std::uint8_t {
  disarmed,      ///< no torque
  armed,         ///< the scene acts
  fault,         ///< no torque until the fault is cleared
  disconnected,  ///< the device is unplugged, or does not answer any more
};

/// Owner of the actuator: none unless it is armed.
enum class Owner : std::uint8_t { none, sdk, game, dial };

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

/// Whether a game's effect plays.
enum class GameEffectState : std::uint8_t {
  stopped,    ///< never started, stopped by the game, or at its end
  playing,    ///< it plays, or waits for its delay
  set_aside,  ///< ended by the device: the game's next update brings it back
};

/// Why the device started.
enum class ResetCause : std::uint8_t {
  unknown,     ///< the board cannot tell
  power,       ///< it was switched on
  brown_out,   ///< its supply was too low for a moment
  reset_pin,   ///< somebody pressed reset
  watchdog,    ///< the main loop or the control interrupt hung
  hard_fault,  ///< the program did what the processor refuses
  stack,       ///< the program needed more stack than there is
};

/// Where angle 0 comes from.
enum class Centre : std::uint8_t {
  power_up,      ///< the knob's place at power-up, or at the last zero; there is no index
  awaits_index,  ///< the same, until a slow turn has passed the index twice
  index,         ///< the encoder's index: a save keeps angle 0 over power cycles
};

/// Why the torque went.
enum class DisarmReason : std::uint8_t {
  order,               ///< a program called disarm() or stop()
  watchdog,            ///< the host was silent for too long, or the bus was lost
  deadline_missed,     ///< a streamed local model outlived its deadline
  fault,               ///< a fault was latched
  game_idle,           ///< a game had the actuator and has nothing more to play
  disconnected,        ///< the device was unplugged or lost its power
  unknown,             ///< the device's message was lost on the way
  excitation_over,     ///< the time of an excitation was over and no next one had come
  excitation_stopped,  ///< an excitation left its bounds of travel or speed
  dial_idle,           ///< the dial had the actuator and nobody turns it
};

/// Bits of telemetry's `flags`; the two lowest are the state.
namespace flag {
inline constexpr std::uint8_t state_mask = 0x3;          ///< the state
inline constexpr std::uint8_t motor_saturated = 1 << 2;  ///< the motor gives all it can
inline constexpr std::uint8_t brake_saturated = 1 << 3;  ///< the brake holds all it can
inline constexpr std::uint8_t local_model = 1 << 4;      ///< a streamed local model is in force
inline constexpr std::uint8_t passive = 1 << 5;          ///< fading out after silence or a deadline
inline constexpr std::uint8_t game = 1 << 6;             ///< a game has the actuator
inline constexpr std::uint8_t bounded =
    1 << 7;  ///< less than the scene asks, so that the knob does not buzz
}  // namespace flag

/// One moment of the control loop. Torques are on the knob.
struct TelemetrySample {
  std::uint64_t tick;            ///< control periods since power-up
  double time_s;                 ///< tick times the control period
  std::int64_t position_counts;  ///< from the device's zero, never wraps
  double angle_rad;              ///< the same as an angle
  float speed_rad_s;             ///< estimated
  float desired_torque_nm;       ///< torque that the scene asks for
  float motor_command_nm;        ///< asked of the motor
  float brake_capacity_nm;       ///< most that the brake can hold, estimated
  float spring_torque_nm;        ///< of the shaft on the knob, sensed
  std::uint8_t flags;            ///< of this sample or a neighbour in the same report

  friend bool operator==(const TelemetrySample&, const TelemetrySample&) = default;
};

/// A device that could be opened.
struct ListedDevice {
  std::string path{};       ///< path for open()
  std::string serial{};     ///< serial number
  std::string product{};    ///< as its maker calls it
  std::string board{};      ///< empty if the device could not be asked
  std::string transport{};  ///< "hid" or "emulated"
  std::string problem{};    ///< why it cannot be opened now; empty if it can

  friend bool operator==(const ListedDevice&, const ListedDevice&) = default;
};

/// Identity and abilities of the device.
struct DeviceInfo {
  std::string path{};              ///< path for open()
  std::string serial{};            ///< serial number
  std::string product{};           ///< as its maker calls it
  std::string board{};             ///< "pico2", "emulated", ...
  std::string firmware_version{};  ///< "major.minor.patch"
  std::string transport{};  ///< "hid", "emulated" or "own", a transport that the program brings
  std::uint16_t protocol_version = 0;  ///< of the reports
  std::uint32_t fingerprint = 0;       ///< of the report layouts, the same as the library's
  int axes = 0;                        ///< actuators behind this interface
  int effects = 0;                     ///< places in a scene
  int curve_points = 0;                ///< shared by all curves of a scene
  double control_rate_hz = 0.0;        ///< ticks in a second
  std::uint32_t counts_per_rev = 0;    ///< of the encoder
  double torque_step_nm = 0.0;         ///< resolution of telemetry's torques
  double speed_step_rad_s = 0.0;       ///< resolution of telemetry's speed
};

/// The device's time and position, both exact.
struct Clock {
  std::uint64_t tick = 0;            ///< control periods since power-up
  double time_s = 0.0;               ///< tick times the control period
  std::int64_t position_counts = 0;  ///< from the device's zero, never wraps
  double angle_rad = 0.0;            ///< the same as an angle
};

/// State and counters of the device since its power-up.
struct Health {
  State state = State::disarmed;                 ///< whether it makes torque
  std::vector<std::string> faults{};             ///< names of the latched faults: "over_speed", ...
  std::uint32_t reports_accepted = 0;            ///< that did what they asked
  std::uint32_t reports_refused = 0;             ///< that changed nothing
  std::uint32_t samples_dropped = 0;             ///< telemetry that the host did not fetch in time
  std::uint32_t tick_overruns = 0;               ///< ticks that were missed
  double tick_time_s = 0.0;                      ///< time that the last control tick took
  double tick_time_max_s = 0.0;                  ///< longest tick so far
  std::uint32_t saves = 0;                       ///< how often the configuration was saved, ever
  Owner owner = Owner::none;                     ///< owner of the actuator
  ResetCause reset_cause = ResetCause::unknown;  ///< why the device started
  /// swings of the law `calibrated` that lasted in scenes which the configured parts can render,
  /// and four for a ring, since the knob was configured, less one for fifty turns
  std::uint32_t unexpected_swings = 0;
  Centre centre = Centre::power_up;  ///< where angle 0 comes from
};

/// Energies that the law `calibrated` has counted since it was chosen. The hand feels the motor's
/// energy, the shaft stores it, or the brake takes it.
struct Energies {
  std::uint64_t tick = 0;  ///< of this moment: control periods since power-up
  double time_s = 0.0;     ///< tick times the control period
  bool kept = false;       ///< the law keeps count; else all stand still
  double motor_j = 0.0;    ///< given to the knob by the motor
  double felt_j = 0.0;     ///< given to the knob by motor and shaft together, which a hand feels
  double stored_j = 0.0;   ///< in the shaft's spring now
  double brake_j = 0.0;    ///< taken by the brake
  /// the stiffest that is rendered now, found out from the knob's swings; 0: no bound
  double bound_nm_per_rad = 0.0;

  friend bool operator==(const Energies&, const Energies&) = default;
};

/// Sums of the motor's current readings and of its bridge's shares since the board started. The
/// difference of two readings covers everything in between.
struct MotorCurrent {
  bool measured = false;       ///< there is a current sensor; without one the other fields are 0
  double time_s = 0.0;         ///< periods of the current loop since the board started
  double angle_rad = 0.0;      ///< at the newest tick
  double period_s = 0.0;       ///< of the current loop
  double delay_s = 0.0;        ///< from a measurement to the voltage that answers it
  std::uint64_t periods = 0;   ///< done, each with one measurement
  double current_a = 0.0;      ///< the newest measurement, without its zero
  double zero_a = 0.0;         ///< reading without current
  double step_a = 0.0;         ///< of the converter
  double current_sum_a = 0.0;  ///< of all measurements, each with its zero
  double share = 0.0;          ///< share of the supply's voltage that answers it
  double share_before = 0.0;   ///< share before it
  double share_sum = 0.0;      ///< sum of all shares, positive to larger angles
  /// that the board reckons with: what it was configured to when it started
  double torque_constant_nm_per_a = 0.0;

  friend bool operator==(const MotorCurrent&, const MotorCurrent&) = default;
};

/// The most that the device gives, by its configuration as it is now.
struct Limits {
  double motor_torque_max_nm = 0.0;             ///< of the motor, for seconds
  double motor_torque_continuous_max_nm = 0.0;  ///< the same for ever, as its winding stands it
  double brake_torque_max_nm = 0.0;             ///< of the brake
  double speed_limit_rad_s = 0.0;               ///< more is a fault; 0: no limit
  /// the board gives little, because nobody has confirmed its parts, or because their values are
  /// assumed; `confirmed` and a calibration end it
  bool held_low = false;
};

/// How stiff a spring can be that a knob swings in and still comes to rest.
struct StableStiffness {
  double stiffness_nm_per_rad = 0.0;  ///< the stiffest such spring
  /// the limit to improve: "rate" of the control, "lag" of the motor, "counts" of the encoder
  std::string limited_by{};

  friend bool operator==(const StableStiffness&, const StableStiffness&) = default;
};

/// Effects of games on the device.
struct GameStatus {
  double time_s = 0.0;        ///< of this moment: the device's tick times the control period
  Owner owner = Owner::none;  ///< owner of the actuator
  bool paused = false;        ///< by the game
  bool enabled = false;       ///< the game wants the actuator on
  double gain = 0.0;          ///< of the device, as the game set it, 0 to 1
  double torque_nm = 0.0;     ///< of all effects together
  std::uint32_t updates = 0;  ///< reports that games sent since power-up
  int effects = 0;            ///< that exist
  /// ticks in which effects asked for more than all together get, since power-up
  std::uint32_t clipped_ticks = 0;
  /// the most that effects asked for in the last half second, as a share of their joint limit
  int asked_percent = 0;
};

/// One effect that a game has made.
struct GameEffect {
  int block = 0;  ///< its number, from 1; 0: an empty row of the report
  GameEffectKind kind = GameEffectKind::none;        ///< its kind
  GameEffectState state = GameEffectState::stopped;  ///< whether it plays
  double torque_nm = 0.0;                            ///< torque now, before the cap on all together
  std::uint32_t updates = 0;                         ///< reports about it since it was made
  double silent_s = 0.0;  ///< since the last of them; 65.535 s is that or longer
};

/// Counters of this end of the cable, since the knob was opened.
struct LinkStatistics {
  std::uint64_t reports_sent = 0;          ///< to the device
  std::uint64_t reports_received = 0;      ///< from the device
  std::uint64_t reports_undecodable = 0;   ///< damaged on the way, and ignored
  std::uint64_t samples_received = 0;      ///< of telemetry
  std::uint64_t samples_lost = 0;          ///< never arrived, or not read before the ring was full
  std::uint64_t events_lost = 0;           ///< not taken before there were 1,024 of them
  std::uint64_t local_models_refused = 0;  ///< by the device
  std::string last_refusal{};              ///< of a local model, in words
};

/// Something that the device did without being asked, or that somebody else asked for.
struct Event {
  std::string kind{};  ///< kind of event: "state_changed", "watchdog", "deadline_missed", ...
  State state = State::disarmed;      ///< after the event
  Owner owner = Owner::none;          ///< owner of the actuator after the event
  std::vector<std::string> faults{};  ///< names of the faults that are latched after it
  std::uint64_t tick = 0;             ///< when: control periods since power-up
  double time_s = 0.0;                ///< tick times the control period

  friend bool operator==(const Event&, const Event&) = default;
};

/// How the torque went the last time.
struct Disarm {
  DisarmReason reason = DisarmReason::order;  ///< why it went
  std::vector<std::string> faults{};          ///< names of the faults that were latched then
  std::uint64_t tick = 0;                     ///< when: control periods since power-up
  double time_s = 0.0;                        ///< tick times the control period

  friend bool operator==(const Disarm&, const Disarm&) = default;
};

}  // namespace torsio
