/// @file
/// One program at a time may drive a device; the operating system would let them all in.
#pragma once

#include <string>

namespace torsio {

/// An advisory lock on a device, held until it is destroyed, and released by the system if the
/// process dies.
class DeviceLock {
 public:
  /// @throws DeviceBusy if somebody, maybe this very process, holds it
  explicit DeviceLock(const std::string& device_path);
  ~DeviceLock();
  DeviceLock(const DeviceLock&) = delete;
  DeviceLock& operator=(const DeviceLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace torsio
