/// @file
/// Names of files in messages.
#pragma once

#include <filesystem>
#include <string>

namespace torsio {

/// In UTF-8 on every system.
inline std::string path_text(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

}  // namespace torsio
