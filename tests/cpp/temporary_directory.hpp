/// @file
/// A directory that is gone when the test ends.
#pragma once

#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>

namespace torsio::test {

class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::random_device chance;
    // Somebody may have the name already.
    for (int attempt = 0; attempt < 100; ++attempt) {
      const auto path =
          std::filesystem::temp_directory_path() / ("torsio-" + std::to_string(chance()));
      if (!std::filesystem::create_directory(path)) continue;
      std::filesystem::permissions(path, std::filesystem::perms::owner_all);
      path_ = path.string();
      return;
    }
    throw std::runtime_error("cannot make a temporary directory");
  }
  ~TemporaryDirectory() { std::filesystem::remove_all(path_); }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace torsio::test
