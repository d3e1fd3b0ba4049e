/// @file
/// Sleeps until something happens to certain files in a directory.
#pragma once

#include <chrono>
#include <optional>
#include <set>
#include <string>

#ifndef __linux__
#include <condition_variable>
#include <mutex>
#endif

namespace torsio {

/// One thread waits, any thread may wake it.
class DirectoryWatch {
 public:
  /// @param directory empty: there is none, and there are no notices
  /// @param prefix of the names of the files that matter
  /// @throws Error if the system has no descriptors left
  DirectoryWatch(std::string directory, std::string prefix);
  ~DirectoryWatch();
  DirectoryWatch(const DirectoryWatch&) = delete;
  DirectoryWatch& operator=(const DirectoryWatch&) = delete;

  /// False if this system sends no notices; then only wake() and the time end a wait.
  [[nodiscard]] bool has_notices() const { return inotify_ >= 0; }

  /// Waits for a notice about a file, for wake(), or until the time is over; nothing is for ever.
  /// @returns true if there was a notice
  bool wait(std::optional<std::chrono::milliseconds> timeout);

  /// Ends this wait or the next one.
  void wake() noexcept;

  /// Paths of files that have gone since the last call, also if they have come again.
  [[nodiscard]] std::set<std::string> take_removed();

  /// True if the file was seen to go and not to come again.
  [[nodiscard]] bool is_gone(const std::string& path) const { return gone_.contains(path); }

 private:
  bool read_notices();

  const std::string directory_;
  const std::string prefix_;
  int inotify_ = -1;
  int pipe_[2] = {-1, -1};
#ifndef __linux__
  std::mutex mutex_;
  std::condition_variable woken_;
  bool wake_ = false;
#endif
  std::set<std::string> removed_;
  std::set<std::string> gone_;
};

}  // namespace torsio
