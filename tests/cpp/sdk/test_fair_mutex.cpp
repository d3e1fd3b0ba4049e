// The lock that a transport holds while it calls the system.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <vector>

#include "fair_mutex.hpp"

using namespace std::chrono_literals;

TEST_CASE("a thread that lets go of a fair mutex and comes back at once finds others before it") {
  torsio::FairMutex mutex;
  constexpr int kTimes = 10;
  int polite = 0;
  for (int i = 0; i < kTimes; ++i) {
    std::atomic<bool> served = false;
    mutex.lock();
    std::thread other([&] {
      const std::lock_guard<torsio::FairMutex> guard(mutex);
      served = true;
    });
    std::this_thread::sleep_for(10ms);  // by then it waits, unless the machine is very busy
    mutex.unlock();
    mutex.lock();
    if (served) ++polite;
    mutex.unlock();
    other.join();
  }
  CHECK(polite > kTimes / 2);
}

TEST_CASE("nobody who waits for a fair mutex is forgotten, however often it is handed over") {
  torsio::FairMutex mutex;
  constexpr int kThreads = 4;
  constexpr int kTimes = 5000;
  int sum = 0;  // guarded by the mutex, and by nothing else
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < kTimes; ++i) {
        const std::lock_guard<torsio::FairMutex> guard(mutex);
        ++sum;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();  // or it never ends
  CHECK(sum == kThreads * kTimes);
}
