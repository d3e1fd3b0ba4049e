/// @file
/// The device on TinyUSB's device stack. One source for the boards and for the virtual knob; all
/// of it belongs to the main loop. TinyUSB keeps its state in globals, so there is one USB device
/// in a process.
#pragma once

#include <cstdint>

#include "device/device.hpp"

namespace torsio::usb {

/// The vendor interface: the protocol's reports, into a device and out of it.
///
/// A report lies in the endpoint's buffer, where nothing reaches it any more, until the host asks
/// for it, once in a frame. So prompt telemetry is put there as late as possible: a quarter of a
/// frame before the host's next request is due.
class ControlFunction final : public device::HidFunction {
 public:
  ControlFunction(device::Device& device, std::uint32_t control_period_ns);

  std::size_t get_feature(std::uint8_t id, std::span<std::uint8_t> report) override;
  std::size_t get_input(std::uint8_t id, std::span<std::uint8_t> report) override;
  bool set_feature(std::span<const std::uint8_t> report) override;
  bool receive(std::span<const std::uint8_t> report) override;
  std::size_t next_input(std::span<std::uint8_t> report) override;
  void input_over(bool taken) override;

 private:
  device::Device& device_;
  std::uint32_t early_ticks_;  // so long after a report was taken it is early for the next
  std::uint64_t taken_at_tick_ = 0;
};

class UsbDevice {
 public:
  /// Starts the stack; the device appears on the bus. `device` must outlive the stack.
  UsbDevice(device::Device& device, const device::BoardInfo& board);
  UsbDevice(const UsbDevice&) = delete;
  UsbDevice& operator=(const UsbDevice&) = delete;

  /// One round of the main loop: bus events, reports both ways, and whether there is a host.
  void poll();

  /// A host has configured the device and is awake.
  bool has_host() const;

 private:
  device::Device& device_;
  void wake_host();

  bool connected_ = false;  // the state that the device was told last
  bool asleep_ = false;
  std::uint64_t asleep_tick_ = 0;
  std::uint32_t still_ticks_;  // before which a bus that sleeps must not be woken
  device::Device::Touch touched_;
  ControlFunction control_;
};

}  // namespace torsio::usb
