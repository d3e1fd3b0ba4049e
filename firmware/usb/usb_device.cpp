#include "usb/usb_device.hpp"

#include <tusb.h>

#include <algorithm>
#include <utility>

#include "device/usb_descriptors.hpp"
#include "usb/hid_driver.hpp"

namespace torsio::usb {
namespace {

device::Personality personality = device::Personality::game_controller;
device::Device* the_device = nullptr;

constexpr std::uint32_t kFrameNs = 1'000'000;
// A bus that sleeps is left alone for so long (USB 2.0, 7.1.7.7).
constexpr std::uint32_t kStillNs = 5'000'000;
// A turn of 1 in so many wakes it: no truck in the street does.
constexpr std::int64_t kWakingShare = 32;

// The stack's send buffer must stay where it is until the transfer is over.
std::array<std::uint8_t, device::kDeviceDescriptorSize> device_descriptor;
std::array<std::uint8_t, 16> serial;
device::StringDescriptor string;

}  // namespace

ControlFunction::ControlFunction(device::Device& device, std::uint32_t control_period_ns)
    : device_(device) {
  const std::uint32_t frame_ticks = kFrameNs / control_period_ns;
  // The tick that is under way counts as none.
  early_ticks_ = frame_ticks - std::max(frame_ticks / 4, std::uint32_t{1});
}

std::size_t ControlFunction::get_feature(std::uint8_t id, std::span<std::uint8_t> report) {
  protocol::ReportBytes bytes;
  if (device_.get_feature(id, bytes) != protocol::Status::ok) return 0;
  std::copy(bytes.begin(), bytes.end(), report.begin());
  return bytes.size();
}

std::size_t ControlFunction::get_input(std::uint8_t id, std::span<std::uint8_t> report) {
  protocol::ReportBytes bytes;
  if (device_.get_input(id, bytes) != protocol::Status::ok) return 0;
  std::copy(bytes.begin(), bytes.end(), report.begin());
  return bytes.size();
}

void ControlFunction::input_over(bool taken) {
  if (taken) taken_at_tick_ = device_.ticks();
}

bool ControlFunction::set_feature(std::span<const std::uint8_t> report) {
  return device_.set_feature(report).ok();
}

bool ControlFunction::receive(std::span<const std::uint8_t> report) {
  return device_.receive(report);
}

std::size_t ControlFunction::next_input(std::span<std::uint8_t> report) {
  protocol::ReportBytes bytes;
  const bool early = device_.ticks() - taken_at_tick_ < early_ticks_;
  if (!device_.next_input(bytes, early)) return 0;
  std::copy(bytes.begin(), bytes.end(), report.begin());
  return bytes.size();
}

UsbDevice::UsbDevice(device::Device& device, const device::BoardInfo& board)
    : device_(device),
      still_ticks_(kStillNs / board.control_period_ns),
      control_(device, board.control_period_ns) {
  wakes_host = device.wakes_host();
  device_descriptor = device::device_descriptor(board.firmware_version);
  serial = board.serial;
  set_hid_function(device::kControlInterface, control_);
  personality = device.personality();
  set_personality(personality);
  set_hid_function(device::kGameInterface, device.guest());
  device_.set_connected(false);
  the_device = &device;
  const tusb_rhport_init_t init{TUSB_ROLE_DEVICE, TUSB_SPEED_FULL};
  (void)tusb_init(0, &init);
}

void UsbDevice::poll() {
  tud_task();
  if (wakes_host) wake_host();
  // Only what has changed: each call makes the next tick decide anew.
  if (const bool connected = has_host(); connected != connected_) {
    connected_ = connected;
    device_.set_connected(connected);
  }
  poll_hid();
}

/// The stack does so only if the host has allowed it.
void UsbDevice::wake_host() {
  if (!tud_suspended()) {
    asleep_ = false;
    return;
  }
  const device::Device::Touch touch = device_.touch();
  if (!std::exchange(asleep_, true)) {
    asleep_tick_ = device_.ticks();
    touched_ = touch;
  }
  if (device_.ticks() - asleep_tick_ < still_ticks_) return;
  const bool pressed = (touch.buttons & ~touched_.buttons) != 0;
  touched_.buttons = touch.buttons;
  const std::int64_t turned = touch.position_counts - touched_.position_counts;
  const std::int64_t size = kWakingShare * (turned < 0 ? -turned : turned);
  if (!pressed && size < device_.actuator_config().counts_per_rev) return;
  touched_ = touch;
  (void)tud_remote_wakeup();
}

bool UsbDevice::has_host() const {
  // Configured and not suspended. Pulling the plug of a device that keeps its power looks like a
  // suspended bus: there are no more start-of-frame packets.
  return tud_ready();
}

}  // namespace torsio::usb

// Called by the stack: the cable is out, or the host has taken the configuration away. A bus reset
// is neither: it is how a host wakes a device whose drivers stay, and they ask for nothing again.
extern "C" void tud_umount_cb() { torsio::usb::the_device->guest().begin_anew(); }

// Asked by the stack.
extern "C" const std::uint8_t* tud_descriptor_device_cb() {
  return torsio::usb::device_descriptor.data();
}

extern "C" const std::uint8_t* tud_descriptor_configuration_cb(std::uint8_t index) {
  if (index != 0) return nullptr;
  return torsio::device::configuration_descriptor(torsio::usb::personality, torsio::usb::wakes_host)
      .data();
}

extern "C" const std::uint16_t* tud_descriptor_string_cb(std::uint8_t index, std::uint16_t) {
  torsio::usb::string =
      torsio::device::string_descriptor(index, torsio::usb::serial, torsio::usb::personality);
  return torsio::usb::string.size_bytes == 0 ? nullptr : torsio::usb::string.units.data();
}
