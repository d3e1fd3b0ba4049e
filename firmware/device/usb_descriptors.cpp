#include "device/usb_descriptors.hpp"

#include <algorithm>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "device/dial/report_descriptor.hpp"
#include "device/game/report_descriptor.hpp"
#include "protocol/registry.hpp"
#include "protocol/usb_ids.hpp"

namespace torsio::device {
namespace {

using protocol::Direction;
using protocol::Layout;

enum StringIndex : std::uint8_t {
  languages,
  manufacturer,
  product,
  serial_number,
  control_name,
  game_name,
  dial_name
};

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
constexpr std::uint8_t kMaxPower2mA = 50;
constexpr std::uint16_t kEnglish = 0x0409;

constexpr std::size_t kHidDescriptorSize = 9;
constexpr std::size_t kInterfaceBlockSize = 9 + kHidDescriptorSize + 7 + 7;

constexpr std::uint8_t low(std::size_t value) { return static_cast<std::uint8_t>(value); }
constexpr std::uint8_t high(std::size_t value) { return static_cast<std::uint8_t>(value >> 8); }

/// Bytes one after the other into an array of known size.
template <std::size_t Size>
class Bytes {
 public:
  constexpr void add(std::initializer_list<std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) bytes_[at_++] = byte;
  }
  consteval std::array<std::uint8_t, Size> take() const {
    // A gap fails to compile, as an overflow in add() does.
    return at_ == Size ? bytes_ : std::array<std::uint8_t, Size>{bytes_[Size + at_]};
  }

 private:
  std::array<std::uint8_t, Size> bytes_{};
  std::size_t at_ = 0;
};

// HID report descriptor items (HID 1.11, section 6.2.2).
constexpr std::uint8_t main_item(Direction direction) {
  switch (direction) {
    case Direction::input:
      return 0x81;
    case Direction::output:
      return 0x91;
    case Direction::feature:
      return 0xB1;
  }
  return 0;
}

constexpr std::size_t kReports = std::tuple_size_v<protocol::AllReports>;

consteval auto make_control_report_descriptor() {
  Bytes<17 + 6 * kReports> bytes;
  bytes.add({0x06, low(protocol::usb_usage_page), high(protocol::usb_usage_page)});
  bytes.add({0x09, protocol::usb_usage});
  bytes.add({0xA1, 0x01});        // collection (application)
  bytes.add({0x15, 0x00});        // logical minimum
  bytes.add({0x26, 0xFF, 0x00});  // logical maximum
  bytes.add({0x75, 0x08});        // report size, bits
  bytes.add({0x95, static_cast<std::uint8_t>(protocol::report_size - 1)});  // report count
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    // Data, variable, absolute; the usage is the report's number.
    bytes.add({0x85, Layout<Report>::id, 0x09, Layout<Report>::id,
               main_item(Layout<Report>::direction), 0x02});
  });
  bytes.add({0xC0});
  return bytes.take();
}

constexpr auto kControlReportDescriptor = make_control_report_descriptor();

constexpr HidInterface kControl{0x81, 0x01, control_name, kControlReportDescriptor};

// To add an interface, add a line to each.
constexpr std::array kInterfaces{
    kControl,
    HidInterface{0x82, 0x02, game_name, game::kReportDescriptor},
};
constexpr std::array kDialInterfaces{
    kControl,
    HidInterface{0x82, 0x02, dial_name, dial::kReportDescriptor},
};
static_assert(kInterfaces.size() > kControlInterface && kInterfaces.size() > kGameInterface);

constexpr std::size_t kConfigurationSize = 9 + kInterfaces.size() * kInterfaceBlockSize;

template <const std::array<HidInterface, kInterfaces.size()>& interfaces>
consteval auto make_configuration_descriptor() {
  Bytes<kConfigurationSize> bytes;
  bytes.add({9, kConfigurationType, low(kConfigurationSize), high(kConfigurationSize),
             static_cast<std::uint8_t>(kInterfaces.size()), 1, 0, kBusPowered, kMaxPower2mA});
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

constexpr auto kConfigurationDescriptor = make_configuration_descriptor<kInterfaces>();
constexpr auto kDialConfigurationDescriptor = make_configuration_descriptor<kDialInterfaces>();

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

std::span<const std::uint8_t> configuration_descriptor(Personality personality) {
  return personality == Personality::dial ? kDialConfigurationDescriptor : kConfigurationDescriptor;
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
