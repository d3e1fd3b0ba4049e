/// @file
/// The device on any board: report bytes and encoder counts in, torques and report bytes out. It is
/// passive: it has no clock, no thread and no pins, a board or the emulator calls it. The same
/// sources run on the microcontroller and on the host.
///
/// Two contexts call it. `tick()` belongs to the control interrupt; everything else belongs to the
/// main loop. They talk through single-producer single-consumer rings and a few words that are
/// written and read whole (docs/explanation/architecture.md, "Interrupt and main loop"), so neither
/// ever waits.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/controller.hpp"
#include "device/config_store.hpp"
#include "device/control_loop.hpp"
#include "device/dial/dial.hpp"
#include "device/game/pid_engine.hpp"
#include "device/power_logic.hpp"
#include "device/ring.hpp"
#include "device/scene_builder.hpp"
#include "device/telemetry_batch.hpp"
#include "device/wiring.hpp"
#include "protocol/codec.hpp"
#include "protocol/reports.hpp"

namespace torsio::device {

/// A board's facts about itself at power-up.
struct BoardInfo {
  std::uint8_t board = 0;                 // its number in firmware/boards/; 0 is the emulated one
  std::array<std::uint8_t, 16> serial{};  // ASCII, padded with zeros
  std::array<std::uint8_t, 3> firmware_version{};
  std::uint32_t control_period_ns = protocol::emulated_control_period_ns;
  bool has_bootloader = false;
  bool moves_parts = false;  // a real motor, which is held low: see trust_in()
  protocol::ResetCause reset_cause = protocol::ResetCause::unknown;
  WiringRule wiring_rule = any_wiring;
  float motor_lag_s = protocol::ActuatorConfig{}.motor_time_constant_s;  // of its current loop
};

class Device {
 public:
  /// Powers up: disarmed, with the newest intact configuration of the two stored slots, or the
  /// defaults if there is none.
  Device(const BoardInfo& board, const SlotViews& stored);

  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// A board that measures the motor's current and drives the brake says who does it, once.
  /// @param power outlives this, or is followed by another
  void measure_by(PowerLogic& power) { power_ = &power; }

  // Control interrupt ------------------------------------------------------------------------

  /// One control period: orders, sensor, scene, partition, limits, telemetry sample.
  TickOutputs tick(const TickInputs& in) { return loop_.tick(in); }
  /// Before a tick: the level of the encoder's index has changed. It is low at first.
  void see_index(bool level) { loop_.see_index(level); }

  /// The knob's speed, by the last tick.
  float speed_rad_s() const { return loop_.speed_rad_s(); }
  /// Whether a periodic effect played in the last tick: it may shake the knob as fast as it likes.
  bool shakes() const { return loop_.shakes(); }

  // Main loop --------------------------------------------------------------------------------

  /// An output report from the host. The acknowledgement says what became of it.
  /// @returns false if the inbox is full: keep the report and offer it again after service()
  [[nodiscard]] bool receive(std::span<const std::uint8_t> report);

  /// A feature report from the host.
  /// @returns not ok: stall the request, nothing has changed
  protocol::Verdict set_feature(std::span<const std::uint8_t> report);

  /// Answers a request for a feature report.
  /// @returns unknown_report: stall the request
  protocol::Status get_feature(std::uint8_t id, protocol::ReportBytes& report);
  /// The same for an input report: the newest samples, or the present state as acknowledgement or
  /// event of nothing.
  protocol::Status get_input(std::uint8_t id, protocol::ReportBytes& report) const;

  /// The next input report for the host; acknowledgements and events go before telemetry.
  /// @param early the host will not ask for a while: prompt telemetry stays, for newer samples
  /// @returns false if there is none
  [[nodiscard]] bool next_input(protocol::ReportBytes& report, bool early = false);

  /// Kind of the second interface, from the start on.
  protocol::Personality personality() const { return personality_; }
  /// Whether turning or pressing wakes a host that sleeps, from the start on.
  bool wakes_host() const { return wakes_host_; }
  /// Inputs that a person changes.
  struct Touch {
    std::int64_t position_counts = 0;
    std::uint8_t buttons = 0;
  };
  Touch touch() const { return {loop_.now().position_counts, buttons_}; }
  /// The second interface, for its own reports.
  GuestFunction& guest() { return guest_; }
  game::PidEngine& game() { return game_; }
  dial::Dial& dial() { return dial_; }
  /// Buttons that are pressed, bit 0 the first.
  void set_buttons(std::uint8_t pressed);

  /// Work that may take its time: reads the inbox, gathers telemetry. Call it in every round.
  void service();

  /// The bus is configured and awake, or not. Without it the device disarms at once, unless it was
  /// told to run on its own.
  void set_connected(bool connected);

  /// The slot that the board must write now, once per `save`. The board calls storage_written()
  /// when the bytes are safe; the acknowledgement of `save` waits for that. If they could not be
  /// written it calls storage_failed(), and `save` is refused with busy.
  [[nodiscard]] std::optional<SlotWrite> take_slot_write();
  void storage_written();
  void storage_failed();

  /// Control periods since power-up.
  std::uint64_t ticks() const { return loop_.snapshot().tick; }

  /// The state now, for a status light.
  protocol::State state() const { return loop_.snapshot().state; }

  /// How the board is wired. A board looks once, when it starts.
  const protocol::BoardConfig& board_config() const { return config_.board; }
  const protocol::ActuatorConfig& actuator_config() const { return config_.actuator; }

  /// True once after an accepted `bootloader` command. From then on nobody can arm.
  [[nodiscard]] bool take_bootloader_request();

 private:
  enum class Bootloader : std::uint8_t { no, asked, begun };

  struct Incoming {
    std::array<std::uint8_t, protocol::report_size> bytes{};
    std::uint8_t length = 0;  // report_size + 1 for anything longer
    protocol::Direction direction = protocol::Direction::output;
  };

  Order read(const Incoming& incoming);
  Order order_for(const protocol::Command& command);
  Order order_for(const protocol::Commit& commit);
  Order order_for(const protocol::Stream& stream);
  Order order_for(const protocol::LocalModel& model);
  Order order_for(const protocol::Excitation& excitation);
  Order order_for(const protocol::CurvePoints& points);
  template <protocol::Configuration Part>
  Order order_for(const Part& part);
  protocol::Centre centre(const IndexWatch& index) const;
  template <class EffectReport>
  Order order_for(const EffectReport& effect);

  protocol::Status get_configuration(std::uint8_t id, protocol::ReportBytes& report) const;
  void gather_telemetry();
  void read_inbox();
  Order configure(const Config& config);
  Order reconfigure(std::uint32_t counts_per_rev);
  bool bar_arming();
  void allow_arming();
  Order save();
  void finish_save();
  Order enter_bootloader();
  core::Resolution resolution() const;
  bool armed() const;

  BoardInfo board_;
  ConfigStore store_;
  Config config_;
  const protocol::Personality personality_;
  const bool wakes_host_;
  LoopConfig loop_config_;
  game::PidEngine game_;
  dial::Dial dial_;
  GuestFunction& guest_;  // one of these
  ControlLoop loop_;
  PowerLogic* power_ = nullptr;  // nullptr: no current is measured
  SceneBuilder scene_;
  TelemetryBatch batch_;
  Ring<Incoming, 8> inbox_;
  std::optional<SlotWrite> slot_write_;
  std::optional<Order> save_order_;  // acknowledged once the slot is written
  Bootloader bootloader_ = Bootloader::no;
  std::uint8_t buttons_ = 0;
  std::uint32_t stalled_ = 0;  // feature requests
};

}  // namespace torsio::device
