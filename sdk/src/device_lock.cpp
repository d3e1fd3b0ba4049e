// The lock on POSIX.
#include "device_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "torsio/error.hpp"

namespace torsio {
namespace {

/// A machine that is exhausted would let every program in.
void throw_if_exhausted(const std::string& path) {
  const int error = errno;
  if (error != ENOSPC && error != EDQUOT && error != EMFILE && error != ENFILE && error != ENOMEM &&
      error != EIO) {
    return;
  }
  throw Error(path + ", which keeps other programs from the device, cannot be made: " +
              std::generic_category().message(error));
}

/// Where this user's lock files are: $XDG_RUNTIME_DIR, or SHARED/torsio-UID, which nobody else may
/// write to. Empty if it cannot be had. After `sudo -E` the variable names a folder of the user's,
/// who could not open what root leaves there.
std::string lock_directory(const std::string& shared) {
  struct stat there{};
  const char* given = std::getenv("XDG_RUNTIME_DIR");
  if (given != nullptr && ::stat(given, &there) == 0 && there.st_uid == ::getuid()) return given;
  const std::string directory = shared + "/torsio-" + std::to_string(::getuid());
  // An existing folder is fine.
  if (::mkdir(directory.c_str(), 0700) != 0) throw_if_exhausted(directory);
  const bool own = ::lstat(directory.c_str(), &there) == 0 && S_ISDIR(there.st_mode) &&
                   there.st_uid == ::getuid() && (there.st_mode & (S_IWGRP | S_IWOTH)) == 0;
  return own ? directory : std::string();
}

/// DIRECTORY/torsio-dev-hidraw3.lock. All names of one file have one lock.
std::string lock_path(const std::string& device_path, const std::string& shared) {
  const std::string directory = lock_directory(shared);
  if (directory.empty()) return {};
  std::string name = device_path;
  std::error_code failed;
  const auto file = std::filesystem::canonical(device_path, failed);
  // The paths of hidapi's libusb backend name no file.
  if (device_path.starts_with('/') && !failed) name = file.string();
  std::ranges::replace_if(name, [](unsigned char c) { return std::isalnum(c) == 0; }, '-');
  return directory + "/torsio" + (name.starts_with('-') ? "" : "-") + name + ".lock";
}

/// It follows no link and waits for no pipe.
/// @returns -1 unless it is a plain file
/// @throws DeviceBusy if it is one that another user keeps to himself; Error
int open_lock_file(const std::string& path) {
  if (path.empty()) return -1;
  const int file =
      ::open(path.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
  struct stat opened{};
  if (file < 0) {
    throw_if_exhausted(path);
    if (errno != EACCES || ::lstat(path.c_str(), &opened) != 0 || !S_ISREG(opened.st_mode))
      return -1;
    throw DeviceBusy(path +
                     " is the device's lock and cannot be opened: another user has the "
                     "device, or has left the file; remove it if nobody uses the device");
  }
  if (::fstat(file, &opened) == 0 && S_ISREG(opened.st_mode)) return file;
  ::close(file);
  return -1;
}

/// Whether `path` still leads to the open file; who had the lock before may have removed it.
bool is_at(int file, const std::string& path) {
  struct stat opened{};
  struct stat there{};
  return ::fstat(file, &opened) == 0 && ::stat(path.c_str(), &there) == 0 &&
         opened.st_dev == there.st_dev && opened.st_ino == there.st_ino;
}

}  // namespace

DeviceLock::DeviceLock(const std::string& device_path, const std::string& shared_directory)
    : path_(lock_path(device_path, shared_directory)) {
  constexpr int kAttempts = 10;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const int file = open_lock_file(path_);
    // Where no lock file can be had the device is still usable, just not guarded.
    if (file < 0) return;
    const bool locked = ::flock(file, LOCK_EX | LOCK_NB) == 0;
    if (locked && is_at(file, path_)) {
      file_ = file;
      return;
    }
    ::close(file);
    if (!locked) break;
  }
  throw DeviceBusy(device_path +
                   " is open already, in this program or another one; close it there first");
}

void DeviceLock::remove_file() noexcept {
  if (file_ >= 0) ::unlink(path_.c_str());
}

DeviceLock::~DeviceLock() {
  if (file_ < 0) return;
  const int file = static_cast<int>(file_);
  // A child that was forked has the open file as well, and would keep the lock.
  ::flock(file, LOCK_UN);
  ::close(file);
}

}  // namespace torsio
