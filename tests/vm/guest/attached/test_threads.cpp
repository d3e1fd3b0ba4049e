// Several threads on one knob that the kernel has.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "torsio/knob.hpp"
#include "virtual_knob.hpp"

using namespace torsio;
using namespace std::chrono_literals;

TEST_CASE("calls of several threads on an attached knob all get their answers") {
  test::VirtualKnob plugged({"--serial", "THREADS"});
  plugged.plug();
  Knob knob = Knob::open("THREADS");
  knob.arm();
  std::atomic<bool> go_on = true;
  std::vector<std::thread> threads;
  threads.emplace_back([&] {
    for (int i = 0; go_on; ++i) knob.play(Constant{.torque_nm = 1e-5 * (i % 100)});
  });
  threads.emplace_back([&] {
    while (go_on) {
      (void)knob.clock();
      (void)knob.health();
      (void)knob.state();
      (void)knob.statistics();
      (void)knob.info();
    }
  });
  threads.emplace_back([&] {
    while (go_on) {
      knob.stream_local_model({.torque_nm = 1e-3, .deadline_s = 1.0});
      std::this_thread::sleep_for(2ms);
    }
  });
  CHECK(knob.record(0.5).size() == 500);
  go_on = false;
  for (std::thread& thread : threads) thread.join();
  CHECK(knob.state() == State::armed);
  CHECK(knob.statistics().samples_lost == 0);
  knob.close();
}
