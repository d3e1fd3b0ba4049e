/// @file
/// A knob's path on this system; hid_files.cpp, and hid_files_other.cpp.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hid_transport.hpp"

namespace torsio {

/// The knobs that the system's files tell of; nothing where there are no such files, and hidapi has
/// to be asked.
[[nodiscard]] std::optional<std::vector<HidListing>> list_hid_files();

/// Keeps files from hidapi that are no HID devices. @throws DeviceNotFound
void refuse_other_files(const std::string& path);

/// Keeps a knob's file open while hidapi opens it, for the life of the returned object.
/// @throws DeviceNotFound if the knob has gone
[[nodiscard]] std::shared_ptr<const void> keep_open(const std::string& path);

/// Message for a user who may not open it.
[[nodiscard]] std::string permission_text(const std::string& path);

}  // namespace torsio
