/// @file
/// The emulated device behind TinyUSB's stack: everything of a virtual knob but its sockets and its
/// clock. One in a process, as there is one USB stack.
#pragma once

#include <array>
#include <cstdint>

#include "device/usb_descriptors.hpp"
#include "emulator/emulated_device.hpp"
#include "emulator/usbip/host_controller.hpp"
#include "emulator/usbip/session.hpp"
#include "usb/usb_device.hpp"

namespace torsio::emulator::usbip {

class UsbKnob {
 public:
  static constexpr std::int64_t kFrameNs = UsbLink::kFrameNs;

  /// @throws std::invalid_argument that names what is out of its range
  explicit UsbKnob(EmulatedDeviceOptions options);
  UsbKnob(const UsbKnob&) = delete;
  UsbKnob& operator=(const UsbKnob&) = delete;

  /// Lets the world go on to so far behind the frame's begin, but not beyond its end.
  void go_on(std::int64_t in_frame_ns);
  /// Lets the rest of the frame of 1 ms pass in the knob's world, behind the packets of that frame.
  void advance();

  [[nodiscard]] EmulatedDevice& device() { return device_; }
  [[nodiscard]] HostController& host() { return host_; }
  /// For the sessions of a server.
  [[nodiscard]] Export& exported() { return export_; }
  /// A host has configured the device.
  [[nodiscard]] bool has_host() const { return usb_.has_host(); }

 private:
  EmulatedDevice device_;
  usb::UsbDevice usb_;
  HostController host_;
  std::array<std::uint8_t, device::kDeviceDescriptorSize> descriptor_;
  Export export_;
  std::int64_t in_frame_ns_ = 0;
};

}  // namespace torsio::emulator::usbip
