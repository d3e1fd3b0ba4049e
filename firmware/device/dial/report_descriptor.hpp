/// @file
/// The dial's report descriptor: a mouse whose wheels have a fine resolution that the host may ask
/// for, the keys of a volume control, and a radial controller as Windows knows it. Systems take a
/// wheel by itself for no pointing device; this mouse never moves.
#pragma once

#include <cstddef>
#include <cstdint>

#include "device/hid_descriptor.hpp"

namespace torsio::device::dial {

inline constexpr std::uint8_t kMouseReport = 1;   // buttons, x, y, wheel, pan
inline constexpr std::uint8_t kVolumeReport = 2;  // keys
inline constexpr std::uint8_t kResolutionReport = 3;
inline constexpr std::uint8_t kRadialReport = 4;     // button, turn
inline constexpr std::uint8_t kHapticsReport = 5;    // trigger, intensity, repeats, period
inline constexpr std::uint8_t kWaveformsReport = 6;  // what never changes
inline constexpr std::size_t kMouseReportSize = 8;
inline constexpr std::size_t kShortReportSize = 2;  // of the volume and the resolution
inline constexpr std::size_t kRadialReportSize = 4;
inline constexpr std::size_t kHapticsReportSize = 6;
inline constexpr std::size_t kWaveformsReportSize = 11;
inline constexpr std::uint8_t kWheelFine = 0x01;  // bits of the resolution report
inline constexpr std::uint8_t kPanFine = 0x04;
inline constexpr std::uint8_t kLouder = 0x01;  // bits of the volume report
inline constexpr std::uint8_t kQuieter = 0x02;
inline constexpr std::int32_t kUnits = 120;  // of a detent, where the resolution is fine
inline constexpr std::int32_t kMost = 32767;
inline constexpr std::int32_t kTurnTenths = 3600;  // tenths of a degree
// Waveforms, by their place in the device's list.
inline constexpr std::uint8_t kStop = 2;
inline constexpr std::uint8_t kClick = 3;
inline constexpr std::uint8_t kBuzz = 4;
inline constexpr std::uint8_t kClickMs = 8;
inline constexpr std::uint16_t kMostRetriggerMs = 2000;
inline constexpr std::uint16_t kCutoffMs = 5000;

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

/// What may be asked for in the same way at once (output) and for the time being (feature).
constexpr void describe_request(hid::DescriptorWriter& to, hid::Main main, std::uint16_t trigger) {
  to.use(hid::usage::haptics, trigger);
  to.limits(main == hid::Main::output ? 1 : 0, kBuzz);
  to.data(main, 8, 1, hid::kVariable);
  to.use(hid::usage::haptics, 0x23);  // intensity
  to.limits(0, 100);
  to.data(main, 8, 1, hid::kVariable);
  to.use(hid::usage::haptics, 0x24);  // repeat count
  to.limits(0, 255);
  to.data(main, 8, 1, hid::kVariable);
  to.use(hid::usage::haptics, 0x25);  // retrigger period
  to.limits(0, kMostRetriggerMs);
  to.data(main, 16, 1, hid::kVariable);
}

/// Ordinals 1 and 2 are no waveform and stop, without being named.
constexpr void describe_waveforms(hid::DescriptorWriter& to) {
  constexpr std::uint8_t kConst = hid::kConstant;
  to.open(hid::usage::haptics, 0x10, hid::kLogical);  // waveform list
  for (const std::uint8_t ordinal : {kClick, kBuzz}) {
    to.use(hid::usage::ordinal, ordinal);
    to.limits(ordinal, ordinal, 0x1000 + ordinal, {}, 0x1000 + ordinal);
    to.data(hid::Main::feature, 8, 1, kConst);
  }
  to.close();
  to.open(hid::usage::haptics, 0x11, hid::kLogical);  // duration list
  for (const std::uint8_t ordinal : {kClick, kBuzz}) {
    to.use(hid::usage::ordinal, ordinal);
    to.limits(0, 255);
    to.data(hid::Main::feature, 8, 1, kConst);
  }
  to.close();
}

/// Microsoft's "Windows radial controller protocol implementation".
constexpr void describe_radial(hid::DescriptorWriter& to) {
  namespace usage = hid::usage;
  to.open(usage::desktop, 0x0E, hid::kApplication);  // system multi-axis controller
  to.report_id(kRadialReport);
  to.open(usage::digitizer, 0x21, hid::kPhysical);  // puck
  to.use(usage::button, 1);
  to.limits(0, 1);
  to.data(hid::Main::input, 1, 1, hid::kVariable);
  to.data(hid::Main::input, 7, 1, hid::kConstant);
  to.use(usage::desktop, 0x37);  // dial
  // Degrees. The exponent is -1 as a nibble, as Microsoft has it.
  to.limits(-kTurnTenths, kTurnTenths, kTurnTenths, {0x14, 0x0F}, -kTurnTenths);
  to.data(hid::Main::input, 16, 1, hid::kChange);
  to.close();
  to.open(usage::haptics, 0x01, hid::kLogical);  // simple haptic controller
  to.report_id(kHapticsReport);
  describe_request(to, hid::Main::output, 0x21);   // manual trigger
  describe_request(to, hid::Main::feature, 0x20);  // auto trigger
  to.report_id(kWaveformsReport);
  to.use(usage::haptics, 0x22);  // auto trigger associated control: the dial above
  to.limits(0x10037, 0x10037);
  to.data(hid::Main::feature, 32, 1, hid::kConstant);
  to.use(usage::haptics, 0x28);  // waveform cutoff time
  to.limits(0, kMost);
  to.data(hid::Main::feature, 16, 1, hid::kConstant);
  describe_waveforms(to);
  to.close();
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
  describe_radial(to);
  return to;
}

}  // namespace detail

inline constexpr auto kReportDescriptor = hid::descriptor_bytes<detail::describe>();

}  // namespace torsio::device::dial
