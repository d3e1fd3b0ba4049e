#include "emulator/workers.hpp"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace torsio::emulator {
namespace {

/// A caller that works step by step gives the next piece within microseconds. To sleep and be woken
/// takes tens of them.
constexpr std::chrono::microseconds kPatience{50};

template <class Condition>
void wait_awake(Condition is_met) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!is_met() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
}

}  // namespace

/// Data that the threads share.
struct Workers::Team {
  const decltype(::getpid()) process = ::getpid();
  std::vector<std::thread> threads;
  std::mutex mutex;
  std::condition_variable news;  // for the threads: another piece of work, or the end
  std::condition_variable done;  // for the caller
  // All written under the mutex, except next_part.
  std::atomic<std::uint64_t> pieces{0};  // of work that came so far; the end counts as one
  std::atomic<unsigned> busy{0};         // threads that are at the present one
  std::atomic<unsigned> next_part{0};
  unsigned parts = 0;
  const Work* work = nullptr;  // null when nobody may join any more
  bool ends = false;

  void take_parts(unsigned of, const Work& what) {
    for (unsigned part = next_part++; part < of; part = next_part++) what(part);
  }

  void help() {
    std::unique_lock lock(mutex, std::defer_lock);
    for (std::uint64_t seen = 0;;) {
      wait_awake([&] { return pieces != seen; });
      lock.lock();
      news.wait(lock, [&] { return pieces != seen; });
      seen = pieces;
      if (ends) return;
      if (work != nullptr) {
        const Work& mine = *work;
        const unsigned of = parts;
        ++busy;
        lock.unlock();
        take_parts(of, mine);
        lock.lock();
        if (--busy == 0) done.notify_one();
      }
      lock.unlock();
    }
  }

  void run(unsigned of, unsigned with, const Work& what) {
    while (threads.size() + 1 < with) {
      try {
        threads.emplace_back([this] { help(); });
      } catch (const std::system_error&) {  // the system has no more of them
        break;
      }
    }
    {
      const std::lock_guard lock(mutex);
      parts = of;
      next_part = 0;
      work = &what;
      ++pieces;
    }
    for (unsigned thread = 1; thread < with; ++thread) news.notify_one();
    take_parts(of, what);
    std::unique_lock lock(mutex);
    work = nullptr;
    lock.unlock();
    wait_awake([&] { return busy == 0; });
    lock.lock();
    done.wait(lock, [&] { return busy == 0; });
  }

  void end() {
    {
      const std::lock_guard lock(mutex);
      ends = true;
      ++pieces;
    }
    news.notify_all();
    for (std::thread& thread : threads) thread.join();
  }
};

Workers::Workers() : team_(std::make_unique<Team>()) {}

Workers::~Workers() {
  if (team_->process == ::getpid()) {
    team_->end();
  } else {
    static_cast<void>(team_.release());  // its locks may be held for ever, and nobody can be joined
  }
}

void Workers::run(unsigned parts, unsigned threads, const Work& work) {
  if (team_->process != ::getpid()) {
    static_cast<void>(team_.release());
    team_ = std::make_unique<Team>();
  }
  team_->run(parts, threads, work);
}

}  // namespace torsio::emulator
