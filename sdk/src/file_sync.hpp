/// @file
/// Have what was written to a file be on its disk.
#pragma once

#include <filesystem>

namespace torsio {

/// Returns when it is there, or cannot be: a disk that takes itself away is no error.
void sync_file(const std::filesystem::path& path) noexcept;

}  // namespace torsio
