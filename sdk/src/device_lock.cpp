#include "device_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "torsio/error.hpp"

namespace torsio {
namespace {

/// $XDG_RUNTIME_DIR/torsio-dev-hidraw3.lock, or in /tmp where there is no such directory. All names
/// of one file have one lock.
std::string lock_path(const std::string& device_path) {
  const char* directory = std::getenv("XDG_RUNTIME_DIR");
  std::string name = device_path;
  std::error_code failed;
  const auto file = std::filesystem::canonical(device_path, failed);
  // The paths of hidapi's libusb backend name no file.
  if (device_path.starts_with('/') && !failed) name = file.string();
  std::ranges::replace_if(name, [](unsigned char c) { return std::isalnum(c) == 0; }, '-');
  return std::string(directory != nullptr && *directory != '\0' ? directory : "/tmp") + "/torsio" +
         (name.starts_with('-') ? "" : "-") + name + ".lock";
}

int open_lock_file(const std::string& path) {
  constexpr int kFlags = O_RDWR | O_CLOEXEC | O_NOFOLLOW;
  const int file = ::open(path.c_str(), kFlags | O_CREAT, 0666);
  // In a sticky directory the kernel may forbid O_CREAT on another user's file, not opening it.
  return file >= 0 ? file : ::open(path.c_str(), kFlags & ~O_RDWR);
}

/// Whether `path` still leads to the open file; who had the lock before may have removed it.
bool is_at(int file, const std::string& path) {
  struct stat opened{};
  struct stat there{};
  return ::fstat(file, &opened) == 0 && ::stat(path.c_str(), &there) == 0 &&
         opened.st_dev == there.st_dev && opened.st_ino == there.st_ino;
}

}  // namespace

DeviceLock::DeviceLock(const std::string& device_path) : path_(lock_path(device_path)) {
  constexpr int kAttempts = 10;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    file_ = open_lock_file(path_);
    // Where no lock file can be had the device is still usable, just not guarded.
    if (file_ < 0) return;
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) break;
    if (is_at(file_, path_)) return;
    ::close(file_);
    file_ = -1;
  }
  if (file_ >= 0) ::close(file_);
  throw DeviceBusy(device_path +
                   " is open already, in this program or another one; close it there first");
}

void DeviceLock::remove_file() noexcept {
  if (file_ >= 0) ::unlink(path_.c_str());
}

DeviceLock::~DeviceLock() {
  if (file_ >= 0) ::close(file_);
}

}  // namespace torsio
