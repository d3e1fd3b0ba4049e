/// @file
/// Names of emulated knobs: one that has a name is open once, and keeps what it has stored.
#pragma once

#include <string>

#include "device/config_store.hpp"

namespace torsio {

/// An emulated knob's claim on its name, while it is open. Without a name it claims nothing.
class Claim {
 public:
  /// @throws InvalidArgument, DeviceBusy
  explicit Claim(std::string name);
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;
  ~Claim() { release(nullptr); }

  [[nodiscard]] device::StoredSlots stored() const;

  /// @param stored configuration that the name keeps from now on; nullptr: as before
  void release(const device::StoredSlots* stored);

 private:
  std::string name_;
};

}  // namespace torsio
