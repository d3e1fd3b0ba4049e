/// @file The knobs that Linux has, by its files. hidapi lists them too, but Debian's 0.13 ends the
/// process when a device leaves meanwhile (libusb/hidapi, pull request 580).
#pragma once

#include <filesystem>
#include <vector>

#include "hid_transport.hpp"

namespace torsio {

/// @param devices the kernel's folder of hidraw devices
/// (Documentation/ABI/testing/sysfs-class-hidraw
///        and sysfs-bus-usb); none if it is not there
/// @returns the vendor interface of each knob, in the order of their numbers; what leaves meanwhile
///          is left out
std::vector<HidListing> list_hidraw(const std::filesystem::path& devices = "/sys/class/hidraw");

}  // namespace torsio
