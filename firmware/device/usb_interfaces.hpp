/// @file
/// The device's HID interfaces, with their report descriptors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>

#include "device/dial/report_descriptor.hpp"
#include "device/game/report_descriptor.hpp"
#include "device/hid_descriptor.hpp"
#include "device/usb_descriptors.hpp"
#include "protocol/registry.hpp"
#include "protocol/usb_ids.hpp"

namespace torsio::device {

/// The strings that descriptors name.
enum StringIndex : std::uint8_t {
  languages,
  manufacturer,
  product,
  serial_number,
  control_name,
  game_name,
  dial_name
};

namespace detail {

constexpr std::uint8_t main_item(protocol::Direction direction) {
  switch (direction) {
    case protocol::Direction::input:
      return static_cast<std::uint8_t>(hid::Main::input);
    case protocol::Direction::output:
      return static_cast<std::uint8_t>(hid::Main::output);
    case protocol::Direction::feature:
      return static_cast<std::uint8_t>(hid::Main::feature);
  }
  return 0;
}

constexpr std::size_t kReports = std::tuple_size_v<protocol::AllReports>;

consteval auto make_control_report_descriptor() {
  hid::Bytes<17 + 6 * kReports> bytes;
  bytes.add({0x06, hid::low(protocol::usb_usage_page), hid::high(protocol::usb_usage_page)});
  bytes.add({0x09, protocol::usb_usage});
  bytes.add({0xA1, 0x01});        // collection (application)
  bytes.add({0x15, 0x00});        // logical minimum
  bytes.add({0x26, 0xFF, 0x00});  // logical maximum
  bytes.add({0x75, 0x08});        // report size, bits
  bytes.add({0x95, static_cast<std::uint8_t>(protocol::report_size - 1)});  // report count
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    // Data, variable, absolute; the usage is the report's number.
    bytes.add({0x85, protocol::Layout<Report>::id, 0x09, protocol::Layout<Report>::id,
               main_item(protocol::Layout<Report>::direction), 0x02});
  });
  bytes.add({0xC0});
  return bytes.take();
}

}  // namespace detail

inline constexpr auto kControlReportDescriptor = detail::make_control_report_descriptor();

inline constexpr HidInterface kControl{0x81, 0x01, control_name, kControlReportDescriptor};

/// With a joystick, and with a dial. To add an interface, add a line to each.
inline constexpr std::array kInterfaces{
    kControl,
    HidInterface{0x82, 0x02, game_name, game::kReportDescriptor},
};
inline constexpr std::array kDialInterfaces{
    kControl,
    HidInterface{0x82, 0x02, dial_name, dial::kReportDescriptor},
};
static_assert(kInterfaces.size() == kDialInterfaces.size());

}  // namespace torsio::device
