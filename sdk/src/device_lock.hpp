/// @file
/// One program at a time may drive a device; the operating system would let them all in.
#pragma once

#include <cstdint>
#include <string>

namespace torsio {

/// An advisory lock on a device, held until it is destroyed, and released by the system if the
/// process dies. Its file lies in $XDG_RUNTIME_DIR where that is the user's own, so it keeps apart
/// the programs of one user, not of two. On Windows it lies in the user's own temporary
/// folder, and goes with the lock.
class DeviceLock {
 public:
  /// @param shared_directory where the user's own directory is made without $XDG_RUNTIME_DIR. If
  /// that name is another user's, a link, or open to others, nothing is locked
  /// @throws DeviceBusy if somebody, maybe this very process, holds it, or its file is another
  /// user's; Error if the disk is full, or there are too many open files
  explicit DeviceLock(const std::string& device_path, const std::string& shared_directory = "/tmp");
  ~DeviceLock();
  DeviceLock(const DeviceLock&) = delete;
  DeviceLock& operator=(const DeviceLock&) = delete;

  /// Leaves no file behind, for a device that turned out to be of no use. The lock is held on.
  void remove_file() noexcept;

 private:
  const std::string path_;
  std::intptr_t file_ = -1;  // a descriptor; on Windows a handle
};

}  // namespace torsio
