/// @file
/// Report descriptors of HID interfaces (HID 1.11, section 6.2.2), and other bytes for a host,
/// written by the compiler.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace torsio::device::hid {

enum class Main : std::uint8_t { input = 0x81, output = 0x91, feature = 0xB1 };

// Usage pages (HID Usage Tables 1.4; PID 1.0).
namespace usage {
inline constexpr std::uint16_t desktop = 0x01;
inline constexpr std::uint16_t button = 0x09;
inline constexpr std::uint16_t ordinal = 0x0A;
inline constexpr std::uint16_t consumer = 0x0C;
inline constexpr std::uint16_t digitizer = 0x0D;
inline constexpr std::uint16_t haptics = 0x0E;
inline constexpr std::uint16_t pid = 0x0F;
}  // namespace usage

// Kinds of collections.
inline constexpr std::uint8_t kPhysical = 0x00;
inline constexpr std::uint8_t kApplication = 0x01;
inline constexpr std::uint8_t kLogical = 0x02;

// Kinds of data.
inline constexpr std::uint8_t kArray = 0x00;
inline constexpr std::uint8_t kVariable = 0x02;
inline constexpr std::uint8_t kConstant = 0x03;
inline constexpr std::uint8_t kChange = 0x06;  // of a variable

struct Unit {
  std::uint32_t code = 0;
  std::int8_t exponent = 0;
};

/// Writes items. Global items are written when they change, which halves the descriptor.
class DescriptorWriter {
 public:
  static constexpr std::size_t kRoom = 2048;

  /// @param kind kPhysical, kApplication or kLogical
  constexpr void open(std::uint16_t page, std::uint8_t id, std::uint8_t kind) {
    use(page, id);
    item(0xA0, kind, 1);
  }
  constexpr void close() { raw(0xC0); }
  constexpr void report_id(std::uint8_t id) { item(0x84, id, 1); }
  constexpr void use(std::uint16_t page, std::uint16_t id) {
    global(0x04, page_, page, 1);
    item(0x08, id, id > 0xFF ? 2 : 1);
  }
  constexpr void limits(std::int32_t min, std::int32_t max, std::int32_t physical_max = 0,
                        Unit unit = {}, std::int32_t physical_min = 0) {
    global(0x14, logical_min_, min);
    global(0x24, logical_max_, max);
    global(0x34, physical_min_, physical_min);
    global(0x44, physical_max_, physical_max);
    global(0x64, unit_, static_cast<std::int32_t>(unit.code));
    // A whole byte: HID 1.11 has it as a nibble, which Wine reads as +13. Linux takes either.
    global(0x54, exponent_, unit.exponent, 1);
  }
  /// @param kind kArray, kVariable, kConstant or kChange
  constexpr void data(Main main, unsigned size_bits, unsigned count, std::uint8_t kind) {
    global(0x74, size_, static_cast<std::int32_t>(size_bits), 1);
    global(0x94, count_, static_cast<std::int32_t>(count), 1);
    item(static_cast<std::uint8_t>(main) & 0xFC, kind, 1);
  }

  constexpr std::size_t size() const { return at_; }
  constexpr const std::array<std::uint8_t, kRoom>& bytes() const { return bytes_; }

 private:
  constexpr void raw(std::uint8_t byte) { bytes_[at_++] = byte; }
  constexpr void item(std::uint8_t prefix, std::int32_t value, unsigned bytes) {
    raw(static_cast<std::uint8_t>(prefix | (bytes == 4 ? 3 : bytes)));
    for (unsigned i = 0; i < bytes; ++i) {
      raw(static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> (8 * i)));
    }
  }
  /// @param bytes 0: as few as hold the value with its sign
  constexpr void global(std::uint8_t prefix, std::int32_t& now, std::int32_t value,
                        unsigned bytes = 0) {
    if (value == now) return;
    now = value;
    if (bytes == 0) bytes = value == static_cast<std::int8_t>(value) ? 1 : 2;
    if (bytes == 2 && value != static_cast<std::int16_t>(value)) bytes = 4;
    item(prefix, value, bytes);
  }

  static constexpr std::int32_t kUnset = -0x10000;

  std::array<std::uint8_t, kRoom> bytes_{};
  std::size_t at_ = 0;
  std::int32_t page_ = kUnset;
  std::int32_t logical_min_ = kUnset;
  std::int32_t logical_max_ = kUnset;
  std::int32_t physical_min_ = 0;
  std::int32_t physical_max_ = 0;
  std::int32_t unit_ = 0;
  std::int32_t exponent_ = 0;
  std::int32_t size_ = kUnset;
  std::int32_t count_ = kUnset;
};

/// The bytes of a descriptor that a function writes, and no more room than they take.
template <DescriptorWriter (*describe)()>
consteval auto descriptor_bytes() {
  constexpr DescriptorWriter written = describe();
  std::array<std::uint8_t, written.size()> bytes{};
  std::copy_n(written.bytes().begin(), bytes.size(), bytes.begin());
  return bytes;
}

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

}  // namespace torsio::device::hid
