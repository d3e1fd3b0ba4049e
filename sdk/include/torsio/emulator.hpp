/// @file
/// The emulated knob: the device's own firmware code against simulated physics, for programs and
/// tests without hardware.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "torsio/config.hpp"
#include "torsio/emulator_options.hpp"
#include "torsio/export.hpp"
#include "torsio/plant.hpp"

namespace torsio {

/// The device configuration that describes `plant`: a device that was calibrated perfectly.
[[nodiscard]] TORSIO_EXPORT ActuatorConfig matching_config(const PlantParams& plant);

/// The same of its shaft: the knee where it hardens.
[[nodiscard]] TORSIO_EXPORT ShaftConfig matching_shaft(const PlantParams& plant);

/// The game interface of an emulated knob, for tests of drivers. Reports are bytes that begin with
/// their id; docs/reference/games.md has them all. They take effect at the next control tick. Lives
/// as long as its Emulator.
class TORSIO_EXPORT GamePort {
 public:
  GamePort(const GamePort&) = delete;
  GamePort& operator=(const GamePort&) = delete;
  virtual ~GamePort() = default;

  /// An output report. A report that does not fit is ignored, as on the bus.
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

  /// True values that no sensor sees, one sample a control tick since the last call. The call takes
  /// them.
  /// @throws Error unless opened with EmulatorOptions::log_truth
  [[nodiscard]] virtual std::vector<TruthSample> truth() = 0;

  /// All inputs of the device since the last call: reports, counts of the encoder, everything of
  /// its world that it notices. The call takes them.
  /// @throws Error unless opened with EmulatorOptions::log_inputs
  [[nodiscard]] virtual std::vector<DeviceInput> inputs() = 0;

  /// True electric values, now.
  /// @throws Error unless the plant has electrics
  [[nodiscard]] virtual ElectricsState electrics() const = 0;

  /// The game interface, as a game's driver sees it.
  [[nodiscard]] virtual GamePort& game() = 0;

  /// Pulls the plug, at once or when so much of the knob's time has passed, to the millisecond. As
  /// with hardware the knob must be opened again.
  virtual void unplug(double after_s = 0.0) = 0;

  // Faults of the device's world.
  virtual void set_emergency_stop(bool pressed) = 0;  ///< the button, which stays as it is
  virtual void set_actuator_fault(bool present) = 0;  ///< of the power stage, by its own word
  /// Sets what the current sensor shows from now on.
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
