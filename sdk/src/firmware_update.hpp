/// @file
/// The way of new firmware onto a knob, with what it asks of the machine in one place.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "torsio/firmware.hpp"
#include "torsio/knob.hpp"

namespace torsio {

/// Where knobs and drives are; the tests bring their own.
struct FirmwareHost {
  std::function<std::vector<ListedDevice>()> list;
  std::function<Knob(const std::string&)> open;
  std::function<void(const std::string&)> start_bootloader;
  std::filesystem::path root = "/";  ///< of the system's files
};

FirmwareUpdate update_firmware(const std::filesystem::path& path, std::string_view selector,
                               const UpdateOptions& options, const FirmwareHost& host);

}  // namespace torsio
