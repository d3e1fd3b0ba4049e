/// @file
/// A virtual knob with a client that has set its configuration, and the bytes of its reports.
#pragma once

#include <cstdint>

#include "client.hpp"

namespace usbip_test {

constexpr std::int32_t kStall = -32;

struct Rig {
  torsio::emulator::usbip::UsbKnob knob{{.serial = "RIG-1"}};
  Client client{knob};
  Rig() {
    client.attach();
    client.configure();
  }
};

inline Bytes command(std::uint8_t sequence, std::uint8_t op) {
  return padded({0x10, sequence, 0, 0, op}, 64);
}
constexpr std::uint8_t kArm = 1;
constexpr std::uint8_t kDisarm = 2;

}  // namespace usbip_test
