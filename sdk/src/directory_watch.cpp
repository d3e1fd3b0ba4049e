#include "directory_watch.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#ifdef __linux__
#include <sys/inotify.h>
#endif

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "torsio/error.hpp"

namespace torsio {
namespace {

/// @returns a descriptor, or -1 where there is no such thing
int open_inotify([[maybe_unused]] const std::string& directory) {
#ifdef __linux__
  const int inotify = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  // When udev gives the permission, the attributes change.
  constexpr std::uint32_t kWhat =
      IN_CREATE | IN_DELETE | IN_ATTRIB | IN_MOVED_FROM | IN_MOVED_TO | IN_ONLYDIR;
  if (inotify >= 0 && ::inotify_add_watch(inotify, directory.c_str(), kWhat) >= 0) return inotify;
  if (inotify >= 0) ::close(inotify);
#endif
  return -1;
}

}  // namespace

DirectoryWatch::DirectoryWatch(std::string directory, std::string prefix)
    : directory_(std::move(directory)), prefix_(std::move(prefix)) {
  if (::pipe(pipe_) != 0) {
    throw Error(std::string("cannot watch for devices: ") + std::strerror(errno));
  }
  for (const int end : pipe_) {
    ::fcntl(end, F_SETFD, FD_CLOEXEC);
    ::fcntl(end, F_SETFL, O_NONBLOCK);
  }
  if (!directory_.empty()) inotify_ = open_inotify(directory_);
}

DirectoryWatch::~DirectoryWatch() {
  if (inotify_ >= 0) ::close(inotify_);
  for (const int end : pipe_) ::close(end);
}

bool DirectoryWatch::wait(std::optional<std::chrono::milliseconds> timeout) {
  using std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLongest{1'000'000};
  const auto deadline = steady_clock::now() + std::min(timeout.value_or(kLongest), kLongest);
  while (true) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now()).count();
    const int left_ms = timeout ? static_cast<int>(std::max<long>(left, 0)) : -1;
    std::array<pollfd, 2> waits{{{pipe_[0], POLLIN, 0}, {inotify_, POLLIN, 0}}};
    // A negative descriptor is left out. A signal only makes the caller look once more.
    if (::poll(waits.data(), waits.size(), left_ms) <= 0) return false;
    const bool noticed = read_notices();
    std::array<char, 16> sink{};
    const bool woken = ::read(pipe_[0], sink.data(), sink.size()) > 0;
    if (noticed || woken) return noticed;  // else the notice was about some other file
  }
}

void DirectoryWatch::wake() noexcept {
  // A full pipe wakes as well.
  [[maybe_unused]] const auto written = ::write(pipe_[1], "", 1);
}

std::set<std::string> DirectoryWatch::take_removed() { return std::exchange(removed_, {}); }

bool DirectoryWatch::read_notices() {
  bool any = false;
#ifdef __linux__
  if (inotify_ < 0) return false;
  alignas(inotify_event) std::array<char, 4096> bytes{};
  for (ssize_t size = 0; (size = ::read(inotify_, bytes.data(), bytes.size())) > 0;) {
    for (std::size_t at = 0; at < static_cast<std::size_t>(size);) {
      inotify_event event{};
      std::memcpy(&event, bytes.data() + at, sizeof event);
      const std::string name(event.len == 0 ? "" : bytes.data() + at + sizeof event);
      at += sizeof event + event.len;
      // Notices were lost, so nothing is known about single files.
      if ((event.mask & IN_Q_OVERFLOW) != 0) {
        gone_.clear();
      } else if (!name.starts_with(prefix_)) {
        continue;
      }
      any = true;
      const std::string path = directory_ + "/" + name;
      if ((event.mask & (IN_DELETE | IN_MOVED_FROM)) != 0) {
        removed_.insert(path);
        gone_.insert(path);
      }
      if ((event.mask & (IN_CREATE | IN_MOVED_TO)) != 0) gone_.erase(path);
    }
  }
#endif
  return any;
}

}  // namespace torsio
