/// @file
/// The thread behind DeviceWatch.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "device_changes.hpp"
#include "directory_watch.hpp"
#include "process.hpp"
#include "torsio/hotplug.hpp"

namespace torsio {

/// Where a watcher learns what is there. Tests bring their own.
struct WatchSource {
  std::function<std::vector<ListedDevice>()> look;  ///< lists all devices, without opening them
  std::string directory = "/dev";                   ///< where their files appear ... (empty: none)
  std::string prefix = "hidraw";                    ///< ... under such names
};

class DeviceWatcher {
 public:
  DeviceWatcher(WatchSource source, DeviceWatch::Callback callback, const WatchOptions& options);
  ~DeviceWatcher();
  DeviceWatcher(const DeviceWatcher&) = delete;
  DeviceWatcher& operator=(const DeviceWatcher&) = delete;

  std::optional<DeviceEvent> next(double timeout_s);
  void stop();
  [[nodiscard]] bool is_stopped() const { return ended_; }
  /// False in a child that was forked: nothing else may be used or destroyed there.
  [[nodiscard]] bool is_here() const { return process_.is_this(); }

 private:
  void run() noexcept;
  void watch();
  void look();
  void deliver(const std::vector<DeviceEvent>& events);
  [[nodiscard]] std::vector<ListedDevice> present() const;
  [[nodiscard]] std::optional<std::chrono::milliseconds> time_to_next_look() const;
  void end() noexcept;
  void rethrow_failure();

  const MakersProcess process_;
  const WatchSource source_;
  const DeviceWatch::Callback callback_;
  DirectoryWatch directory_;
  // The thread's own, once it runs.
  DeviceChanges changes_;
  std::vector<DeviceEvent> first_events_;
  DeviceChanges::Time settled_at_;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> ended_{false};
  std::mutex join_mutex_;

  mutable std::mutex mutex_;  // guards the next two
  std::deque<DeviceEvent> events_;
  std::exception_ptr failure_;
  std::condition_variable news_;

  std::atomic<std::thread::id> thread_id_;
  std::thread thread_;
};

}  // namespace torsio
