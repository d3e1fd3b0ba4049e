#include "emulator/usbip/usb_knob.hpp"

#include <algorithm>
#include <utility>

namespace torsio::emulator::usbip {
namespace {

// Where Linux would have it: the first port of the first bus.
constexpr std::string_view kPath = "/sys/devices/torsio/usb1/1-1";
constexpr std::string_view kBusId = "1-1";
constexpr std::uint32_t kDeviceNumber = 2;  // number 1 is a bus's root hub

}  // namespace

UsbKnob::UsbKnob(EmulatedDeviceOptions options)
    : device_(std::move(options)),
      usb_(device_.device(), device_.board()),
      host_(usb_),
      descriptor_(device::device_descriptor(device_.board().firmware_version)),
      export_{.record = {.path = kPath,
                         .bus_id = kBusId,
                         .device = kDeviceNumber,
                         .device_descriptor = descriptor_,
                         .configuration_descriptor =
                             device::configuration_descriptor(device_.device().personality())},
              .host = host_} {
  // Its own cable stays out; from here on the stack says whether there is a host.
  device_.set_plugged(false);
}

void UsbKnob::go_on(std::int64_t in_frame_ns) {
  in_frame_ns = std::min(in_frame_ns, kFrameNs);
  if (in_frame_ns <= in_frame_ns_) return;
  device_.advance(in_frame_ns - in_frame_ns_);
  in_frame_ns_ = in_frame_ns;
}

void UsbKnob::advance() {
  go_on(kFrameNs);
  in_frame_ns_ = 0;
  usb_.poll();
}

}  // namespace torsio::emulator::usbip
