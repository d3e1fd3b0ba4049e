/// @file Messages of a USB/IP client, most of them valid.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz.hpp"
#include "reports.hpp"
#include "tests/cpp/usbip/client.hpp"

namespace fuzz {

/// Begins of messages: a list, an import and its bus, requests that are to be known, and not to be.
inline constexpr std::string_view kUsbipWords[] = {
    bytes("\x01\x11\x80\x05\0\0\0\0"),  // list
    bytes("\x01\x11\x80\x03\0\0\0\0"),  // import
    bytes("1-1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"),
    bytes("\0\0\0\1"),                // submit; also IN
    bytes("\0\0\0\2"),                // unlink
    bytes("\0\1\0\2"),                // the device
    bytes("\xFF\xFF\xFF\xFF"),        // not isochronous
    bytes("\0\0\0\x40"),              // a report's length
    bytes("\0\1\0\0"),                // the longest transfer
    bytes("\x80\x06\0\1\0\0\x12\0"),  // the device's descriptor
    bytes("\0\x09\1\0\0\0\0\0"),      // configured
    bytes("\xA1\1\1\3\0\0\x40\0"),    // the identity
};

/// A transfer: what a driver asks when it gets to know the device, a report either way, or
/// something beside it.
inline usbip_test::Bytes transfer(FieldMaker& make, std::uint32_t sequence) {
  using namespace usbip_test;
  const std::array<Bytes, 8> setups{
      setup_packet(0x80, 6, 0x0100, 0, 18),    // the device's descriptor
      setup_packet(0x80, 6, 0x0200, 0, 255),   // the configuration's
      setup_packet(0x80, 6, 0x0301, 9, 255),   // a text
      setup_packet(0x81, 6, 0x2200, 0, 1024),  // a report's descriptor
      setup_packet(0x00, 9, 1, 0, 0),          // configured
      setup_packet(0x21, 0x0A, 0, 0, 0),       // no repeats while idle
      setup_packet(0xA1, 1, 0x0301, 0, 64),    // the identity
      setup_packet(0x02, 1, 0, 0x81, 0)};      // a halt is over
  auto direction = static_cast<std::uint32_t>(make.below(2));
  auto endpoint = static_cast<std::uint32_t>(make.below(4));
  std::uint32_t length = 64;
  Bytes setup(8);
  Bytes data;
  if (make.below(3) == 0) {
    endpoint = 0;
    setup = setups[make.below(setups.size())];
    direction = setup[0] >> 7U;
    length = setup[6] + 256U * setup[7];
  } else if (direction == 0) {
    const auto report = make.any();
    data.assign(report.begin(), report.end());
    if (endpoint == 0) {
      setup = setup_packet(0x21, 9, static_cast<std::uint16_t>(0x0300 + report[0]), 0, 64);
    }
  }
  if (make.below(16) == 0) length = static_cast<std::uint32_t>(make.bits());
  if (make.below(16) == 0) setup[make.below(8)] = static_cast<std::uint8_t>(make.bits());
  return submit_header(sequence, direction, endpoint, length, setup) + data;
}

inline usbip_test::Bytes message(FieldMaker& make) {
  const auto sequence = static_cast<std::uint32_t>(make.below(8));
  switch (make.below(12)) {
    case 0:
      return usbip_test::kListRequest;
    case 1:
      return usbip_test::import_request();
    case 2:
      return usbip_test::unlink_request(8 + sequence, static_cast<std::uint32_t>(make.below(8)));
    default:
      return transfer(make, sequence);
  }
}

}  // namespace fuzz
