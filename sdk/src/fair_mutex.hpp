/// @file
/// A lock for calls that take long.
#pragma once

#include <atomic>

namespace torsio {

/// Whoever waits longest is next. With std::mutex a thread that lets go and comes back at once can
/// keep all others out for as long as it likes: they are woken, and find it taken again.
class FairMutex {
 public:
  void lock() {
    const unsigned ticket = next_ticket_.fetch_add(1, std::memory_order_relaxed);
    while (true) {
      const unsigned now_serving = now_serving_.load(std::memory_order_acquire);
      if (now_serving == ticket) return;
      now_serving_.wait(now_serving, std::memory_order_relaxed);
    }
  }
  void unlock() {
    now_serving_.fetch_add(1, std::memory_order_release);
    now_serving_.notify_all();
  }

 private:
  std::atomic<unsigned> next_ticket_{0};
  std::atomic<unsigned> now_serving_{0};
};

}  // namespace torsio
