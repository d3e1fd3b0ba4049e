#include "usb/hid_driver.hpp"

#include <tusb.h>
// Behind tusb.h: the interface for class drivers.
#include <device/usbd_pvt.h>

#include <array>

#include "device/usb_interfaces.hpp"

namespace torsio::usb {
namespace {

using device::kEndpointSize;

constexpr std::uint8_t kPort = 0;  // the only one that the device stack has

// USB 2.0, 9.4, and HID 1.11, sections 7.1 and 7.2.
constexpr std::uint8_t kGetStatus = 0x00;
constexpr std::uint8_t kGetDescriptor = 0x06;
constexpr std::uint8_t kHidType = 0x21;
constexpr std::uint8_t kReportType = 0x22;
constexpr std::uint8_t kGetReport = 0x01;
constexpr std::uint8_t kGetIdle = 0x02;
constexpr std::uint8_t kSetReport = 0x09;
constexpr std::uint8_t kSetIdle = 0x0A;
// Kinds of reports.
constexpr std::uint8_t kInput = 0x01;
constexpr std::uint8_t kOutput = 0x02;
constexpr std::uint8_t kFeature = 0x03;

struct Interface {
  device::HidFunction* function = nullptr;
  std::uint8_t endpoint_in = 0;  // 0: not open
  std::uint8_t endpoint_out = 0;
  bool holding = false;  // an output report waits for room
  std::uint8_t held_size = 0;
  std::size_t in_size = 0;  // an input report waits for its transfer to start
  alignas(4) std::array<std::uint8_t, kEndpointSize> out{};
  alignas(4) std::array<std::uint8_t, kEndpointSize> in{};
};

std::array<Interface, device::kInterfaces.size()> interfaces;
device::Personality personality = device::Personality::game_controller;
alignas(4) std::array<std::uint8_t, kEndpointSize> control;

std::uint8_t high_byte(std::uint16_t value) { return static_cast<std::uint8_t>(value >> 8); }
std::uint8_t low_byte(std::uint16_t value) { return static_cast<std::uint8_t>(value); }

/// Starts a transfer, unless the stack has not yet handled an event of the bus. After a reset the
/// controller's driver has no endpoints, while the stack still believes in them.
/// @returns false to try again in the next round
bool submit(std::uint8_t endpoint, std::array<std::uint8_t, kEndpointSize>& bytes,
            std::size_t size) {
  usbd_int_set(false);
  const bool started =
      !tud_task_event_ready() && !usbd_edpt_busy(kPort, endpoint) &&
      usbd_edpt_xfer(kPort, endpoint, bytes.data(), static_cast<std::uint16_t>(size));
  usbd_int_set(true);
  return started;
}

/// Keeps the endpoint's buffer until the report in it has found room.
void take_output(Interface& interface) {
  if (interface.holding) {
    interface.holding =
        !interface.function->receive(std::span(interface.out).first(interface.held_size));
  }
  if (!interface.holding) (void)submit(interface.endpoint_out, interface.out, kEndpointSize);
}

void give_input(Interface& interface) {
  if (!tud_ready() || usbd_edpt_busy(kPort, interface.endpoint_in)) return;
  if (interface.in_size == 0) interface.in_size = interface.function->next_input(interface.in);
  if (interface.in_size == 0) return;
  if (submit(interface.endpoint_in, interface.in, interface.in_size)) interface.in_size = 0;
}

// Called by TinyUSB -------------------------------------------------------------------------

void init() {}
bool deinit() { return true; }

void reset(std::uint8_t) {
  is_open = false;
  for (Interface& interface : interfaces) {
    if (interface.endpoint_in != 0) interface.function->input_over(false);
    interface.endpoint_in = 0;
    interface.endpoint_out = 0;
    interface.holding = false;
    interface.in_size = 0;
  }
}

std::uint16_t open(std::uint8_t port, const tusb_desc_interface_t* descriptor,
                   std::uint16_t max_size) {
  const std::uint8_t number = descriptor->bInterfaceNumber;
  if (descriptor->bInterfaceClass != TUSB_CLASS_HID || number >= interfaces.size()) return 0;
  Interface& interface = interfaces[number];
  const auto size = static_cast<std::uint16_t>(
      sizeof(tusb_desc_interface_t) + device::hid_descriptor(number, personality).size() +
      descriptor->bNumEndpoints * sizeof(tusb_desc_endpoint_t));
  if (interface.function == nullptr || max_size < size) return 0;

  const auto* at = reinterpret_cast<const std::uint8_t*>(descriptor);
  at = tu_desc_next(tu_desc_next(at));  // behind interface and HID descriptor
  if (!usbd_open_edpt_pair(port, at, descriptor->bNumEndpoints, TUSB_XFER_INTERRUPT,
                           &interface.endpoint_out, &interface.endpoint_in)) {
    return 0;
  }
  is_open = true;
  return size;  // poll_hid() makes the endpoint listen
}

bool get_descriptor(std::uint8_t port, const tusb_control_request_t& request, std::uint8_t number) {
  std::span<const std::uint8_t> bytes;
  if (low_byte(request.wValue) != 0) return false;  // there is one of each
  if (high_byte(request.wValue) == kHidType) bytes = device::hid_descriptor(number, personality);
  if (high_byte(request.wValue) == kReportType) {
    bytes = device::usb_interfaces(personality)[number].report_descriptor;
  }
  if (bytes.empty()) return false;
  // The stack only reads what goes to the host.
  return tud_control_xfer(port, &request, const_cast<std::uint8_t*>(bytes.data()),
                          static_cast<std::uint16_t>(bytes.size()));
}

/// USB 2.0, 9.4.5: an interface has no status, and says so.
bool get_status(std::uint8_t port, const tusb_control_request_t& request) {
  control[0] = control[1] = 0;
  return tud_control_xfer(port, &request, control.data(), 2);
}

bool get_report(std::uint8_t port, const tusb_control_request_t& request, Interface& interface) {
  const std::uint8_t id = low_byte(request.wValue);
  std::size_t size = 0;
  if (high_byte(request.wValue) == kFeature) size = interface.function->get_feature(id, control);
  if (high_byte(request.wValue) == kInput) size = interface.function->get_input(id, control);
  return size != 0 &&
         tud_control_xfer(port, &request, control.data(), static_cast<std::uint16_t>(size));
}

bool announce_report(std::uint8_t port, const tusb_control_request_t& request) {
  const std::uint8_t kind = high_byte(request.wValue);
  if (kind != kFeature && kind != kOutput) return false;
  if (request.wLength == 0 || request.wLength > control.size()) return false;
  // The stack does not say how much came. A host that sends less than it announced leaves these
  // bytes where a report must be zero.
  control.fill(0xFF);
  return tud_control_xfer(port, &request, control.data(), request.wLength);
}

bool set_report(const tusb_control_request_t& request, Interface& interface) {
  if (control[0] != low_byte(request.wValue)) return false;
  const std::span<const std::uint8_t> report = std::span(control).first(request.wLength);
  if (high_byte(request.wValue) == kFeature) return interface.function->set_feature(report);
  // One that waits for room stands before it.
  return !interface.holding && interface.function->receive(report);
}

/// USB 2.0, 9.4. Like the next two it returns false to stall.
bool standard_request(std::uint8_t port, const tusb_control_request_t& request,
                      std::uint8_t number) {
  const bool in = request.bmRequestType_bit.direction == TUSB_DIR_IN;
  if (request.bRequest == kGetStatus) return in && get_status(port, request);
  return in && request.bRequest == kGetDescriptor && get_descriptor(port, request, number);
}

/// HID 1.11, 7.2, before its data.
bool class_request(std::uint8_t port, const tusb_control_request_t& request, Interface& interface) {
  const bool in = request.bmRequestType_bit.direction == TUSB_DIR_IN;
  switch (request.bRequest) {
    case kGetReport:
      return in && get_report(port, request, interface);
    case kSetReport:
      return !in && announce_report(port, request);
    case kGetIdle:
      control[0] = 0;
      return in && tud_control_xfer(port, &request, control.data(), 1);
    case kSetIdle:
      // Reports go when there is something new: a rate of 0 means that.
      return !in && high_byte(request.wValue) == 0 && tud_control_status(port, &request);
    default:
      return false;
  }
}

bool control_request(std::uint8_t port, std::uint8_t stage, const tusb_control_request_t* request) {
  const std::uint8_t number = low_byte(request->wIndex);
  const std::uint8_t type = request->bmRequestType_bit.type;
  if (request->bmRequestType_bit.recipient != TUSB_REQ_RCPT_INTERFACE ||
      number >= interfaces.size()) {
    return false;
  }
  if (type == TUSB_REQ_TYPE_STANDARD) {
    return stage != CONTROL_STAGE_SETUP || standard_request(port, *request, number);
  }
  if (type != TUSB_REQ_TYPE_CLASS) return false;
  if (stage == CONTROL_STAGE_SETUP) return class_request(port, *request, interfaces[number]);
  const bool has_report = stage == CONTROL_STAGE_DATA && request->bRequest == kSetReport;
  return !has_report || set_report(*request, interfaces[number]);
}

bool transfer_done(std::uint8_t, std::uint8_t endpoint, xfer_result_t result, std::uint32_t size) {
  for (Interface& interface : interfaces) {
    if (endpoint == interface.endpoint_out && endpoint != 0) {
      interface.holding = result == XFER_RESULT_SUCCESS;
      interface.held_size = static_cast<std::uint8_t>(size);
      return true;
    }
    if (endpoint == interface.endpoint_in && endpoint != 0) {
      interface.function->input_over(true);
      return true;
    }
  }
  return false;
}

constexpr usbd_class_driver_t kDriver{"torsio HID",    init,          deinit, reset, open,
                                      control_request, transfer_done, nullptr};

}  // namespace

bool is_open = false;

void set_hid_function(std::uint8_t interface, device::HidFunction& function) {
  interfaces[interface].function = &function;
}

void set_personality(device::Personality chosen) { personality = chosen; }

void poll_hid() {
  for (Interface& interface : interfaces) {
    if (interface.endpoint_in == 0) continue;
    take_output(interface);
    give_input(interface);
  }
}

}  // namespace torsio::usb

extern "C" const usbd_class_driver_t* usbd_app_driver_get_cb(std::uint8_t* count) {
  *count = 1;
  return &torsio::usb::kDriver;
}
