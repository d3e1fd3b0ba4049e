#include "emulator/usbip/bus.hpp"

#include <tusb.h>
// Behind tusb.h: what a device controller's driver provides, and what it may call.
#include <device/dcd.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace torsio::emulator::usbip::bus {
namespace {

constexpr std::uint8_t kPort = 0;  // the only one that the device stack has

/// One direction of an endpoint.
struct Endpoint {
  std::uint8_t interval_frames = 0;  // 0: closed
  bool stalled = false;
  bool armed = false;  // the stack waits for a packet, or has one
  std::uint8_t* buffer = nullptr;
  std::uint16_t size = 0;
};

struct Controller {
  std::array<std::array<Endpoint, 2>, kEndpoints> endpoints{};  // by number and direction

  void close_all() {
    for (std::size_t number = 1; number < endpoints.size(); ++number) endpoints[number] = {};
  }
  void reset() {
    close_all();
    endpoints[0] = {Endpoint{.interval_frames = 1}, Endpoint{.interval_frames = 1}};
  }
};

Controller controller;
bool wakeup = false;

Endpoint* find(std::uint8_t address) {
  const std::uint8_t number = tu_edpt_number(address);
  return number < kEndpoints ? &controller.endpoints[number][tu_edpt_dir(address)] : nullptr;
}

void complete(std::uint8_t address, Endpoint& endpoint, std::size_t size) {
  endpoint.armed = false;
  dcd_event_xfer_complete(kPort, address, static_cast<std::uint32_t>(size), XFER_RESULT_SUCCESS,
                          false);
}

}  // namespace

void plug() {
  controller.reset();
  dcd_event_bus_reset(kPort, TUSB_SPEED_FULL, false);
}

void unplug() {
  controller = {};
  dcd_event_bus_signal(kPort, DCD_EVENT_UNPLUGGED, false);
}

bool take_wakeup() { return std::exchange(wakeup, false); }
void suspend() { dcd_event_bus_signal(kPort, DCD_EVENT_SUSPEND, false); }
void resume() { dcd_event_bus_signal(kPort, DCD_EVENT_RESUME, false); }

std::uint8_t interval_frames(std::uint8_t address) {
  const Endpoint* endpoint = find(address);
  return endpoint == nullptr ? std::uint8_t{0} : endpoint->interval_frames;
}

bool has_packet(std::uint8_t endpoint) {
  const Endpoint* found = find(endpoint | TUSB_DIR_IN_MASK);
  return found != nullptr && found->interval_frames != 0 && !found->stalled && found->armed;
}

void setup(const std::array<std::uint8_t, 8>& request) {
  if (interval_frames(0) == 0) return;
  for (Endpoint& direction : controller.endpoints[0]) {
    direction.stalled = false;
    direction.armed = false;
  }
  dcd_event_setup_received(kPort, request.data(), false);
}

Handshake out(std::uint8_t number, std::span<const std::uint8_t> packet) {
  Endpoint* endpoint = find(number);
  if (endpoint == nullptr || endpoint->interval_frames == 0 || endpoint->stalled) {
    return Handshake::stall;
  }
  if (!endpoint->armed) return Handshake::nak;
  // Hardware never writes behind the buffer; the rest is lost.
  const std::size_t size = std::min<std::size_t>(packet.size(), endpoint->size);
  std::copy_n(packet.begin(), size, endpoint->buffer);
  complete(number, *endpoint, size);
  return Handshake::ack;
}

InPacket in(std::uint8_t number, std::span<std::uint8_t> packet) {
  const std::uint8_t address = number | TUSB_DIR_IN_MASK;
  Endpoint* endpoint = find(address);
  if (endpoint == nullptr || endpoint->interval_frames == 0 || endpoint->stalled) {
    return {Handshake::stall, 0};
  }
  if (!endpoint->armed) return {Handshake::nak, 0};
  const std::size_t size = endpoint->size;
  if (size > packet.size()) return {Handshake::ack, size};
  std::copy_n(endpoint->buffer, size, packet.begin());
  complete(address, *endpoint, size);
  return {Handshake::ack, size};
}

}  // namespace torsio::emulator::usbip::bus

// Called by the stack --------------------------------------------------------------------------

using torsio::emulator::usbip::bus::controller;
using torsio::emulator::usbip::bus::Endpoint;
using torsio::emulator::usbip::bus::find;
using torsio::emulator::usbip::bus::kPacketSize;
using torsio::emulator::usbip::bus::wakeup;

extern "C" {

std::uint32_t tusb_time_millis_api() {
  using namespace std::chrono;
  return static_cast<std::uint32_t>(
      duration_cast<milliseconds>(steady_clock::now().time_since_epoch()).count());
}

bool dcd_init(std::uint8_t, const tusb_rhport_init_t*) {
  controller = {};
  return true;
}
bool dcd_deinit(std::uint8_t) { return true; }
void dcd_int_handler(std::uint8_t) {}
// There is one thread, and no interrupt.
void dcd_int_enable(std::uint8_t) {}
void dcd_int_disable(std::uint8_t) {}
void dcd_remote_wakeup(std::uint8_t) { wakeup = true; }
void dcd_connect(std::uint8_t) {}
void dcd_disconnect(std::uint8_t) {}
void dcd_sof_enable(std::uint8_t, bool) {}

void dcd_set_address(std::uint8_t port, std::uint8_t) {
  // No other device shares the bus: only the status stage is left to do.
  (void)dcd_edpt_xfer(port, TUSB_DIR_IN_MASK, nullptr, 0);
}

bool dcd_edpt_open(std::uint8_t, const tusb_desc_endpoint_t* descriptor) {
  Endpoint* endpoint = find(descriptor->bEndpointAddress);
  if (endpoint == nullptr) return false;
  *endpoint = {.interval_frames = std::max<std::uint8_t>(descriptor->bInterval, 1)};
  return true;
}

void dcd_edpt_close(std::uint8_t, std::uint8_t address) {
  if (Endpoint* endpoint = find(address)) *endpoint = {};
}

void dcd_edpt_close_all(std::uint8_t) { controller.close_all(); }

bool dcd_edpt_xfer(std::uint8_t, std::uint8_t address, std::uint8_t* buffer, std::uint16_t size) {
  Endpoint* endpoint = find(address);
  if (endpoint == nullptr || endpoint->interval_frames == 0 || size > kPacketSize) return false;
  endpoint->armed = true;
  endpoint->buffer = buffer;
  endpoint->size = size;
  return true;
}

void dcd_edpt_stall(std::uint8_t, std::uint8_t address) {
  if (Endpoint* endpoint = find(address)) {
    endpoint->stalled = true;
    endpoint->armed = false;
  }
}

void dcd_edpt_clear_stall(std::uint8_t, std::uint8_t address) {
  if (Endpoint* endpoint = find(address)) {
    endpoint->stalled = false;
    endpoint->armed = false;
  }
}

}  // extern "C"
