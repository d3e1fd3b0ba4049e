/// @file
/// The plant's truth as a file, to compare the knob's motion with the requests of a game or a
/// program.
#pragma once

#include <cstdio>
#include <memory>
#include <span>
#include <string>

#include "emulator/emulated_device.hpp"

namespace torsio::emulator::usbip {

/// Comma-separated values, one line for each control tick, at the moment when it samples the
/// encoder. Torques are on the knob; every number is the shortest that reads back as the same one.
class TruthLog {
 public:
  /// @throws std::system_error if the file cannot be written
  explicit TruthLog(const std::string& path);

  /// @throws std::system_error if the file cannot be written
  void add(std::span<const TruthSample> samples);
  /// @throws std::system_error if the file cannot be written
  void flush();

 private:
  struct Close {
    void operator()(std::FILE* file) const { (void)std::fclose(file); }
  };

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace torsio::emulator::usbip
