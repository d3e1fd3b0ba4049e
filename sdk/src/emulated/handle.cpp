#include "emulated/handle.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "conversion/field_check.hpp"

namespace torsio {
namespace {

constexpr const char* kNoElectrics =
    "this emulated knob has no electrics: open it with a plant that names them in its "
    "EmulatorOptions";

using Device = emulator::EmulatedDevice;
using Bytes = std::span<const std::uint8_t>;

class EmulatedGamePort final : public GamePort {
 public:
  explicit EmulatedGamePort(std::shared_ptr<SharedDevice> device) : device_(std::move(device)) {}

  void write(Bytes report) override { (void)device_->call(&Device::game_write, report); }
  std::vector<std::uint8_t> read() override { return device_->call(&Device::game_read); }
  bool set_feature(Bytes report) override {
    return device_->call(&Device::game_set_feature, report);
  }
  std::vector<std::uint8_t> get_feature(std::uint8_t report_id) override {
    return device_->call(&Device::game_get_feature, report_id);
  }
  void set_buttons(std::uint8_t pressed) override { device_->call(&Device::set_buttons, pressed); }

 private:
  std::shared_ptr<SharedDevice> device_;
};

class EmulatorHandle final : public Emulator {
 public:
  EmulatorHandle(std::shared_ptr<SharedDevice> device, std::function<void(std::int64_t)> sleep)
      : device_(std::move(device)), sleep_(std::move(sleep)), game_(device_) {}

  void set_hand(const Hand& hand) override {
    device_->with_device([&](Device& device) {
      checked([&] { device.set_hand(emulator::take_hold(hand, device.next_tick_ns())); });
    });
  }

  double time_s() const override {
    return 1e-9 * static_cast<double>(device_->call(&Device::time_ns));
  }

  void advance(double duration_s) override { sleep_(whole_ns("duration_s", duration_s)); }

  std::vector<TruthSample> truth() override {
    if (!device_->logs_truth()) {
      throw Error(
          "this emulated knob keeps no log of the truth: open it with log_truth set in its "
          "EmulatorOptions");
    }
    return device_->call(&Device::take_truth);
  }

  std::vector<DeviceInput> inputs() override {
    if (!device_->logs_inputs()) {
      throw Error(
          "this emulated knob keeps no log of its inputs: open it with log_inputs set in its "
          "EmulatorOptions");
    }
    return device_->call(&Device::take_inputs);
  }

  ElectricsState electrics() const override {
    return device_->with_device([](Device& device) {
      const emulator::Circuit* circuit = device.circuit();
      if (circuit == nullptr) throw Error(kNoElectrics);
      return circuit->state(device.plant());
    });
  }

  GamePort& game() override { return game_; }

  void unplug(double after_s) override {
    const std::int64_t after_ns = whole_ns("after_s", after_s);
    device_->with_device([&](Device& device) {
      if (after_ns > 0) return device.unplug_at(device.time_ns() + after_ns);
      device.set_plugged(false);
    });
    device_->notify();
  }

  void set_emergency_stop(bool pressed) override {
    device_->call(&Device::set_emergency_stop, pressed);
  }

  void set_actuator_fault(bool present) override {
    device_->call(&Device::set_actuator_fault, present);
  }

  void set_current_sensor(CurrentSensorState state) override {
    device_->with_device([&](auto& device) {
      if (device.circuit() == nullptr) throw Error(kNoElectrics);
      device.set_current_sensor(state);
    });
  }

  void set_supply(double supply_v) override {
    device_->with_device([&](auto& device) {
      if (device.circuit() == nullptr) throw Error(kNoElectrics);
      checked([&] { device.set_supply(supply_v); });
    });
  }

  void freeze_encoder(bool frozen) override { device_->call(&Device::freeze_encoder, frozen); }

  void jump_encoder(std::int32_t counts) override { device_->call(&Device::jump_encoder, counts); }

  void skip_ticks(std::uint32_t count) override { device_->call(&Device::skip_ticks, count); }

  void set_link_faults(const LinkFaults& faults) override {
    checked([&] { device_->call(&Device::set_link_faults, faults); });
  }

  void cut_power_in_next_save(std::uint32_t after_bytes) override {
    device_->call(&Device::cut_power_in_next_save, after_bytes);
  }

 private:
  std::shared_ptr<SharedDevice> device_;
  std::function<void(std::int64_t)> sleep_;
  EmulatedGamePort game_;
};

}  // namespace

std::unique_ptr<Emulator> make_handle(std::shared_ptr<SharedDevice> device,
                                      std::function<void(std::int64_t)> sleep) {
  return std::make_unique<EmulatorHandle>(std::move(device), std::move(sleep));
}

}  // namespace torsio
