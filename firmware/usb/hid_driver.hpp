/// @file
/// A HID class driver for TinyUSB's device stack, for any number of interfaces with an interrupt
/// endpoint each way. Unlike TinyUSB's own it answers a report only after reading it. A malformed
/// SET_REPORT is stalled in its status stage. An output report without room is held back, so that
/// the host waits.
#pragma once

#include <cstdint>

#include "device/hid_function.hpp"
#include "device/usb_descriptors.hpp"

namespace torsio::usb {

/// Whether a host has configured the device, so that the endpoints are open.
extern bool is_open;

/// Whether the device may wake a host that sleeps, from the start on.
inline bool wakes_host = false;

/// Says what stands behind an interface. Before the stack starts.
void set_hid_function(std::uint8_t interface, device::HidFunction& function);

/// The descriptors for the host. Before the stack starts.
void set_personality(device::Personality personality);

/// Moves reports both ways as far as there is room. In every round of the main loop.
void poll_hid();

}  // namespace torsio::usb
