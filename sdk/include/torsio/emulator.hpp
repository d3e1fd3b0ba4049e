/// @file
/// The emulated knob: the device's own firmware code against simulated physics, for programs and
/// tests without hardware.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "torsio/config.hpp"
#include "torsio/export.hpp"
#include "torsio/plant.hpp"

namespace torsio {

/// The device configuration that describes `plant`: a device that was calibrated perfectly.
[[nodiscard]] TORSIO_EXPORT ActuatorConfig matching_config(const PlantParams& plant);

/// The same of its shaft: the knee where it hardens.
[[nodiscard]] TORSIO_EXPORT ShaftConfig matching_shaft(const PlantParams& plant);

/// What an emulated knob is like, who holds it, and what is recorded of it.
struct EmulatorOptions {
  std::uint64_t seed = 0;           ///< of everything random: encoder noise, damaged reports
  double control_rate_hz = 1000.0;  ///< 1,000 to 20,000
  PlantParams plant{};              ///< what it is made of
  Hand hand = NoHand{};             ///< who holds it
  std::string serial{};  ///< at most 16 ASCII characters; empty: derived from the device's name
  /// Configuration at power-up in place of what the device has stored, or of its defaults.
  std::optional<ActuatorConfig> actuator{};
  std::optional<ControlConfig> control{};  ///< the same
  std::optional<BoardConfig> board{};      ///< a plant with electrics has use for it
  std::optional<GameConfig> game{};        ///< the same
  std::optional<ShaftConfig> shaft{};      ///< the same
  /// false: time is virtual and passes only inside calls that wait, as fast as it can be computed;
  /// the same calls with the same seed give the same bytes. true: time is the wall clock's, as
  /// with hardware.
  bool paced = false;
  bool log_truth = false;  ///< record what no sensor sees, once a tick; see Emulator::truth()
  /// Record what enters the device, from power-up on, so that it can run again; Emulator::inputs()
  bool log_inputs = false;
};

/// Something that entered an emulated device; emulator/device_input.hpp says what there is.
struct DeviceInput {
  std::uint64_t tick = 0;             ///< control ticks that had run before it
  std::string kind{};                 ///< what it is
  std::vector<std::uint8_t> bytes{};  ///< what it says
};

/// Damage to reports on the way, as probabilities per report.
struct LinkFaults {
  double drop_output = 0.0;     ///< host to device
  double corrupt_output = 0.0;  ///< a bit of it is another
  double drop_input = 0.0;      ///< device to host
  double corrupt_input = 0.0;   ///< a bit of it is another
};

/// The game interface of an emulated knob, for the tests of those who talk to it: reports as bytes,
/// each beginning with its id; docs/games.md has them all. They take effect at the next control
/// tick. Lives as long as its Emulator.
class TORSIO_EXPORT GamePort {
 public:
  GamePort(const GamePort&) = delete;
  GamePort& operator=(const GamePort&) = delete;
  virtual ~GamePort() = default;

  /// An output report. What does not fit is ignored, as on the bus.
  virtual void write(std::span<const std::uint8_t> report) = 0;
  /// The next input report; empty if there is nothing new.
  [[nodiscard]] virtual std::vector<std::uint8_t> read() = 0;
  /// @returns false if the device stalls the request
  [[nodiscard]] virtual bool set_feature(std::span<const std::uint8_t> report) = 0;
  /// A feature report; empty if the device stalls the request.
  [[nodiscard]] virtual std::vector<std::uint8_t> get_feature(std::uint8_t report_id) = 0;
  /// Presses exactly these buttons of the game controller, bit 0 the first.
  virtual void set_buttons(std::uint8_t pressed) = 0;

 protected:
  GamePort() = default;
};

/// The world round an emulated knob. Belongs to the Knob and lives as long as it does; may be used
/// from any thread. After close() its calls throw Closed.
class TORSIO_EXPORT Emulator {
 public:
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;
  virtual ~Emulator() = default;

  /// The hand takes over at the next control tick, which is time 0 of its profiles.
  /// @throws InvalidArgument that names the field; the old hand then stays
  virtual void set_hand(const Hand& hand) = 0;

  /// Device time.
  [[nodiscard]] virtual double time_s() const = 0;

  /// Lets time pass, like Knob::sleep().
  virtual void advance(double duration_s) = 0;

  /// What no sensor sees, one sample a control tick since the last call, which takes them.
  /// @throws Error unless opened with EmulatorOptions::log_truth
  [[nodiscard]] virtual std::vector<TruthSample> truth() = 0;

  /// What entered the device since the last call, which takes it: reports, counts of the encoder,
  /// everything of its world that it notices.
  /// @throws Error unless opened with EmulatorOptions::log_inputs
  [[nodiscard]] virtual std::vector<DeviceInput> inputs() = 0;

  /// What no sensor sees of the electrics, now.
  /// @throws Error unless the plant has electrics
  [[nodiscard]] virtual ElectricsState electrics() const = 0;

  /// The game interface, as a game's driver sees it.
  [[nodiscard]] virtual GamePort& game() = 0;

  /// Pulls the plug. As with hardware the knob must be opened again.
  virtual void unplug() = 0;

  // Faults of the device's world.
  virtual void set_emergency_stop(bool pressed) = 0;  ///< the button, which stays as it is
  virtual void set_actuator_fault(bool present) = 0;  ///< of the power stage, by its own word
  /// What the current sensor shows from now on.
  /// @throws Error unless the plant has electrics
  virtual void set_current_sensor(CurrentSensorState state) = 0;
  /// The supply gives that many volts from now on.
  /// @throws InvalidArgument unless from 0 to 1,000; Error unless the plant has electrics
  virtual void set_supply(double supply_v) = 0;
  virtual void freeze_encoder(bool frozen) = 0;        ///< the counter stands still
  virtual void jump_encoder(std::int32_t counts) = 0;  ///< the counter is wrong from now on
  /// The control loop comes that many ticks late.
  virtual void skip_ticks(std::uint32_t count) = 0;
  /// Damages reports from now on.
  virtual void set_link_faults(const LinkFaults& faults) = 0;
  /// The next save loses power after so many bytes of its slot: the device vanishes.
  virtual void cut_power_in_next_save(std::uint32_t after_bytes) = 0;

 protected:
  Emulator() = default;
};

}  // namespace torsio
