/// @file
/// Have what was written to a file be on its disk.
#pragma once

#include <filesystem>

namespace torsio {

/// Returns when the data is on the disk. A removed disk is not an error.
void sync_file(const std::filesystem::path& path) noexcept;

}  // namespace torsio
