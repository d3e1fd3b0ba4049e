// Where no file is a knob, on Windows and macOS: nothing but wake() and the time end a wait, and
// who watches looks now and then.
#include <utility>

#include "directory_watch.hpp"

namespace torsio {

DirectoryWatch::DirectoryWatch(std::string directory, std::string prefix)
    : directory_(std::move(directory)), prefix_(std::move(prefix)) {}

DirectoryWatch::~DirectoryWatch() = default;

bool DirectoryWatch::wait(std::optional<std::chrono::milliseconds> timeout) {
  std::unique_lock lock(mutex_);
  const auto is_woken = [this] { return wake_; };
  if (timeout) {
    woken_.wait_for(lock, *timeout, is_woken);
  } else {
    woken_.wait(lock, is_woken);
  }
  wake_ = false;
  return false;
}

void DirectoryWatch::wake() noexcept {
  {
    const std::lock_guard lock(mutex_);
    wake_ = true;
  }
  woken_.notify_one();
}

std::set<std::string> DirectoryWatch::take_removed() { return std::exchange(removed_, {}); }

bool DirectoryWatch::read_notices() { return false; }

}  // namespace torsio
