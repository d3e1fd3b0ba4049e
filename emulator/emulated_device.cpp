#include "emulator/emulated_device.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "boards/reference.hpp"
#include "device/config.hpp"
#include "device/config_store.hpp"
#include "emulator/truth.hpp"
#include "protocol/registry.hpp"

namespace torsio::emulator {
namespace {

EmulatedDeviceOptions checked(EmulatedDeviceOptions options) {
  if (options.control_period_ns < protocol::min_control_period_ns ||
      options.control_period_ns > protocol::max_control_period_ns) {
    throw std::invalid_argument("control_period_ns must be within " +
                                std::to_string(protocol::min_control_period_ns) + " and " +
                                std::to_string(protocol::max_control_period_ns) + ", is " +
                                std::to_string(options.control_period_ns));
  }
  const bool printable =
      std::ranges::all_of(options.serial, [](char c) { return c > 32 && c < 127; });
  if (options.serial.empty() || options.serial.size() > 16 || !printable) {
    throw std::invalid_argument("serial must be 1 to 16 printable ASCII characters, has " +
                                (printable ? std::to_string(options.serial.size()) : "others"));
  }
  options.encoder.seed += options.seed;
  return options;
}

template <class Config>
void require(const Config&, protocol::Verdict verdict) {
  if (verdict.ok()) return;
  throw std::invalid_argument(std::string(protocol::Layout<Config>::name) + ": " +
                              std::string(protocol::field_name<Config>(verdict.field)) +
                              " is outside what docs/reference/protocol.md allows");
}

/// The storage with the overriding configuration saved in it.
device::StoredSlots with_overrides(const EmulatedDeviceOptions& options) {
  const device::ConfigStore store(options.stored, boards::kReference.wiring_rule);
  device::Config config = store.loaded().value_or(device::Config{});
  bool any = false;
  protocol::for_each_configuration(options.given,
                                   [&]<class Report>(const std::optional<Report>& given) {
                                     if (!given) return;
                                     require(*given, protocol::check(*given));
                                     config.*protocol::PlaceOf<Report>::value = *given;
                                     any = true;
                                   });
  device::StoredSlots slots = options.stored;
  if (!any) return slots;
  protocol::for_each_configuration(config, [&](const auto& report) {
    require(report, device::check_rules(report, config, boards::kReference.wiring_rule));
  });
  const device::SlotWrite write = store.prepare(config);
  slots.slot.at(write.slot) = write.bytes;
  return slots;
}

}  // namespace

EmulatedDevice::EmulatedDevice(EmulatedDeviceOptions options)
    : options_(checked(std::move(options))),
      power_(options_.plant.electrics
                 ? std::make_unique<PowerPath>(*options_.plant.electrics,
                                               options_.control_period_ns, options_.seed)
                 : nullptr),
      plant_(options_.plant, options_.hand,
             power_ ? power_->step_ns() : options_.control_period_ns),
      encoder_(options_.encoder),
      link_(options_.seed, options_.input_queue_reports),
      stored_(with_overrides(options_)) {
  if (options_.log_inputs) {
    std::vector<std::uint8_t> slots;
    for (const auto& slot : stored_.slot) slots.insert(slots.end(), slot.begin(), slot.end());
    inputs_.add(InputKind::stored, slots.data(), slots.size());
    log_flag(InputKind::power, true);
  }
  power_up();
}

device::BoardInfo EmulatedDevice::board() const {
  device::BoardInfo board;
  board.board = 0;
  board.wiring_rule = boards::kReference.wiring_rule;
  std::ranges::copy(options_.serial, board.serial.begin());
  board.firmware_version = {TORSIO_VERSION_MAJOR, TORSIO_VERSION_MINOR, TORSIO_VERSION_PATCH};
  board.control_period_ns = static_cast<std::uint32_t>(options_.control_period_ns);
  return board;
}

device::Device& EmulatedDevice::device() {
  if (device_ == nullptr) throw std::logic_error("the emulated device has no power");
  return *device_;
}

void EmulatedDevice::power_up() {
  device_ = std::make_unique<device::Device>(board(), stored_);
  device_->set_connected(plugged_);
  index_level_ = false;
  has_index_ = device_->actuator_config().encoder_index_pin != 0;
  if (power_) {
    power_->power_up(device_->board_config(), device_->actuator_config().brake_time_constant_s);
    device_->measure_by(power_->logic());
  }
}

void EmulatedDevice::advance(std::int64_t duration_ns) {
  if (duration_ns < 0) throw std::invalid_argument("duration_ns must not be negative");
  const std::int64_t end_ns = now_ns_ + duration_ns;
  while (true) {
    const std::int64_t next_ns = std::min(next_frame_ns_, next_tick_ns_);
    if (next_ns >= end_ns) break;
    now_ns_ = next_ns;
    if (next_frame_ns_ == next_ns) {
      next_frame_ns_ += UsbLink::kFrameNs;
      if (now_ns_ >= unplug_ns_) set_plugged(false);
      if (connected()) {
        device_->service();
        if (const auto received = link_.frame(*device_)) log_report(InputKind::output, *received);
      }
    }
    if (next_tick_ns_ == next_ns) {
      next_tick_ns_ += options_.control_period_ns;
      tick();
    }
  }
  now_ns_ = end_ns;
}

// Inlined, as a call would put the outputs into memory and wait for them.
[[gnu::always_inline]] inline device::TickOutputs EmulatedDevice::run_control(
    std::uint32_t encoder_count) {
  device_->service();
  if (const auto write = device_->take_slot_write()) {
    write_slot(*write);
    if (device_ == nullptr) return {};
  }
  const std::uint16_t power_faults = power_ ? power_->find_faults(actuator_fault_) : 0;
  const device::TickInputs inputs{.encoder_count = encoder_count,
                                  .emergency_stop = emergency_stop_,
                                  .actuator_fault = power_ ? power_faults != 0 : actuator_fault_,
                                  .power_faults = power_faults,
                                  .missed_ticks = std::exchange(ticks_missed_, 0)};
  if (has_index_ && encoder_.index() != index_level_) {
    index_level_ = !index_level_;
    if (options_.log_inputs) log_flag(InputKind::index, index_level_);
    device_->see_index(index_level_);
  }
  if (options_.log_inputs) log_tick(inputs);
  const device::TickOutputs wanted = device_->tick(inputs);
  if (power_) power_->set_speed(device_->speed_rad_s());
  return wanted;
}

void EmulatedDevice::tick() {
  if (options_.log_truth) log_truth();
  if (!encoder_frozen_) encoder_count_ = encoder_.sample(plant_.state().knob_angle);
  if (device_ != nullptr && ticks_to_skip_ > 0) {
    --ticks_to_skip_;
    ++ticks_missed_;
    if (power_) {
      power_->stand_still(plant_);
    } else {
      plant_.advance(next_tick_ns_ - plant_.state().time_ns);
    }
    return;
  }
  device::TickOutputs wanted;
  if (device_ != nullptr) wanted = run_control(encoder_count_ + encoder_offset_);
  if (power_) {
    power_->run(plant_, wanted);
    return;
  }
  plant_.set_command(wanted.enabled
                         ? Command{.motor_command_nm = static_cast<double>(wanted.motor_command_nm),
                                   .brake_command_nm = static_cast<double>(wanted.brake_command_nm)}
                         : Command{});
  // A control period, or more after the function of a hand has failed in the middle of the last.
  plant_.advance(next_tick_ns_ - plant_.state().time_ns);
}

void EmulatedDevice::write_slot(const device::SlotWrite& write) {
  device::SlotBytes& slot = stored_.slot.at(write.slot);
  slot.fill(0xFF);  // flash is erased before it is written
  const std::size_t bytes = std::min(power_cut_bytes_.value_or(slot.size()), slot.size());
  std::copy_n(write.bytes.begin(), bytes, slot.begin());
  if (power_cut_bytes_) {
    power_cut_bytes_.reset();
    set_powered(false);
  } else {
    device_->storage_written();
  }
}

bool EmulatedDevice::write(const protocol::ReportBytes& report) {
  return connected() && link_.write(report);
}

bool EmulatedDevice::read(protocol::ReportBytes& report) { return link_.read(report); }

protocol::Verdict EmulatedDevice::set_feature(std::span<const std::uint8_t> report) {
  if (!connected()) return {protocol::Status::unsupported};
  log_report(InputKind::feature, report);
  return device_->set_feature(report);
}

protocol::Status EmulatedDevice::get_feature(std::uint8_t id, protocol::ReportBytes& report) const {
  if (!connected()) return protocol::Status::unsupported;
  return device_->get_feature(id, report);
}

bool EmulatedDevice::game_write(std::span<const std::uint8_t> report) {
  if (!connected()) return false;
  log_report(InputKind::game_output, report);
  device_->game().receive(report);
  return true;
}

std::vector<std::uint8_t> EmulatedDevice::game_read() {
  std::array<std::uint8_t, device::game::kLongestReport> bytes{};
  const std::size_t size = connected() ? device_->game().next_input(bytes) : 0;
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
}

bool EmulatedDevice::game_set_feature(std::span<const std::uint8_t> report) {
  if (!connected()) return false;
  log_report(InputKind::game_feature, report);
  return device_->game().set_feature(report);
}

std::vector<std::uint8_t> EmulatedDevice::game_get_feature(std::uint8_t id) {
  std::array<std::uint8_t, device::game::kLongestReport> bytes{};
  const std::size_t size = connected() ? device_->game().get_feature(id, bytes) : 0;
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
}

void EmulatedDevice::set_buttons(std::uint8_t pressed) {
  if (device_ == nullptr) return;
  log_report(InputKind::buttons, {&pressed, 1});
  device_->set_buttons(pressed);
}

void EmulatedDevice::set_hand(Hand hand) { plant_.set_hand(std::move(hand)); }

PowerPath& EmulatedDevice::power() {
  if (!power_) {
    throw std::logic_error(
        "the plant has no electrics, so no current sensor and no supply; give "
        "PlantParams::electrics");
  }
  return *power_;
}

void EmulatedDevice::set_current_sensor(CurrentSensorState state) {
  power().set_sensor_state(state);
}

void EmulatedDevice::set_supply(double supply_v) {
  // False for NaN.
  if (!(supply_v >= 0.0 && supply_v <= 1000.0)) {
    throw std::invalid_argument("supply_v is " + std::to_string(supply_v) +
                                ", allowed are 0 to 1000 V");
  }
  power().set_supply(supply_v);
}

std::vector<TruthSample> EmulatedDevice::take_truth() { return std::exchange(truth_, {}); }

void EmulatedDevice::set_plugged(bool plugged) {
  if (plugged == plugged_) return;
  plugged_ = plugged;
  link_.clear();
  log_flag(InputKind::connected, plugged);
  if (device_ != nullptr) device_->set_connected(plugged);
}

void EmulatedDevice::set_powered(bool powered) {
  if (powered == (device_ != nullptr)) return;
  link_.clear();
  log_flag(InputKind::power, powered);
  device_.reset();
  if (power_) power_->power_down();
  if (powered) power_up();
}

void EmulatedDevice::cut_power_in_next_save(std::size_t bytes) {
  if (options_.log_inputs) {
    inputs_.add_number(InputKind::power_cut, static_cast<std::uint32_t>(bytes));
  }
  power_cut_bytes_ = bytes;
}

void EmulatedDevice::log_tick(const device::TickInputs& in) {
  if (in.emergency_stop != logged_.emergency_stop) {
    log_flag(InputKind::emergency_stop, in.emergency_stop);
  }
  if (in.actuator_fault != logged_.actuator_fault) {
    log_flag(InputKind::actuator_fault, in.actuator_fault);
  }
  if (in.power_faults != logged_.power_faults) {
    inputs_.add_number(InputKind::power_faults, in.power_faults);
  }
  if (in.missed_ticks > 0) inputs_.add_number(InputKind::missed_ticks, in.missed_ticks);
  inputs_.add_tick(in.encoder_count);
  logged_ = in;
}

void EmulatedDevice::log_flag(InputKind kind, bool value) {
  if (options_.log_inputs) inputs_.add(kind, value ? 1 : 0);
}

void EmulatedDevice::log_report(InputKind kind, std::span<const std::uint8_t> report) {
  if (options_.log_inputs) inputs_.add(kind, report.data(), report.size());
}

void EmulatedDevice::log_truth() { tell_truth(plant_, truth_.emplace_back()); }

}  // namespace torsio::emulator
