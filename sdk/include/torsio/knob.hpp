/// @file
/// The knob: find it, open it, arm it, play scenes on it, record what happens.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "torsio/config.hpp"
#include "torsio/emulator.hpp"
#include "torsio/error.hpp"
#include "torsio/export.hpp"
#include "torsio/knob_configurations.hpp"
#include "torsio/scene.hpp"
#include "torsio/telemetry.hpp"
#include "torsio/transport.hpp"

namespace torsio {

struct Connection;
class Session;

/// Result of record(): samples, and whether the torque was there all the time.
struct TelemetryRecord : std::vector<TelemetrySample> {
  using std::vector<TelemetrySample>::vector;
  /// How the torque went during the recording, if it did.
  std::optional<Disarm> disarmed{};
  /// It begins without torque and ends armed.
  bool armed_late = false;
  /// Earlier samples that nobody had read. They cannot be read any more.
  std::vector<TelemetrySample> unread_before{};
};

/// A step of a program's own loop; see Knob::every().
struct Step {
  std::uint64_t index = 0;       ///< 0, 1, 2, ... without a gap, also when steps were late
  double time_s = 0.0;           ///< when it was due, since the loop began
  std::uint64_t late_steps = 0;  ///< steps left out so far, because they were overdue
};

/// Steps at equal distances of time, made by Knob::every(); for as long as its knob lives.
class TORSIO_EXPORT Steps {
 public:
  /// Waits for the next step. @throws Closed, Disconnected, Interrupted
  Step wait();

  /// For a loop that only `break` or an exception ends.
  class Iterator {
   public:
    explicit Iterator(Steps& steps) : steps_(&steps) {}  ///< see begin()
    Step operator*() const { return steps_->wait(); }    ///< as wait()
    Iterator& operator++() { return *this; }             ///< the next one is asked for by `*`
    bool operator==(std::default_sentinel_t) const { return false; }  ///< it has no end

   private:
    Steps* steps_;
  };
  Iterator begin() { return Iterator(*this); }         ///< for `for`
  static std::default_sentinel_t end() { return {}; }  ///< for `for`

 private:
  friend class Knob;
  Steps(Session& session, std::int64_t period_ns) : session_(&session), period_ns_(period_ns) {}

  Session* session_;
  std::int64_t period_ns_;
  std::optional<std::int64_t> begin_ns_;
  std::int64_t due_ns_ = 0;
  Step next_;
};

/// All knobs that are plugged in, and the emulated one, which is always last, if this build has it.
[[nodiscard]] TORSIO_EXPORT std::vector<ListedDevice> list_devices();

/// How a knob is opened.
struct OpenOptions {
  /// Options of an emulated knob. With a selector that means real hardware they are an error.
  std::optional<EmulatorOptions> emulator{};
  double command_timeout_s = 1.0;  ///< longest wait for an answer of the device
  /// Telemetry kept until it is read; the oldest goes first. 1 to 2^24, 64 bytes each.
  std::size_t ring_samples = 65536;
  /// Asked at least every 20 ms of real time in every call that waits, in the thread that waits. If
  /// it returns true the call throws Interrupted. An exception of its own leaves the call
  /// unchanged. It may stop(), disarm() and close() the knob, and nothing else of it.
  std::function<bool()> interrupted{};
};

/// Opens a device as Knob::open() does, but asks it nothing: for your own transport that adds to
/// it.
/// @param options of these only `emulator`
/// @throws DeviceNotFound, PermissionDenied, DeviceBusy, InvalidArgument
[[nodiscard]] TORSIO_EXPORT std::unique_ptr<Transport> open_transport(
    std::string_view selector = {}, const OpenOptions& options = {});

/// Disarms a device and has it wait for new firmware, as a drive of its boot loader. It stays there
/// until a file was copied onto the drive or it was unplugged. This also works for devices of other
/// releases.
/// @param options of these `emulator`, `command_timeout_s` and `interrupted`
/// @throws Refused (unsupported: it has no boot loader, like an emulated one); as Knob::open(),
/// except ProtocolMismatch; Timeout
TORSIO_EXPORT void start_bootloader(std::string_view selector = {},
                                    const OpenOptions& options = {});

/// An open knob. Movable, not copyable.
///
/// You may call every member from any thread. Do not move or destroy the knob while another thread
/// is in a call. close() is safe at any time and makes waiting calls throw Closed. Members that
/// talk to the device also throw Disconnected once it is unplugged, Timeout without an answer
/// within `command_timeout_s`, and Interrupted; after close() all but close() and is_open() throw
/// Closed.
///
/// Time-outs and durations count in the device's time: the wall clock, or the virtual clock of an
/// emulated device that is not paced.
class TORSIO_EXPORT Knob : public KnobConfigurations {
 public:
  /// Opens a device. It is as it was left: call state() to see whether it is armed.
  /// @param selector path, serial number, "emulated", "emulated:NAME", or empty for the only real
  ///        device. A named emulated device keeps its saved configuration while the process lives.
  /// @throws DeviceNotFound, PermissionDenied, DeviceBusy, ProtocolMismatch; InvalidArgument, also
  ///         for emulator options if the selector means no emulated knob
  [[nodiscard]] static Knob open(std::string_view selector = {}, const OpenOptions& options = {});

  /// Makes a knob of a device that is reached in the user's own way. Its DeviceInfo has no path and
  /// no product, and there is no emulator().
  /// @throws InvalidArgument if there is no transport, or for emulator options; ProtocolMismatch,
  ///         Error, and what the transport throws
  [[nodiscard]] static Knob open(std::unique_ptr<Transport> transport,
                                 const OpenOptions& options = {});

  Knob(Knob&&) noexcept;             ///< the one that is moved from is closed then
  Knob& operator=(Knob&&) noexcept;  ///< the same; what it had is closed first
  ~Knob();                           ///< as close()

  /// Disarms, unless the device was told to be autonomous or a game or the dial has the actuator,
  /// and lets go of it. May be called twice.
  /// @returns false, once, if the transport did not take the order; the watchdog disarms then
  bool close() noexcept;
  /// The first that close() does: disarms, unless as above. Use it if you must finish files before
  /// you close.
  void disarm_to_close() noexcept;
  [[nodiscard]] bool is_open() const noexcept;  ///< false from close() on

  // State -------------------------------------------------------------------------------

  /// Identity and abilities of the device.
  [[nodiscard]] DeviceInfo info() const;
  /// As last heard of; costs nothing. @throws Closed
  [[nodiscard]] State state() const;
  /// How the torque went the last time since the knob was opened; costs nothing.
  [[nodiscard]] std::optional<Disarm> last_disarm() const;
  /// Names of the latched faults as the device says now: "over_speed", ...
  [[nodiscard]] std::vector<std::string> faults();
  /// State and counters, as the device says now.
  [[nodiscard]] Health health();
  /// Work of motor, brake and shaft on the knob, if the law is `calibrated`; and the stiffest wall
  /// now. docs/explanation/theory.md, "Bounded stiffness".
  [[nodiscard]] Energies energies();
  /// Sums of current readings and of the bridge's shares since the board started, if it has a
  /// current sensor.
  [[nodiscard]] MotorCurrent motor_current();
  /// The most that the device gives now, and whether it is held low until its parts are confirmed
  /// and known.
  [[nodiscard]] Limits limits();
  [[nodiscard]] Clock clock();          ///< Time and position now, both exact.
  [[nodiscard]] double position_rad();  ///< The angle now, from the device's zero.
  /// Counts of reports at this end of the cable since the knob was opened, and of losses.
  [[nodiscard]] LinkStatistics statistics() const;
  /// Stiffest spring that its parts can render, by its configuration. Beyond it the knob may swing
  /// for ever at full torque, unless the law is `calibrated`. docs/explanation/theory.md,
  /// "Stability".
  [[nodiscard]] StableStiffness stable_stiffness();
  /// Copies of the reports that travel from now on, until you drop the tap. Before them come the
  /// reports of the current scene, if this library played it.
  [[nodiscard]] std::shared_ptr<ReportTap> tap(bool with_telemetry);
  /// A feature report as it is; docs/reference/protocol.md has them. @throws Error if the device
  /// stalls
  [[nodiscard]] ReportBytes feature(std::uint8_t report_id);
  /// Effects of games on the device.
  [[nodiscard]] GameStatus game_status();
  /// The effects that games have made, in the order of their blocks. The three of one report are of
  /// the same moment.
  [[nodiscard]] std::vector<GameEffect> game_effects();

  // Actions -----------------------------------------------------------------------------

  /// Torque on: the scene's torque grows from nothing to full over `passive_ramp_s`. From here on
  /// the library tells the device regularly that the host is alive. A board whose parts nobody has
  /// confirmed gives little; limits() tells.
  /// @throws Refused (fault_latched)
  void arm();
  void disarm();       ///< Torque off; the scene stays.
  void stop();         ///< Torque off, and the scene is emptied.
  void zero();         ///< This position becomes angle 0. @throws Refused (not_disarmed)
  void relax();        ///< The shaft is known to be relaxed now. @throws Refused (not_disarmed)
  void clear_fault();  ///< The fault is over; disarmed then. @throws Refused (fault_persists)

  /// Plays a scene in place of the one before, all of it from the same tick on. Returns when the
  /// device has it.
  /// @returns a warning for the user if the knob may swing in it for ever, let go, or hum, leant
  ///          on, though it plays. Empty if not, and under `calibrated`, which bounds scenes.
  /// @note No law bounds what keeps moving: a wall or a streamed spring may swing. Keep it below a
  ///       quarter of stable_stiffness(), and move it slower than a hand moves.
  /// @throws InvalidArgument that names effect, field, value and range, before anything is sent;
  ///         Refused; either way the old scene goes on
  std::string play(const Scene& scene);
  std::string play(const Effect& effect) { return play(Scene{effect}); }  ///< One effect.

  /// Sends a local model and does not wait for the device. If state() is not armed, nothing is
  /// sent. A later refusal by the device only counts, in statistics().
  /// @returns as play(), of model and scene together; for a model that is stiffer or damps more
  ///          than all since the scene began. It takes the model for one that you move, which no
  ///          law bounds.
  /// @throws InvalidArgument, Refused (not_armed)
  std::string stream_local_model(const LocalModel& model);

  /// Plays a bounded experiment in place of scene and law: commands of motor and brake, as they
  /// are. The next one goes on from where this one is; whatever leaves its bounds, or comes to its
  /// end, disarms. For calibration; docs/how-to/calibration.md.
  /// @throws InvalidArgument that names field, value and range; Refused (not_armed, not_owner)
  void excite(const Excitation& excitation);

  // Events -----------------------------------------------------------------------------------

  /// Takes the device's events that nobody has taken yet, oldest first: changes of state and owner,
  /// faults, silence, missed deadlines, the end of the connection. 1,024 are kept; what is older
  /// counts as lost in statistics().
  /// @param timeout_s how long to wait for one if there is none
  [[nodiscard]] std::vector<Event> events(double timeout_s = 0.0);

  /// Calls back with every event from now on, one after the other and without a lock. A thread of
  /// the knob calls; in virtual time it is the thread that lets time pass. The callback may call
  /// any member. An exception of the callback ends it, and the next on_event() throws the
  /// exception. An empty function ends it too.
  void on_event(std::function<void(const Event&)> callback);

  // Configuration ----------------------------------------------------------------------------

  void save();           ///< Keeps the configuration over power-off. Returns when it is safe.
  void load_defaults();  ///< Configuration of a new device. @throws Refused (not_disarmed)

  // Telemetry --------------------------------------------------------------------------------

  /// Starts telemetry, or changes its rate, and forgets what was not read.
  /// @param rate_hz highest rate wanted, up to the control rate and 4,000 Hz; the device sends
  ///        every n-th tick. None takes the highest rate up to 3,600 Hz, which leaves the cable
  ///        room for answers. Above that samples are lost if commands are sent all the time.
  /// @param prompt have the device report in every frame of a millisecond, with at most 4 of the
  ///        newest samples, for loops that use latest(). Without a rate this is 2,000 Hz. The rate
  ///        may then be the control rate. Above 4,000 Hz a report has no room for all samples; the
  ///        others count as lost.
  /// @returns the true rate
  /// @throws InvalidArgument that says which rates this knob has
  double start_telemetry(std::optional<double> rate_hz = {}, bool prompt = false);
  /// Stops telemetry; what runs record() in another thread keeps it until that is done.
  void stop_telemetry();

  /// The newest sample that has arrived; it can still be read. Waits only for the very first.
  /// @throws Error if no telemetry runs; Timeout
  [[nodiscard]] TelemetrySample latest();

  /// Takes samples, oldest first; waits until there is one or the time is over. After an unplug
  /// what has arrived can still be read.
  /// @returns how many samples were written to `out`
  std::size_t read(std::span<TelemetrySample> out, double timeout_s);
  /// The same, in a vector of at most `max_samples`.
  /// @throws InvalidArgument if `max_samples` is above 2^24
  [[nodiscard]] std::vector<TelemetrySample> read(std::size_t max_samples = 4096,
                                                  double timeout_s = 1.0);

  /// Lets `duration_s` pass and returns every sample of that span. Starts telemetry if it does not
  /// run, or if a rate is given as in start_telemetry(). It returns up to 10 ms late, when the last
  /// sample has arrived. Threads may record at the same time. If it ends early, the exception has
  /// all samples: Error::samples(). They can also still be read.
  /// @param must_stay_armed throw Disarmed if it is not armed, or when the torque goes meanwhile;
  ///        else TelemetryRecord::disarmed tells
  /// @throws InvalidArgument if that is more than 100 million samples; Timeout if telemetry dries
  /// up; Disarmed
  [[nodiscard]] TelemetryRecord record(double duration_s, std::optional<double> rate_hz = {},
                                       bool must_stay_armed = false);
  /// The same, but appends the samples to `into` as they come: they are there however it ends.
  void record(TelemetryRecord& into, double duration_s, std::optional<double> rate_hz = {},
              bool must_stay_armed = false);

  // Waiting ----------------------------------------------------------------------------------

  /// Lets time pass.
  void sleep(double duration_s);

  /// Steps of a program's own loop at equal distances of time, the first at once. One that is late
  /// by a whole period or more is left out and counted, so that the loop never runs to catch up:
  /// `for (const Step step : knob.every(0.001)) { ... knob.latest() ... }`
  /// @throws InvalidArgument unless `period_s` is from 0.0001 to 3600
  [[nodiscard]] Steps every(double period_s);

  /// Waits until the device is in `state`. @returns false if it is not so in time
  bool wait_for(State state, double timeout_s = 1.0);

  /// True if there is an emulator().
  [[nodiscard]] bool is_emulated() const;
  /// The world round an emulated knob. It may be kept for as long as the knob lives.
  /// @throws Error on hardware
  [[nodiscard]] Emulator& emulator() const;

 private:
  friend class KnobConfigurations;
  class Impl;
  Knob(Connection connection, const OpenOptions& options);
  Impl& impl() const;
  void close_and_drop() noexcept;

  std::unique_ptr<Impl> impl_;
};

}  // namespace torsio
