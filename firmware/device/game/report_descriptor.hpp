/// @file
/// The game interface's report descriptor (HID 1.11, section 6.2.2), made from the lists of fields.
#pragma once

#include <cstdint>
#include <tuple>
#include <type_traits>

#include "device/game/reports.hpp"
#include "device/hid_descriptor.hpp"

namespace torsio::device::game {
namespace detail {

template <class Owner, class T>
constexpr void describe(hid::DescriptorWriter& to, Main main, const Value<Owner, T>& field) {
  to.use(field.page, field.id);
  to.limits(field.min, field.max, field.physical_max, field.unit);
  to.data(main, 8 * field.bytes, 1, hid::kVariable);
}

template <class Owner, std::size_t N>
constexpr void describe(hid::DescriptorWriter& to, Main main, const Choice<Owner, N>& field) {
  to.open(usage::pid, field.id, hid::kLogical);
  for (const std::uint8_t choice : field.choices) to.use(usage::pid, choice);
  to.limits(1, static_cast<std::int32_t>(N));
  to.data(main, 8, 1, hid::kArray);
  to.close();
}

template <class Owner, std::size_t N>
constexpr void describe(hid::DescriptorWriter& to, Main main, const Bits<Owner, N>& field) {
  for (const Bit& bit : field.bits) {
    if (bit.collection != 0) to.open(usage::pid, bit.collection, hid::kLogical);
    to.use(bit.page, bit.id);
    to.limits(0, 1);
    to.data(main, 1, 1, hid::kVariable);
    if (bit.collection != 0) to.close();
  }
  to.data(main, 8 - N, 1, hid::kConstant);
}

template <class Owner, std::size_t N>
constexpr void describe(hid::DescriptorWriter& to, Main main, const Values<Owner, N>& field) {
  to.open(usage::pid, field.collection, hid::kLogical);
  for (const std::uint8_t id : field.ids) to.use(field.page, id);
  to.limits(0, field.max, field.physical_max, field.unit);
  to.data(main, 16, N, hid::kVariable);
  to.close();
}

template <class Report>
constexpr void describe(hid::DescriptorWriter& to) {
  using L = PidLayout<Report>;
  if (L::usage != 0) to.open(usage::pid, L::usage, hid::kLogical);
  to.report_id(L::id);
  L::fields.apply([&](const auto&... field) { (describe(to, L::main, field), ...); });
  if (L::usage != 0) to.close();
}

constexpr hid::DescriptorWriter describe_all() {
  hid::DescriptorWriter to;
  to.open(usage::desktop, 0x04, hid::kApplication);  // joystick
  [&]<class... Report>(std::type_identity<std::tuple<Report...>>) {
    (describe<Report>(to), ...);
  }(std::type_identity<PidReports>{});
  to.close();
  return to;
}

}  // namespace detail

inline constexpr auto kReportDescriptor = hid::descriptor_bytes<detail::describe_all>();

}  // namespace torsio::device::game
