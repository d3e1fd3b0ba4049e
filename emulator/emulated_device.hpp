/// @file
/// The emulated device: the firmware's device, an encoder and a plant under one virtual clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/device.hpp"
#include "emulator/encoder.hpp"
#include "emulator/input_log.hpp"
#include "emulator/plant/hand.hpp"
#include "emulator/plant/plant.hpp"
#include "emulator/power_path.hpp"
#include "emulator/usb_link.hpp"
#include "protocol/codec.hpp"
#include "protocol/configurations.hpp"
#include "protocol/reports.hpp"
#include "torsio/plant.hpp"

namespace torsio::emulator {

struct EmulatedDeviceOptions {
  /// Seed of everything random. The encoder adds its own for its noise.
  std::uint64_t seed = 0;
  /// protocol::min_control_period_ns to protocol::max_control_period_ns
  std::int64_t control_period_ns = protocol::emulated_control_period_ns;
  PlantParams plant{};
  EncoderParams encoder{};
  Hand hand = NoHand{};
  std::string serial{kEmulatedSerial};  ///< 1 to 16 printable ASCII characters
  device::StoredSlots stored = device::empty_slots();
  /// Configuration in the storage at the start; it replaces `stored` and the defaults.
  protocol::GivenConfigurations given{};
  std::size_t input_queue_reports = 64;  ///< see UsbLink
  bool log_truth = false;
  bool log_inputs = false;
};

/// A whole knob without hardware: the firmware's device, plant, hand, encoder, storage and USB
/// cable under one virtual clock in nanoseconds. The same options and the same calls at the same
/// times give the same bytes. It does not matter how advance() calls cut the time.
///
/// Frames of the cable are at multiples of 1 ms and control ticks at multiples of the control
/// period, both from time 0 on; where they coincide the frame goes first. advance() runs what lies
/// at or after the present and before the end of the span.
class EmulatedDevice {
 public:
  /// Powers up, plugged in, at time 0.
  /// @throws std::invalid_argument that names what is out of its range
  explicit EmulatedDevice(EmulatedDeviceOptions options = {});

  /// @throws std::invalid_argument if the duration is negative
  void advance(std::int64_t duration_ns);
  [[nodiscard]] std::int64_t time_ns() const { return now_ns_; }

  // The host's end of the cable ---------------------------------------------------------------

  [[nodiscard]] bool connected() const { return plugged_ && device_ != nullptr; }

  /// @returns false if the host's queue is full, or nothing is connected
  [[nodiscard]] bool write(const protocol::ReportBytes& report);
  /// @returns false if there is nothing to read
  [[nodiscard]] bool read(protocol::ReportBytes& report);
  /// @returns not ok: the device stalled the request (unsupported: nothing is connected)
  protocol::Verdict set_feature(std::span<const std::uint8_t> report);
  [[nodiscard]] protocol::Status get_feature(std::uint8_t id, protocol::ReportBytes& report) const;

  // For a USB stack in place of the cable, which must stay unplugged then: the stack says itself
  // whether the device is connected.
  [[nodiscard]] device::BoardInfo board() const;
  /// @throws std::logic_error while there is no power
  [[nodiscard]] device::Device& device();

  // The game interface. Its reports have different lengths. They take no time on the cable: tests
  // look at games here, not at the bus.

  /// @returns false if nothing is connected
  bool game_write(std::span<const std::uint8_t> report);
  /// @returns nothing if there is nothing new
  [[nodiscard]] std::vector<std::uint8_t> game_read();
  /// @returns false: the device stalled the request, or nothing is connected
  [[nodiscard]] bool game_set_feature(std::span<const std::uint8_t> report);
  /// @returns nothing if the device stalled the request, or nothing is connected
  [[nodiscard]] std::vector<std::uint8_t> game_get_feature(std::uint8_t id);
  /// Presses exactly these buttons, bit 0 the first.
  void set_buttons(std::uint8_t pressed);

  // The world ---------------------------------------------------------------------------------

  [[nodiscard]] const Plant& plant() const { return plant_; }
  /// nullptr without electrics.
  [[nodiscard]] const Circuit* circuit() const { return power_ ? &power_->circuit() : nullptr; }

  /// The hand takes over at the next tick. Times of its profiles are device time.
  /// @throws std::invalid_argument as validate(hand) does; the old hand then stays
  void set_hand(Hand hand);
  /// When the next tick is, and so when a hand that is set now takes over.
  [[nodiscard]] std::int64_t next_tick_ns() const { return next_tick_ns_; }

  /// The log since the last call; empty unless EmulatedDeviceOptions::log_truth.
  [[nodiscard]] std::vector<TruthSample> take_truth();

  /// Inputs of the device since the last call; empty unless EmulatedDeviceOptions::log_inputs.
  [[nodiscard]] std::vector<DeviceInput> take_inputs() { return inputs_.take(); }

  /// Content of the device's storage, for the next emulated device.
  [[nodiscard]] const device::StoredSlots& stored() const { return stored_; }

  // Faults ------------------------------------------------------------------------------------

  /// Pulls the plug or puts it back; the device has power either way.
  void set_plugged(bool plugged);
  /// Pulls the plug at the first frame from then on.
  void unplug_at(std::int64_t time_ns) { unplug_ns_ = time_ns; }
  /// Takes the power away or gives it back. Powering up starts the firmware anew.
  void set_powered(bool powered);
  void set_emergency_stop(bool pressed) { emergency_stop_ = pressed; }
  /// Sets the current sensor's reading from now on, for a plant with electrics.
  /// @throws std::logic_error if the plant has none
  void set_current_sensor(CurrentSensorState state);
  /// The supply gives that many volts from now on.
  /// @throws std::invalid_argument unless from 0 to 1,000; std::logic_error without electrics
  void set_supply(double supply_v);
  void set_actuator_fault(bool present) { actuator_fault_ = present; }
  /// The encoder's counter stands still.
  void freeze_encoder(bool frozen) { encoder_frozen_ = frozen; }
  /// The encoder's counter is wrong by so many counts from now on.
  void jump_encoder(std::int32_t counts) { encoder_offset_ += static_cast<std::uint32_t>(counts); }
  /// The next `count` ticks do not happen; the one after them reports them missed.
  void skip_ticks(std::uint32_t count) { ticks_to_skip_ += count; }
  /// The next save loses power after so many bytes of its slot.
  void cut_power_in_next_save(std::size_t bytes);
  /// @throws std::invalid_argument as UsbLink::set_faults() does
  void set_link_faults(const LinkFaults& faults) { link_.set_faults(faults); }

 private:
  void power_up();
  void tick();
  device::TickOutputs run_control(std::uint32_t encoder_count);
  [[nodiscard]] PowerPath& power();
  void write_slot(const device::SlotWrite& write);
  void log_truth();
  void log_tick(const device::TickInputs& in);
  void log_flag(InputKind kind, bool value);
  void log_report(InputKind kind, std::span<const std::uint8_t> report);

  EmulatedDeviceOptions options_;
  // For a plant with electrics; the device has a pointer to it.
  std::unique_ptr<PowerPath> power_;
  Plant plant_;
  Encoder encoder_;
  UsbLink link_;
  device::StoredSlots stored_;
  std::unique_ptr<device::Device> device_;  // null: no power

  std::int64_t now_ns_ = 0;
  std::int64_t next_tick_ns_ = 0;
  std::int64_t next_frame_ns_ = 0;

  bool plugged_ = true;
  std::int64_t unplug_ns_ = std::numeric_limits<std::int64_t>::max();
  bool emergency_stop_ = false;
  bool actuator_fault_ = false;
  bool encoder_frozen_ = false;
  bool has_index_ = false;
  bool index_level_ = false;
  std::uint32_t encoder_count_ = 0;
  std::uint32_t encoder_offset_ = 0;
  std::uint32_t ticks_to_skip_ = 0;
  std::uint32_t ticks_missed_ = 0;
  std::optional<std::size_t> power_cut_bytes_;
  std::vector<TruthSample> truth_;
  InputLog inputs_;
  device::TickInputs logged_;  // the last tick's
};

}  // namespace torsio::emulator
