// The parts of the descriptors that tests/vm/guest/test_enumeration.py and tests/board/test_usb.py
// do not see.
#include <doctest/doctest.h>

#include <cstdint>
#include <span>
#include <string>

#include "device/usb_descriptors.hpp"

namespace {

using namespace torsio;
using Bytes = std::span<const std::uint8_t>;

unsigned u16(Bytes bytes, std::size_t at) { return bytes[at] | (unsigned{bytes[at + 1]} << 8); }

std::string text(const device::StringDescriptor& string) {
  std::string result;
  for (std::size_t i = 1; i < string.size_bytes / 2; ++i) {
    result += static_cast<char>(string.units[i]);
  }
  return result;
}

}  // namespace

TEST_CASE("the device descriptor's version stays decimal beyond nine") {
  const auto d = device::device_descriptor({12, 10, 99});
  CHECK(u16(d, 12) == 0x0999);
}

TEST_CASE("a serial number that fills its field is given whole") {
  const std::uint8_t serial[16] = {'0', '1', '2', '3', '4', '5', '6', '7',
                                   '8', '9', 'A', 'B', 'C', 'D', 'E', 'F'};
  CHECK(text(device::string_descriptor(3, serial)) == "0123456789ABCDEF");
}
