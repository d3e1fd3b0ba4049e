#include "emulator/usbip/storage.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <random>
#include <system_error>

#include "emulator/usbip/options.hpp"

namespace torsio::emulator::usbip {
namespace {

namespace fs = std::filesystem;

/// @returns 0, or the error's number
int write_file(const fs::path& path, const fs::path& like, const device::StoredSlots& slots) {
  std::FILE* const file = std::fopen(path.c_str(), "wxe");
  if (file == nullptr) return errno;
  std::error_code none;
  if (const fs::file_status old = fs::status(like, none); fs::exists(old)) {
    fs::permissions(path, old.permissions(), none);
  }
  int fault = 0;
  for (const device::SlotBytes& slot : slots.slot) {
    if (std::fwrite(slot.data(), 1, slot.size(), file) != slot.size()) fault = errno;
  }
  if (std::fflush(file) != 0 || ::fsync(::fileno(file)) != 0) fault = errno;
  if (std::fclose(file) != 0) fault = errno;
  return fault;
}

}  // namespace

Storage::Storage(const std::string& path) : path_(path) {
  std::error_code unknown;  // opening tells it
  if (const fs::file_status there = fs::status(path_, unknown);
      fs::exists(there) && !fs::is_regular_file(there)) {
    throw BadOption("--storage " + path + " is no file");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    if (errno == ENOENT) {  // a new one
      const fs::path folder = fs::absolute(path_).parent_path();
      if (fs::is_directory(folder, unknown)) return;
      throw BadOption("--storage " + path + ": there is no folder " + folder.string());
    }
    throw BadOption("--storage " + path + ": cannot be read: " + std::strerror(errno));
  }
  path_ = fs::canonical(path);  // a link stays, and what it leads to is replaced
  for (device::SlotBytes& slot : slots_.slot) {
    file.read(reinterpret_cast<char*>(slot.data()), static_cast<std::streamsize>(slot.size()));
  }
  if (!file || file.peek() != std::ifstream::traits_type::eof()) {
    throw BadOption("--storage " + path + " is no file that a virtual knob has written");
  }
}

std::string Storage::keep(const device::StoredSlots& slots) {
  if (slots.slot == slots_.slot) return {};
  // A short name of its own, since the file's may be as long as the system allows. In containers
  // processes have the same numbers.
  const fs::path beside =
      path_.parent_path() / (".torsio-" + std::to_string(std::random_device{}()));
  std::error_code failed(write_file(beside, path_, slots), std::generic_category());
  if (!failed) fs::rename(beside, path_, failed);
  if (failed) {
    std::error_code none;
    fs::remove(beside, none);
    return path_.string() + ": cannot be written: " + failed.message();
  }
  slots_ = slots;
  return {};
}

}  // namespace torsio::emulator::usbip
