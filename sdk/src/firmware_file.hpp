/// @file
/// A file with firmware, whose content is at hand.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "torsio/firmware.hpp"

namespace torsio {

/// @throws Error with the system's reason if it cannot be read
std::string file_content(const std::filesystem::path& path);

/// As read_firmware().
/// @param path of the file, for its name
FirmwareFile firmware_in(const std::filesystem::path& path, std::string_view content);

/// ": No space left on device", as the last call of the system left it; empty if it left nothing.
std::string system_reason();

}  // namespace torsio
