// A knob's path on POSIX: a file, with a permission.
#include "hid_files.hpp"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <thread>

#include "hid_transport.hpp"
#include "hidraw_listing.hpp"
#include "torsio/error.hpp"

// Only hidapi's libusb backend has this; hidapi does not say otherwise which backend it is.
extern "C" [[gnu::weak]] void* hid_libusb_wrap_sys_device(std::intptr_t, int);

namespace torsio {
namespace {

constexpr const char* kUdevHint =
    "Torsio's udev rule is not in force. Run `./dev udev` in its source tree. Or copy "
    "60-torsio.rules from there to /etc/udev/rules.d/, run `udevadm control --reload` as root and "
    "plug the knob in again. The rule (uaccess) serves the user at the machine's own screen, not "
    "over ssh";

}  // namespace

// hidapi before 0.14 uses freed memory if a file opens but does not answer as a hidraw device. So
// it must not get such files. Only hidapi's libusb backend has paths that name no file.
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

// The first open of a hidraw device waits for 50 ms in the kernel. A device
// that is unplugged meanwhile opens all the same, and is gone a moment later. So the library opens
// first, because it can bear that. hidapi opens second and does not wait.
std::shared_ptr<const void> keep_open(const std::string& path) {
  if (!path.starts_with('/')) return nullptr;
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) return nullptr;  // hidapi says why
  const std::shared_ptr<const void> kept(nullptr, [file](const void*) { ::close(file); });
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  int size = 0;
  if (::ioctl(file, HIDIOCGRDESCSIZE, &size) < 0) {
    throw DeviceNotFound("the knob at " + path + " is gone: it was unplugged while it was opened");
  }
  return kept;
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
