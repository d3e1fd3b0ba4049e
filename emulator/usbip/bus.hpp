/// @file
/// The host's end of the cable to TinyUSB's device stack: packets to and from a USB device
/// controller made of software. TinyUSB keeps its state in globals, so this does too: one device in
/// a process, and one thread that uses it.
///
/// Nothing happens by itself. Let the stack look between two packets, with usb::UsbDevice::poll().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace torsio::emulator::usbip::bus {

inline constexpr std::size_t kPacketSize = 64;
inline constexpr std::uint8_t kEndpoints = 8;  // numbers, 0 included

enum class Handshake : std::uint8_t {
  ack,    // taken, or given
  nak,    // not now
  stall,  // refused, or there is no such endpoint
};

struct InPacket {
  Handshake handshake;
  std::size_t size;
};

/// The cable goes in: power and a bus reset.
void plug();
/// The cable comes out; all transfers under way are lost.
void unplug();

/// The host lets the bus sleep, or wakes it.
void suspend();
void resume();
/// Whether the device has asked to be woken since the last call.
bool take_wakeup();

/// Frames between two polls of an interrupt endpoint.
/// @param address with the direction bit
/// @returns 0 if there is no such endpoint now
std::uint8_t interval_frames(std::uint8_t address);

/// Whether an IN endpoint would give a packet now.
bool has_packet(std::uint8_t endpoint);

/// The first packet of a control transfer. A device must always take it.
void setup(const std::array<std::uint8_t, 8>& request);
/// One OUT packet of at most kPacketSize bytes.
Handshake out(std::uint8_t endpoint, std::span<const std::uint8_t> packet);
/// One IN packet into `packet`. A device that has more to give than fits is left as it is, as if
/// nobody had acknowledged, and `size` is larger than `packet` then.
InPacket in(std::uint8_t endpoint, std::span<std::uint8_t> packet);

}  // namespace torsio::emulator::usbip::bus
