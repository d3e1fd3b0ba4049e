#include "device/usb_descriptors.hpp"

#include <algorithm>
#include <string_view>

#include "device/hid_descriptor.hpp"
#include "device/usb_interfaces.hpp"
#include "protocol/usb_ids.hpp"

namespace torsio::device {
namespace {

using hid::Bytes;
using hid::high;
using hid::low;

constexpr std::uint8_t kDeviceType = 0x01;
constexpr std::uint8_t kConfigurationType = 0x02;
constexpr std::uint8_t kStringType = 0x03;
constexpr std::uint8_t kInterfaceType = 0x04;
constexpr std::uint8_t kEndpointType = 0x05;
constexpr std::uint8_t kHidType = 0x21;
constexpr std::uint8_t kReportType = 0x22;
constexpr std::uint8_t kHidClass = 0x03;
constexpr std::uint8_t kInterruptTransfer = 0x03;
// The logic lives on the bus; motor and brake have a supply of their own that feeds nothing back.
constexpr std::uint8_t kBusPowered = 0x80;
constexpr std::uint8_t kWakesHost = 0x20;
constexpr std::uint8_t kMaxPower2mA = 50;
constexpr std::uint16_t kEnglish = 0x0409;

constexpr std::size_t kHidDescriptorSize = 9;
constexpr std::size_t kInterfaceBlockSize = 9 + kHidDescriptorSize + 7 + 7;

constexpr std::size_t kConfigurationSize = 9 + kInterfaces.size() * kInterfaceBlockSize;

template <const std::array<HidInterface, kInterfaces.size()>& interfaces, std::uint8_t attributes>
consteval auto make_configuration_descriptor() {
  Bytes<kConfigurationSize> bytes;
  bytes.add({9, kConfigurationType, low(kConfigurationSize), high(kConfigurationSize),
             static_cast<std::uint8_t>(kInterfaces.size()), 1, 0, attributes, kMaxPower2mA});
  std::uint8_t number = 0;
  for (const HidInterface& interface : interfaces) {
    const std::size_t report_size = interface.report_descriptor.size();
    bytes.add({9, kInterfaceType, number++, 0, 2, kHidClass, 0, 0, interface.name});
    bytes.add({kHidDescriptorSize, kHidType, 0x11, 0x01, 0, 1, kReportType, low(report_size),
               high(report_size)});
    for (const std::uint8_t endpoint : {interface.endpoint_in, interface.endpoint_out}) {
      bytes.add({7, kEndpointType, endpoint, kInterruptTransfer, kEndpointSize, 0, 1});
    }
  }
  return bytes.take();
}

template <std::uint8_t attributes>
constexpr auto kConfigurationDescriptor = make_configuration_descriptor<kInterfaces, attributes>();
template <std::uint8_t attributes>
constexpr auto kDialConfigurationDescriptor =
    make_configuration_descriptor<kDialInterfaces, attributes>();

StringDescriptor make_string(std::string_view text) {
  StringDescriptor string;
  std::size_t at = 1;
  // Not by substr(), whose exception would end up in the firmware when it is optimised at link
  // time.
  for (const char c : std::span(text).first(std::min(text.size(), string.units.size() - 1))) {
    string.units[at++] = static_cast<unsigned char>(c);
  }
  string.size_bytes = 2 * at;
  string.units[0] = static_cast<std::uint16_t>((kStringType << 8) | string.size_bytes);
  return string;
}

}  // namespace

std::span<const HidInterface> usb_interfaces(Personality personality) {
  return personality == Personality::dial ? kDialInterfaces : kInterfaces;
}

std::array<std::uint8_t, kDeviceDescriptorSize> device_descriptor(
    const std::array<std::uint8_t, 3>& firmware_version) {
  const auto digit = [](std::uint8_t number) { return std::min<std::uint8_t>(number, 9); };
  const auto minor_patch =
      static_cast<std::uint8_t>((digit(firmware_version[1]) << 4) | digit(firmware_version[2]));
  return {kDeviceDescriptorSize,
          kDeviceType,
          0x00,  // USB 2.0
          0x02,
          0,  // class, subclass and protocol: see the interfaces
          0,
          0,
          kEndpointSize,  // of endpoint 0
          low(protocol::usb_vendor_id),
          high(protocol::usb_vendor_id),
          low(protocol::usb_product_id),
          high(protocol::usb_product_id),
          minor_patch,
          digit(firmware_version[0]),
          manufacturer,
          product,
          serial_number,
          1};
}

std::span<const std::uint8_t> configuration_descriptor(Personality personality, bool wakes_host) {
  constexpr std::uint8_t kWakes = kBusPowered | kWakesHost;
  if (personality == Personality::dial) {
    if (wakes_host) return kDialConfigurationDescriptor<kWakes>;
    return kDialConfigurationDescriptor<kBusPowered>;
  }
  if (wakes_host) return kConfigurationDescriptor<kWakes>;
  return kConfigurationDescriptor<kBusPowered>;
}

std::span<const std::uint8_t> hid_descriptor(std::uint8_t interface, Personality personality) {
  if (interface >= kInterfaces.size()) return {};
  return configuration_descriptor(personality)
      .subspan(9 + interface * kInterfaceBlockSize + 9, kHidDescriptorSize);
}

StringDescriptor string_descriptor(std::uint8_t index, std::span<const std::uint8_t> serial,
                                   Personality personality) {
  switch (index) {
    case languages: {
      StringDescriptor string = make_string(" ");
      string.units[1] = kEnglish;
      return string;
    }
    case manufacturer:
      return make_string(protocol::usb_manufacturer);
    case product:
      return make_string(protocol::usb_product);
    case serial_number: {
      std::array<char, 31> text{};
      std::size_t size = 0;
      for (const std::uint8_t byte : serial.first(std::min(serial.size(), text.size()))) {
        if (byte == 0) break;
        text[size++] = static_cast<char>(byte);
      }
      return make_string({text.data(), size});
    }
    case control_name:
      return make_string("Torsio control");
    case game_name:
      return make_string("Torsio game controller");
    case dial_name:
      if (personality != Personality::dial) return {};
      return make_string("Torsio dial");
    default:
      return {};
  }
}

}  // namespace torsio::device
