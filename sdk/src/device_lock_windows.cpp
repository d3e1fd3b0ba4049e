// The lock on Windows: a file that nobody else may open, and that goes with the process.
#include <windows.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "device_lock.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

/// FOLDER/torsio-NAME.lock in the user's temporary folder. Empty if there is none.
std::string lock_path(std::string name) {
  std::array<char, MAX_PATH + 1> folder{};
  const DWORD length = ::GetTempPathA(static_cast<DWORD>(folder.size()), folder.data());
  if (length == 0 || length >= folder.size()) return {};
  // Names of devices differ in case from one call of the system to the next.
  std::ranges::transform(name, name.begin(), [](unsigned char c) {
    return std::isalnum(c) != 0 ? static_cast<char>(std::tolower(c)) : '-';
  });
  return std::string(folder.data()) + "torsio-" + name + ".lock";
}

}  // namespace

DeviceLock::DeviceLock(const std::string& device_path, const std::string& /*shared_directory*/)
    : path_(lock_path(device_path)) {
  if (path_.empty()) return;
  const HANDLE file =
      ::CreateFileA(path_.c_str(), GENERIC_READ | GENERIC_WRITE, 0, nullptr, OPEN_ALWAYS,
                    FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE, nullptr);
  if (file != INVALID_HANDLE_VALUE) {
    file_ = reinterpret_cast<std::intptr_t>(file);
    return;
  }
  // Where no lock file can be had the device is still usable, just not guarded.
  if (::GetLastError() != ERROR_SHARING_VIOLATION) return;
  throw DeviceBusy(device_path +
                   " is open already, in this program or another one; close it there first");
}

void DeviceLock::remove_file() noexcept {}

DeviceLock::~DeviceLock() {
  if (file_ != -1) ::CloseHandle(reinterpret_cast<HANDLE>(file_));
}

}  // namespace torsio
