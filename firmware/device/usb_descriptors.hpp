/// @file
/// The device's descriptors for a host: plain bytes, made from the list of reports, for any USB
/// stack.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/enumerations.hpp"
#include "protocol/layout.hpp"

namespace torsio::device {

inline constexpr std::uint8_t kEndpointSize = 64;
static_assert(kEndpointSize == protocol::report_size);

/// A HID interface, with one interrupt endpoint each way. Its number is its place in
/// usb_interfaces().
struct HidInterface {
  std::uint8_t endpoint_in = 0;   // address, direction bit included
  std::uint8_t endpoint_out = 0;  // address
  std::uint8_t name = 0;          // index of a string
  std::span<const std::uint8_t> report_descriptor;
};

inline constexpr std::uint8_t kControlInterface = 0;  // the vendor interface that the SDK talks to
inline constexpr std::uint8_t kGameInterface = 1;     // joystick with force feedback, or a dial

using protocol::Personality;

/// Every interface of the configuration, by number.
std::span<const HidInterface> usb_interfaces(
    Personality personality = Personality::game_controller);

inline constexpr std::size_t kDeviceDescriptorSize = 18;

/// @param firmware_version major, minor, patch; minor and patch show as one digit, at most 9
std::array<std::uint8_t, kDeviceDescriptorSize> device_descriptor(
    const std::array<std::uint8_t, 3>& firmware_version);

/// The configuration with its interfaces, HID descriptors and endpoints, as one block.
/// @param wakes_host it says that the device may wake a host that sleeps
std::span<const std::uint8_t> configuration_descriptor(
    Personality personality = Personality::game_controller, bool wakes_host = false);

/// The HID descriptor of an interface, as it stands in the configuration.
/// @returns nothing for an interface that does not exist
std::span<const std::uint8_t> hid_descriptor(
    std::uint8_t interface, Personality personality = Personality::game_controller);

/// A string descriptor: length and type in the first unit, then UTF-16.
struct StringDescriptor {
  std::array<std::uint16_t, 32> units{};
  std::size_t size_bytes = 0;  // 0: there is no such string
};

/// @param index  0 the languages, 1 manufacturer, 2 product, 3 serial number, then interface names
/// @param serial ASCII, padded with zeros
StringDescriptor string_descriptor(std::uint8_t index, std::span<const std::uint8_t> serial,
                                   Personality personality = Personality::game_controller);

}  // namespace torsio::device
