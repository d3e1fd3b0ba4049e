/// @file
/// The dial's report descriptor: a mouse whose wheels have a fine resolution that the host may ask
/// for, and the keys of a volume control. Systems take a wheel by itself for no pointing device;
/// this mouse never moves.
#pragma once

#include <cstddef>
#include <cstdint>

#include "device/hid_descriptor.hpp"

namespace torsio::device::dial {

inline constexpr std::uint8_t kMouseReport = 1;   // buttons, x, y, wheel, pan
inline constexpr std::uint8_t kVolumeReport = 2;  // keys
inline constexpr std::uint8_t kResolutionReport = 3;
inline constexpr std::size_t kMouseReportSize = 8;
inline constexpr std::size_t kShortReportSize = 2;  // of the other two
inline constexpr std::uint8_t kWheelFine = 0x01;    // bits of the resolution report
inline constexpr std::uint8_t kPanFine = 0x04;
inline constexpr std::uint8_t kLouder = 0x01;  // bits of the volume report
inline constexpr std::uint8_t kQuieter = 0x02;
inline constexpr std::int32_t kUnits = 120;  // of a detent, where the resolution is fine
inline constexpr std::int32_t kMost = 32767;

namespace detail {

constexpr void describe_wheel(hid::DescriptorWriter& to, std::uint16_t page, std::uint16_t id) {
  // A multiplier is for what stands in its collection (HID Usage Tables 1.4, 4.3.1).
  to.open(hid::usage::desktop, 0x00, hid::kLogical);
  to.report_id(kResolutionReport);
  to.use(hid::usage::desktop, 0x48);
  to.limits(0, 1, kUnits, {}, 1);
  to.data(hid::Main::feature, 2, 1, hid::kVariable);
  to.report_id(kMouseReport);
  to.use(page, id);
  to.limits(-kMost, kMost);
  to.data(hid::Main::input, 16, 1, hid::kChange);
  to.close();
}

constexpr hid::DescriptorWriter describe() {
  namespace usage = hid::usage;
  hid::DescriptorWriter to;
  to.open(usage::desktop, 0x02, hid::kApplication);  // mouse
  to.open(usage::desktop, 0x01, hid::kPhysical);     // pointer
  to.report_id(kMouseReport);
  for (std::uint16_t button = 1; button <= 3; ++button) {
    to.use(usage::button, button);
    to.limits(0, 1);
    to.data(hid::Main::input, 1, 1, hid::kVariable);
  }
  to.data(hid::Main::input, 5, 1, hid::kConstant);
  for (const int axis : {0x30, 0x31}) {
    to.use(usage::desktop, static_cast<std::uint16_t>(axis));
    to.limits(-127, 127);
    to.data(hid::Main::input, 8, 1, hid::kChange);
  }
  describe_wheel(to, usage::desktop, 0x38);
  describe_wheel(to, usage::consumer, 0x238);  // AC Pan
  to.report_id(kResolutionReport);
  to.data(hid::Main::feature, 4, 1, hid::kConstant);
  to.close();
  to.close();

  to.open(usage::consumer, 0x01, hid::kApplication);  // consumer control
  to.report_id(kVolumeReport);
  for (const int key : {0xE9, 0xEA}) {  // louder, quieter
    to.use(usage::consumer, static_cast<std::uint16_t>(key));
    to.limits(0, 1);
    to.data(hid::Main::input, 1, 1, hid::kVariable);
  }
  to.data(hid::Main::input, 6, 1, hid::kConstant);
  to.close();
  return to;
}

}  // namespace detail

inline constexpr auto kReportDescriptor = hid::descriptor_bytes<detail::describe>();

}  // namespace torsio::device::dial
