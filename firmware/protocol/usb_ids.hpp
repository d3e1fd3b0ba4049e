/// @file The numbers and names of a knob on USB. `./dev generate` writes them into udev's rule and
/// the documents.
///
/// Vendor and product id are pid.codes' numbers for tests. A device that is given away must be
/// built with numbers of its own.
#pragma once

#include <cstdint>
#include <string_view>

namespace torsio::protocol {

inline constexpr std::uint16_t usb_vendor_id = 0x1209;
inline constexpr std::uint16_t usb_product_id = 0x0001;
inline constexpr std::string_view usb_manufacturer = "Torsio";
inline constexpr std::string_view usb_product = "haptic knob";

// Usage of the interface that the host library talks to.
inline constexpr std::uint16_t usb_usage_page = 0xFF00;  // of the vendor's own
inline constexpr std::uint8_t usb_usage = 0x01;

}  // namespace torsio::protocol
