// Refuses requests that the USB stack would answer against USB 2.0, chapter 9.
//
// TinyUSB 0.18 looks neither at the direction of standard requests, nor at most of their numbers. A
// host that sends GET_DESCRIPTOR with data *to* the device would have the stack write over the
// descriptor. The stack would set a configuration or a setting that does not exist. It would never
// answer a feature of an endpoint that does not exist. The linker puts this function in front of
// the one that takes every event of the bus (--wrap). A request to refuse is handed on as a
// vendor's request, because the stack refuses all of those.
#include <tusb.h>
// Behind tusb.h: the controller's driver.
#include <device/dcd.h>

#include <cstdint>

#include "device/usb_interfaces.hpp"
#include "usb/hid_driver.hpp"

namespace torsio::usb {
namespace {

std::uint8_t low_byte(std::uint16_t value) { return static_cast<std::uint8_t>(value); }

bool reads(std::uint8_t request) {
  return request == TUSB_REQ_GET_STATUS || request == TUSB_REQ_GET_DESCRIPTOR ||
         request == TUSB_REQ_GET_CONFIGURATION || request == TUSB_REQ_GET_INTERFACE;
}

bool sets_feature(const tusb_control_request_t& request) {
  return request.bRequest == TUSB_REQ_SET_FEATURE || request.bRequest == TUSB_REQ_CLEAR_FEATURE;
}

/// There is one configuration. The one feature is to wake the host, if the descriptor says so.
bool suits_device(const tusb_control_request_t& request) {
  if (request.bRequest == TUSB_REQ_SET_CONFIGURATION) return request.wValue <= 1;
  const auto type = static_cast<std::uint8_t>(request.wValue >> 8);
  const bool one_of_a_kind = type == TUSB_DESC_DEVICE || type == TUSB_DESC_CONFIGURATION;
  if (request.bRequest == TUSB_REQ_GET_DESCRIPTOR && one_of_a_kind) {
    return low_byte(request.wValue) == 0;
  }
  return !sets_feature(request) || (wakes_host && request.wValue == TUSB_REQ_FEATURE_REMOTE_WAKEUP);
}

/// Their one feature is the halt; the control endpoint has none. Both kinds of device have the
/// same.
bool suits_endpoint(const tusb_control_request_t& request) {
  if (request.wIndex == 0x00 || request.wIndex == 0x80) return !sets_feature(request);
  if (!is_open || (sets_feature(request) && request.wValue != 0)) return false;
  for (const device::HidInterface& interface : device::kInterfaces) {
    if (request.wIndex == interface.endpoint_in || request.wIndex == interface.endpoint_out) {
      return true;
    }
  }
  return false;
}

bool is_sound(const tusb_control_request_t& request) {
  const auto recipient = request.bmRequestType_bit.recipient;
  // The stack reads the low byte alone.
  if (recipient == TUSB_REQ_RCPT_INTERFACE && request.wIndex > 0xFF) return false;
  if (request.bmRequestType_bit.type != TUSB_REQ_TYPE_STANDARD) return true;
  const bool to_host = request.bmRequestType_bit.direction == TUSB_DIR_IN;
  if (reads(request.bRequest) != to_host || (!to_host && request.wLength != 0)) return false;
  if (recipient == TUSB_REQ_RCPT_DEVICE) return suits_device(request);
  if (recipient == TUSB_REQ_RCPT_ENDPOINT) return suits_endpoint(request);
  // There are no other settings.
  return request.bRequest != TUSB_REQ_SET_INTERFACE || request.wValue == 0;
}

}  // namespace
}  // namespace torsio::usb

extern "C" {

// NOLINTBEGIN: these names are the linker's.
void __real_dcd_event_handler(const dcd_event_t* event, bool in_isr);

void __wrap_dcd_event_handler(const dcd_event_t* event, bool in_isr) {
  if (event->event_id == DCD_EVENT_SETUP_RECEIVED &&
      !torsio::usb::is_sound(event->setup_received)) {
    // The driver's own variable, and not a constant.
    const_cast<dcd_event_t*>(event)->setup_received.bmRequestType_bit.type = TUSB_REQ_TYPE_VENDOR;
  }
  __real_dcd_event_handler(event, in_isr);
}
// NOLINTEND

}  // extern "C"
