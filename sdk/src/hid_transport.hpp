/// @file
/// Knobs on a real USB bus, through hidapi.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "torsio/transport.hpp"

namespace torsio {

/// A knob that is plugged in, as the operating system describes it.
struct HidListing {
  std::string path;
  std::string serial;
  std::string product;
};

/// @returns the vendor interface of each knob; the system's order
std::vector<HidListing> list_hid();

/// @returns where the files of knobs appear; empty with hidapi's libusb backend, which has none
std::string hid_files_directory();

/// @returns why this user may not open the file at `path`, and what to do; empty if he may, or if
///          it is no file. Does not open it.
std::string permission_problem(const std::string& path);

/// Opens a device and takes its lock.
/// @throws DeviceNotFound, PermissionDenied, DeviceBusy, Error
std::unique_ptr<Transport> open_hid(const std::string& path);

}  // namespace torsio
