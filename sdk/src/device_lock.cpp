#include "device_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "torsio/error.hpp"

namespace torsio {
namespace {

/// $XDG_RUNTIME_DIR/torsio-dev-hidraw3.lock, or in /tmp where there is no such directory.
std::string lock_path(const std::string& device_path) {
  const char* directory = std::getenv("XDG_RUNTIME_DIR");
  std::string name = device_path;
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

}  // namespace

DeviceLock::DeviceLock(const std::string& device_path)
    : file_(open_lock_file(lock_path(device_path))) {
  // Where no lock file can be had the device is still usable, just not guarded.
  if (file_ < 0) return;
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    ::close(file_);
    throw DeviceBusy(device_path +
                     " is open already, in this program or another one; close it there first");
  }
}

DeviceLock::~DeviceLock() {
  if (file_ >= 0) ::close(file_);
}

}  // namespace torsio
