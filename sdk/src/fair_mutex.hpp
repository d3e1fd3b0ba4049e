/// @file
/// A lock for calls that take long.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace torsio {

/// Whoever waits longest is next. With std::mutex a thread that lets go and comes back at once can
/// keep all others out for as long as it likes: they are woken, and find it taken again.
class FairMutex {
 public:
  void lock() {
    std::unique_lock guard(mutex_);
    const std::uint64_t ticket = next_ticket_++;
    turn_.wait(guard, [&] { return ticket == now_serving_; });
  }
  void unlock() {
    {
      const std::lock_guard guard(mutex_);
      ++now_serving_;
    }
    turn_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable turn_;
  std::uint64_t next_ticket_ = 0;
  std::uint64_t now_serving_ = 0;
};

}  // namespace torsio
