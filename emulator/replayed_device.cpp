#include "emulator/replayed_device.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "torsio/plant_fields.hpp"

namespace torsio::emulator {
namespace {

using Bytes = std::span<const std::uint8_t>;

void require_size(InputKind kind, Bytes bytes, std::size_t size) {
  if (bytes.size() == size) return;
  throw std::invalid_argument(
      "an input '" + std::string(Names<InputKind>::values.at(static_cast<std::size_t>(kind))) +
      "' has " + std::to_string(size) + " bytes, this one " + std::to_string(bytes.size()));
}

bool flag(InputKind kind, Bytes bytes) {
  require_size(kind, bytes, 1);
  return bytes[0] != 0;
}

std::uint32_t number(InputKind kind, Bytes bytes) {
  require_size(kind, bytes, 4);
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8U | bytes[i];
  return value;
}

}  // namespace

void ReplayedDevice::take(InputKind kind, Bytes bytes) {
  if (take_report(kind, bytes) || take_signal(kind, bytes) || take_surrounding(kind, bytes)) return;
  throw std::invalid_argument("there is no such kind of input");
}

/// Reports of the host. @returns false if it is of another kind; likewise below
bool ReplayedDevice::take_report(InputKind kind, Bytes bytes) {
  switch (kind) {
    case InputKind::output:
      if (!device_) break;
      // Earlier inputs make room for it.
      device_->service();
      if (!device_->receive(bytes)) {
        throw std::invalid_argument("an output report came faster than the device takes them");
      }
      break;
    case InputKind::feature:
      if (device_) static_cast<void>(device_->set_feature(bytes));
      break;
    case InputKind::game_output:
      if (device_) device_->game().receive(bytes);
      break;
    case InputKind::game_feature:
      if (device_) static_cast<void>(device_->game().set_feature(bytes));
      break;
    default:
      return false;
  }
  return true;
}

/// Signals at the board's pins but the encoder's counts, and ticks that the interrupt missed.
bool ReplayedDevice::take_signal(InputKind kind, Bytes bytes) {
  switch (kind) {
    case InputKind::buttons:
      require_size(kind, bytes, 1);
      if (device_) device_->set_buttons(bytes[0]);
      break;
    case InputKind::emergency_stop:
      inputs_.emergency_stop = flag(kind, bytes);
      break;
    case InputKind::index:
      if (device_) device_->see_index(flag(kind, bytes));
      break;
    case InputKind::actuator_fault:
      inputs_.actuator_fault = flag(kind, bytes);
      break;
    case InputKind::power_faults:
      inputs_.power_faults = static_cast<std::uint16_t>(number(kind, bytes));
      break;
    case InputKind::missed_ticks:
      inputs_.missed_ticks = number(kind, bytes);
      break;
    default:
      return false;
  }
  return true;
}

/// Time, power, the bus and the storage.
bool ReplayedDevice::take_surrounding(InputKind kind, Bytes bytes) {
  switch (kind) {
    case InputKind::stored:
      require_size(kind, bytes, sizeof(stored_.slot));
      for (auto& slot : stored_.slot) {
        std::copy_n(bytes.begin(), slot.size(), slot.begin());
        bytes = bytes.subspan(slot.size());
      }
      break;
    case InputKind::power:
      set_powered(flag(kind, bytes));
      break;
    case InputKind::power_cut:
      power_cut_bytes_ = number(kind, bytes);
      break;
    case InputKind::connected:
      connected_ = flag(kind, bytes);
      if (device_) device_->set_connected(connected_);
      break;
    case InputKind::counts:
      require_size(kind, bytes, bytes.size() / 4 * 4);
      for (; !bytes.empty(); bytes = bytes.subspan(4)) tick(number(kind, bytes.first(4)));
      break;
    default:
      return false;
  }
  return true;
}

void ReplayedDevice::set_powered(bool powered) {
  if (powered == (device_ != nullptr)) return;
  // A save cut the power.
  if (!powered && power_cut_bytes_) settle();
  device_.reset();
  if (!powered) return;
  device_ = std::make_unique<device::Device>(board_, stored_);
  device_->set_connected(connected_);
}

/// Does the device's work between two ticks. @returns false if it has lost power on the way
bool ReplayedDevice::settle() {
  device_->service();
  const auto write = device_->take_slot_write();
  if (!write) return true;
  device::SlotBytes& slot = stored_.slot.at(write->slot);
  slot.fill(0xFF);  // flash is erased before it is written
  const std::size_t bytes = std::min(power_cut_bytes_.value_or(slot.size()), slot.size());
  std::copy_n(write->bytes.begin(), bytes, slot.begin());
  if (std::exchange(power_cut_bytes_, std::nullopt)) {
    device_.reset();
    return false;
  }
  device_->storage_written();
  return true;
}

void ReplayedDevice::tick(std::uint32_t count) {
  if (!device_ || !settle()) return;
  inputs_.encoder_count = count;
  static_cast<void>(device_->tick(inputs_));
  inputs_.missed_ticks = 0;
  ++ticks_;
  device_->service();
  protocol::ReportBytes report;
  while (device_->next_input(report)) outputs_.push_back({ticks_, report});
}

protocol::Status ReplayedDevice::get_feature(std::uint8_t id, protocol::ReportBytes& report) {
  return device_ ? device_->get_feature(id, report) : protocol::Status::unsupported;
}

std::vector<ReplayedDevice::Output> ReplayedDevice::take_outputs() {
  return std::exchange(outputs_, {});
}

}  // namespace torsio::emulator
