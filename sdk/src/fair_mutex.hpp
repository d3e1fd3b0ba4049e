/// @file
/// A lock for calls that take long.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

namespace torsio {

/// The longest waiter is next. With std::mutex a thread that lets go and comes back at once can
/// keep all others out: they wake and find it taken again.
class FairMutex {
 public:
  void lock() {
    const unsigned ticket = next_ticket_.fetch_add(1);
    if (now_serving_ == ticket) return;
    // Not std::atomic's own wait: MinGW's GCC 12 looks first, and sleeps through a call that comes
    // before it is asleep.
    std::unique_lock lock(waiting_);
    called_.wait(lock, [&] { return now_serving_ == ticket; });
  }
  void unlock() {
    const unsigned next = now_serving_.fetch_add(1) + 1;
    if (next_ticket_ == next) return;  // nobody waits
    const std::lock_guard lock(waiting_);
    called_.notify_all();
  }

 private:
  std::atomic<unsigned> next_ticket_{0};
  std::atomic<unsigned> now_serving_{0};
  std::mutex waiting_;
  std::condition_variable called_;
};

}  // namespace torsio
