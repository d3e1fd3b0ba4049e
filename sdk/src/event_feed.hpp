/// @file
/// Events on their way to the user: kept until they are taken, and told to a callback.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "process.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

/// Every member may be called from any thread. The callback is called under no lock.
class EventFeed {
 public:
  using Callback = std::function<void(const Event&)>;

  /// With a thread of its own the feed calls back by itself, else in tell().
  explicit EventFeed(bool own_thread) : own_thread_(own_thread) {}
  ~EventFeed();
  EventFeed(const EventFeed&) = delete;
  EventFeed& operator=(const EventFeed&) = delete;

  void add(const Event& event);
  /// Takes what was not taken yet, oldest first.
  [[nodiscard]] std::vector<Event> take();
  [[nodiscard]] bool empty() const;
  /// How many were never taken because kMost newer ones came.
  [[nodiscard]] std::uint64_t lost() const;

  /// From the next event on; none stops it. An older callback's exception is thrown here, once.
  void set_callback(Callback callback);
  /// Without a thread: calls back for what has come since, one after the other. If a callback runs
  /// already, its caller goes on with the new events.
  void tell();
  /// True in the callback itself.
  [[nodiscard]] bool tells_here() const;

  /// The callback is told first what has come, unless that takes it more than a second or it is the
  /// callback that calls. No callback runs any more when it returns, unless the callback itself
  /// calls it. Calling it again is fine.
  void close() noexcept;

  static constexpr std::size_t kMost = 1024;

 private:
  /// Data of the thread; it may outlive the feed, if the callback is the last to have the knob.
  struct Telling {
    std::mutex mutex;
    std::condition_variable news;
    std::thread::id teller;  // whose callback runs; none if none does
    std::deque<Event> events;
    std::shared_ptr<const Callback> callback;
    std::exception_ptr failure;
    bool closed = false;
    const MakersProcess process;

    bool tell_one(std::unique_lock<std::mutex>& lock);
    void run();
  };

  const bool own_thread_;
  std::atomic<bool> has_callback_{false};  // for tell(), which mostly finds none, frame by frame
  mutable std::mutex mutex_;               // guards the next two
  std::deque<Event> kept_;
  std::uint64_t lost_ = 0;
  std::shared_ptr<Telling> telling_ = std::make_shared<Telling>();
  std::mutex thread_mutex_;  // guards the next
  std::thread thread_;
};

}  // namespace torsio
