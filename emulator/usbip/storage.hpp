/// @file
/// The virtual knob's storage in a file, which outlives the program.
#pragma once

#include <filesystem>
#include <string>

#include "device/config_store.hpp"

namespace torsio::emulator::usbip {

class Storage {
 public:
  /// @param path of a file that keep() has written, or of none
  /// @throws BadOption if the file cannot be read or is another one
  explicit Storage(const std::string& path);

  [[nodiscard]] const device::StoredSlots& slots() const { return slots_; }

  /// Writes what is new beside the file, which it then replaces. If that fails the file stays as it
  /// is, and the next call tries again.
  /// @returns what went wrong, or nothing
  [[nodiscard]] std::string keep(const device::StoredSlots& slots);

 private:
  std::filesystem::path path_;
  device::StoredSlots slots_ = device::empty_slots();
};

}  // namespace torsio::emulator::usbip
