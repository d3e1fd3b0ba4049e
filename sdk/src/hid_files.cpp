// What a knob's path means to POSIX: a file, with a permission.
#include "hid_files.hpp"

#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "hid_transport.hpp"
#include "hidraw_listing.hpp"
#include "torsio/error.hpp"

// Only hidapi's libusb backend has this; hidapi does not say otherwise which backend it is.
extern "C" [[gnu::weak]] void* hid_libusb_wrap_sys_device(std::intptr_t, int);

namespace torsio {
namespace {

constexpr const char* kUdevHint =
    "Torsio's udev rule is not in force; run `./dev udev` in its source tree, or copy "
    "60-torsio.rules from there to /etc/udev/rules.d/, run `udevadm control --reload` as root and "
    "plug the knob in again (uaccess serves whoever is logged in at the machine; over ssh it does "
    "not)";

}  // namespace

// hidapi 0.13.1 frees memory that it never set when a file opens but is not a hidraw device, so
// such files must not get there. Only hidapi's libusb backend has paths that name no file.
void refuse_other_files(const std::string& path) {
  struct stat file{};
  if (!path.starts_with('/') || ::stat(path.c_str(), &file) != 0) return;
  if (S_ISCHR(file.st_mode)) {
    const std::string numbers =
        std::to_string(major(file.st_rdev)) + ":" + std::to_string(minor(file.st_rdev));
    std::error_code failed;
    const auto subsystem =
        std::filesystem::read_symlink("/sys/dev/char/" + numbers + "/subsystem", failed);
    if (!failed && subsystem.filename() == "hidraw") return;
  }
  throw DeviceNotFound(path +
                       " is not a HID device; list_devices() and `torsio list` show what is there");
}

std::string permission_text(const std::string& path) {
  return "no permission to open " + path + ": " + kUdevHint;
}

std::string hid_files_directory() {
  return hid_libusb_wrap_sys_device == nullptr ? "/dev" : std::string();
}

std::optional<std::vector<HidListing>> list_hid_files() {
  if (hid_libusb_wrap_sys_device != nullptr) return std::nullopt;
  return list_hidraw();
}

std::string permission_problem(const std::string& path) {
  const bool forbidden = path.starts_with('/') && ::access(path.c_str(), R_OK | W_OK) != 0 &&
                         (errno == EACCES || errno == EPERM);
  return forbidden ? permission_text(path) : std::string();
}

}  // namespace torsio
