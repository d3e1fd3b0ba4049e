// The lock that a transport holds while it calls the system.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

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
