/// @file
/// Threads that never stop calling one knob: play scenes, ask it everything, stream to it.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "torsio/knob.hpp"

namespace torsio::test {

class BusyThreads {
 public:
  explicit BusyThreads(Knob& knob) {
    keep_doing([&knob, i = 0]() mutable { knob.play(Constant{.torque_nm = 1e-5 * (i++ % 100)}); });
    keep_doing([&knob] {
      (void)knob.clock();
      (void)knob.health();
      (void)knob.state();
      (void)knob.statistics();
      (void)knob.info();
    });
    keep_doing([&knob] {
      knob.stream_local_model({.torque_nm = 1e-3, .deadline_s = 1.0});
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    });
  }
  ~BusyThreads() {
    go_on_ = false;
    for (std::thread& thread : threads_) thread.join();
  }
  BusyThreads(const BusyThreads&) = delete;
  BusyThreads& operator=(const BusyThreads&) = delete;

  template <class Call>
  void keep_doing(Call call) {
    threads_.emplace_back([this, call]() mutable {
      while (go_on_) call();
    });
  }

 private:
  std::atomic<bool> go_on_ = true;
  std::vector<std::thread> threads_;
};

}  // namespace torsio::test
