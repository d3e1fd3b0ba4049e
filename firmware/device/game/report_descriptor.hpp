/// @file
/// The game interface's report descriptor (HID 1.11, section 6.2.2), made from the lists of fields.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <tuple>

#include "device/game/reports.hpp"

namespace torsio::device::game {
namespace detail {

/// Writes items. Global items are written when they change, which halves the descriptor.
class DescriptorWriter {
 public:
  static constexpr std::size_t kRoom = 2048;

  constexpr void open(std::uint16_t page, std::uint8_t id, std::uint8_t kind) {
    use(page, id);
    item(0xA0, kind, 1);
  }
  constexpr void close() { raw(0xC0); }
  constexpr void report_id(std::uint8_t id) { item(0x84, id, 1); }
  constexpr void use(std::uint16_t page, std::uint8_t id) {
    global(0x04, page_, page, 1);
    item(0x08, id, 1);
  }
  constexpr void limits(std::int32_t min, std::int32_t max, std::int32_t physical_max = 0,
                        Unit unit = {}) {
    global(0x14, logical_min_, min);
    global(0x24, logical_max_, max);
    global(0x34, physical_min_, 0);
    global(0x44, physical_max_, physical_max);
    global(0x64, unit_, static_cast<std::int32_t>(unit.code));
    // A whole byte: HID 1.11 has it as a nibble, which Wine reads as +13. Linux takes either.
    global(0x54, exponent_, unit.exponent, 1);
  }
  /// @param flags 0 array, 1 constant, 2 variable
  constexpr void data(Main main, unsigned size_bits, unsigned count, std::uint8_t flags) {
    global(0x74, size_, static_cast<std::int32_t>(size_bits), 1);
    global(0x94, count_, static_cast<std::int32_t>(count), 1);
    item(static_cast<std::uint8_t>(main) & 0xFC, flags, 1);
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

inline constexpr std::uint8_t kApplication = 0x01;
inline constexpr std::uint8_t kLogical = 0x02;
inline constexpr std::uint8_t kArray = 0x00;
inline constexpr std::uint8_t kConstant = 0x03;
inline constexpr std::uint8_t kVariable = 0x02;

template <class Owner, class T>
constexpr void describe(DescriptorWriter& to, Main main, const Value<Owner, T>& field) {
  to.use(field.page, field.id);
  to.limits(field.min, field.max, field.physical_max, field.unit);
  to.data(main, 8 * field.bytes, 1, kVariable);
}

template <class Owner, std::size_t N>
constexpr void describe(DescriptorWriter& to, Main main, const Choice<Owner, N>& field) {
  to.open(usage::pid, field.id, kLogical);
  for (const std::uint8_t choice : field.choices) to.use(usage::pid, choice);
  to.limits(1, static_cast<std::int32_t>(N));
  to.data(main, 8, 1, kArray);
  to.close();
}

template <class Owner, std::size_t N>
constexpr void describe(DescriptorWriter& to, Main main, const Bits<Owner, N>& field) {
  for (const Bit& bit : field.bits) {
    if (bit.collection != 0) to.open(usage::pid, bit.collection, kLogical);
    to.use(bit.page, bit.id);
    to.limits(0, 1);
    to.data(main, 1, 1, kVariable);
    if (bit.collection != 0) to.close();
  }
  to.data(main, 8 - N, 1, kConstant);
}

template <class Owner, std::size_t N>
constexpr void describe(DescriptorWriter& to, Main main, const Values<Owner, N>& field) {
  to.open(usage::pid, field.collection, kLogical);
  for (const std::uint8_t id : field.ids) to.use(field.page, id);
  to.limits(0, field.max, field.physical_max, field.unit);
  to.data(main, 16, N, kVariable);
  to.close();
}

template <class Report>
constexpr void describe(DescriptorWriter& to) {
  using L = PidLayout<Report>;
  if (L::usage != 0) to.open(usage::pid, L::usage, kLogical);
  to.report_id(L::id);
  L::fields.apply([&](const auto&... field) { (describe(to, L::main, field), ...); });
  if (L::usage != 0) to.close();
}

constexpr DescriptorWriter describe_all() {
  DescriptorWriter to;
  to.open(usage::desktop, 0x04, kApplication);  // joystick
  [&]<class... Report>(std::type_identity<std::tuple<Report...>>) {
    (describe<Report>(to), ...);
  }(std::type_identity<PidReports>{});
  to.close();
  return to;
}

constexpr auto make_report_descriptor() {
  constexpr DescriptorWriter written = describe_all();
  std::array<std::uint8_t, written.size()> bytes{};
  std::copy_n(written.bytes().begin(), bytes.size(), bytes.begin());
  return bytes;
}

}  // namespace detail

inline constexpr auto kReportDescriptor = detail::make_report_descriptor();

}  // namespace torsio::device::game
