// The descriptors are read here the way a host reads them, and compared with values from the
// USB 2.0 and HID 1.11 specifications.
#include <doctest/doctest.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "device/usb_descriptors.hpp"
#include "protocol/registry.hpp"
#include "protocol/usb_ids.hpp"

namespace {

using namespace torsio;
using Bytes = std::span<const std::uint8_t>;

unsigned u16(Bytes bytes, std::size_t at) { return bytes[at] | (unsigned{bytes[at + 1]} << 8); }

/// Descriptors of a block, each by its own length.
std::vector<Bytes> split(Bytes block) {
  std::vector<Bytes> parts;
  while (!block.empty()) {
    REQUIRE(block[0] >= 2);
    REQUIRE(block[0] <= block.size());
    parts.push_back(block.first(block[0]));
    block = block.subspan(block[0]);
  }
  return parts;
}

struct HidReport {
  unsigned usage_page = 0;
  unsigned usage = 0;
  unsigned bits = 0;
  unsigned logical_max = 0;
  unsigned flags = 0;
};

/// A host's parser of report descriptors, as far as this device needs one (HID 1.11, 6.2.2.2).
struct HidParser {
  explicit HidParser(Bytes bytes) {
    constexpr unsigned sizes[] = {0, 1, 2, 4};
    unsigned page = 0;
    unsigned usage = 0;
    unsigned size = 0;
    unsigned count = 0;
    unsigned id = 0;
    unsigned maximum = 0;
    int depth = 0;
    for (std::size_t at = 0; at < bytes.size();) {
      const unsigned prefix = bytes[at++];
      const unsigned length = sizes[prefix & 3];
      unsigned value = 0;
      for (unsigned i = 0; i < length; ++i) value |= unsigned{bytes[at++]} << (8 * i);
      switch (prefix & 0xFC) {
        case 0x04:
          page = value;
          break;
        case 0x08:
          usage = value;
          break;
        case 0x14:
          CHECK(value == 0);
          break;
        case 0x24:
          maximum = value;
          break;
        case 0x74:
          size = value;
          break;
        case 0x84:
          id = value;
          break;
        case 0x94:
          count = value;
          break;
        case 0xA0:
          ++depth;
          collections.emplace_back(page, usage, value);
          break;
        case 0xC0:
          --depth;
          break;
        case 0x80:
        case 0x90:
        case 0xB0: {
          const char kind = (prefix & 0xFC) == 0x80 ? 'i' : (prefix & 0xFC) == 0x90 ? 'o' : 'f';
          const bool is_new = reports
                                  .emplace(std::pair{kind, id},
                                           HidReport{page, usage, size * count, maximum, value})
                                  .second;
          CHECK(is_new);
          CHECK(depth > 0);
          break;
        }
        default:
          FAIL("unknown item ", prefix);
      }
    }
    CHECK(depth == 0);
  }

  std::vector<std::tuple<unsigned, unsigned, unsigned>> collections;
  std::map<std::pair<char, unsigned>, HidReport> reports;
};

std::string text(const device::StringDescriptor& string) {
  std::string result;
  for (std::size_t i = 1; i < string.size_bytes / 2; ++i) {
    result += static_cast<char>(string.units[i]);
  }
  return result;
}

}  // namespace

TEST_CASE("the device descriptor names a full-speed USB 2.0 device with the test product id") {
  const auto bytes = device::device_descriptor({1, 2, 3});
  const Bytes d(bytes);
  CHECK(d[0] == 18);
  CHECK(d[1] == 1);
  CHECK(u16(d, 2) == 0x0200);
  CHECK(d[4] == 0);
  CHECK(d[7] == 64);
  CHECK(u16(d, 8) == torsio::protocol::usb_vendor_id);
  CHECK(u16(d, 10) == torsio::protocol::usb_product_id);
  CHECK(u16(d, 12) == 0x0123);
  CHECK(d[14] == 1);
  CHECK(d[15] == 2);
  CHECK(d[16] == 3);
  CHECK(d[17] == 1);
}

TEST_CASE("the device descriptor's version stays decimal beyond nine") {
  const auto d = device::device_descriptor({12, 10, 99});
  CHECK(u16(d, 12) == 0x0999);
}

TEST_CASE("the configuration is two HID interfaces with interrupt endpoints every millisecond") {
  const auto parts = split(device::configuration_descriptor());
  REQUIRE(parts.size() == 9);
  const Bytes configuration = parts[0];
  CHECK(configuration[1] == 2);
  CHECK(u16(configuration, 2) == device::configuration_descriptor().size());
  CHECK(configuration[4] == 2);
  CHECK(configuration[5] == 1);
  CHECK(configuration[7] == 0x80);
  CHECK(configuration[8] * 2 <= 500);

  for (std::uint8_t number = 0; number < 2; ++number) {
    const std::size_t at = 1 + std::size_t{4} * number;
    const Bytes interface = parts[at];
    CHECK(interface.size() == 9);
    CHECK(interface[1] == 4);
    CHECK(interface[2] == number);
    CHECK(interface[4] == 2);
    CHECK(interface[5] == 3);
    CHECK(interface[6] == 0);
    CHECK(interface[8] == 4 + number);

    const Bytes hid = parts[at + 1];
    CHECK(hid.size() == 9);
    CHECK(hid[1] == 0x21);
    CHECK(u16(hid, 2) == 0x0111);
    CHECK(hid[5] == 1);
    CHECK(hid[6] == 0x22);
    CHECK(u16(hid, 7) == device::usb_interfaces()[number].report_descriptor.size());

    const unsigned addresses[] = {0x81U + number, 0x01U + number};
    for (std::size_t i = 0; i < 2; ++i) {
      const Bytes endpoint = parts[at + 2 + i];
      CHECK(endpoint.size() == 7);
      CHECK(endpoint[1] == 5);
      CHECK(endpoint[2] == addresses[i]);
      CHECK(endpoint[3] == 3);
      CHECK(u16(endpoint, 4) == 64);
      CHECK(endpoint[6] == 1);
    }
  }
}

TEST_CASE("a HID descriptor on its own is the one in the configuration") {
  const auto parts = split(device::configuration_descriptor());
  for (std::uint8_t number = 0; number < 2; ++number) {
    const Bytes alone = device::hid_descriptor(number);
    const Bytes inside = parts[2 + std::size_t{4} * number];
    CHECK(std::equal(alone.begin(), alone.end(), inside.begin(), inside.end()));
  }
  CHECK(device::hid_descriptor(2).empty());
}

TEST_CASE("the report descriptor declares every report once, 63 bytes behind its id") {
  const HidParser parsed(device::usb_interfaces()[0].report_descriptor);
  REQUIRE(parsed.collections.size() == 1);
  CHECK(parsed.collections[0] == std::tuple{0xFF00U, 1U, 1U});

  std::size_t expected = 0;
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    using L = protocol::Layout<Report>;
    ++expected;
    const char kind = L::direction == protocol::Direction::input    ? 'i'
                      : L::direction == protocol::Direction::output ? 'o'
                                                                    : 'f';
    const auto found = parsed.reports.find({kind, L::id});
    REQUIRE(found != parsed.reports.end());
    CHECK(found->second.bits == 63 * 8);
    CHECK(found->second.usage_page == 0xFF00);
    CHECK(found->second.logical_max == 255);
    CHECK((found->second.flags & 1) == 0);  // data, not constant
  });
  CHECK(parsed.reports.size() == expected);
}

TEST_CASE("strings say who made what, and which one it is") {
  const std::uint8_t serial[16] = {'E', '6', '6', '0', 'A', 'B', 0};
  const auto languages = device::string_descriptor(0, serial);
  CHECK(languages.size_bytes == 4);
  CHECK(languages.units[0] == 0x0304);
  CHECK(languages.units[1] == 0x0409);
  CHECK(text(device::string_descriptor(1, serial)) == "Torsio");
  CHECK(text(device::string_descriptor(2, serial)) == "haptic knob");
  CHECK(text(device::string_descriptor(3, serial)) == "E660AB");
  CHECK(device::string_descriptor(3, serial).units[0] == (0x0300 | 14));
  CHECK(text(device::string_descriptor(4, serial)) == "Torsio control");
  CHECK(text(device::string_descriptor(5, serial)) == "Torsio game controller");
  CHECK(device::string_descriptor(6, serial).size_bytes == 0);
  CHECK(device::string_descriptor(6, serial, device::Personality::dial).size_bytes == 2 + 2 * 11);
  CHECK(device::string_descriptor(0xEE, serial).size_bytes == 0);
}

TEST_CASE("a serial number that fills its field is given whole") {
  const std::uint8_t serial[16] = {'0', '1', '2', '3', '4', '5', '6', '7',
                                   '8', '9', 'A', 'B', 'C', 'D', 'E', 'F'};
  CHECK(text(device::string_descriptor(3, serial)) == "0123456789ABCDEF");
}
