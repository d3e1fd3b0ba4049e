// Several threads on one knob, in wall-clock and in virtual time. Worth most under tsan.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "sdk/busy_threads.hpp"
#include "torsio/knob.hpp"

using namespace torsio;
using namespace std::chrono_literals;
using std::chrono::steady_clock;

namespace {

OpenOptions paced() {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->paced = true;
  options.emulator->hand = TorqueHand{{{0.0, 0.03}}};
  // A busy machine may keep every thread waiting, so no test asks how long.
  options.command_timeout_s = 60.0;
  return options;
}

double seconds_since(steady_clock::time_point begin) {
  return std::chrono::duration<double>(steady_clock::now() - begin).count();
}

}  // namespace

TEST_CASE("a world that takes longer than it lasts still lets calls in, and closes") {
  OpenOptions options = paced();
  options.emulator->hand = FeedbackHand{[](double, double, double) {
    std::this_thread::sleep_for(std::chrono::microseconds(1500));
    return 0.0;
  }};
  Knob knob = Knob::open("emulated", options);
  knob.sleep(0.05);
  knob.arm();
  CHECK(knob.state() == State::armed);
  CHECK(knob.record(0.01).size() == 10);
  knob.close();  // once it did not come back from here
}

TEST_CASE("a paced emulated knob keeps to the wall clock") {
  const auto begin = steady_clock::now();
  Knob knob = Knob::open("emulated", paced());
  const auto asleep = steady_clock::now();
  knob.sleep(0.2);
  CHECK(seconds_since(asleep) >= 0.2);
  // The world may fall behind a busy machine, and catch up, but never run ahead.
  const double world_s = knob.emulator().time_s();
  CHECK(world_s <= seconds_since(begin) + 0.002);
  knob.arm();
  knob.play(Wall{.angle_rad = 0.01, .stiffness_nm_per_rad = 1.0});
  CHECK(knob.record(0.2).size() == 200);
  CHECK(knob.statistics().samples_lost == 0);
}

TEST_CASE("calls of several threads on a paced knob all get their answers") {
  Knob knob = Knob::open("emulated", paced());
  knob.arm();
  {
    test::BusyThreads threads(knob);
    threads.keep_doing([&] { knob.emulator().set_hand(TorqueHand{{{0.0, 0.03}}}); });
    CHECK(knob.record(0.5).size() == 500);
  }
  CHECK(knob.state() == State::armed);
  CHECK(knob.statistics().samples_lost == 0);
}

TEST_CASE("calls of several threads in virtual time all get their answers") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  std::atomic<int> done = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) knob.play(Constant{.torque_nm = 1e-4 * i});
      ++done;
    });
  }
  threads.emplace_back([&] {
    CHECK(knob.record(1.0).size() == 1000);
    ++done;
  });
  for (std::thread& thread : threads) thread.join();
  CHECK(done == 4);
  CHECK(knob.state() == State::armed);
}

TEST_CASE("closing a knob wakes whoever waits on it with Closed") {
  for (const bool is_paced : {true, false}) {
    CAPTURE(is_paced);
    OpenOptions options = paced();
    options.emulator->paced = is_paced;
    Knob knob = Knob::open("emulated", options);
    knob.arm();
    std::atomic<bool> closed = false;
    std::thread waiter([&] {
      try {
        knob.sleep(1e8);
      } catch (const Closed&) {
        closed = true;
      }
    });
    std::this_thread::sleep_for(30ms);
    knob.close();
    waiter.join();  // or it never ends
    CHECK(closed);
  }
}

TEST_CASE("unplugging a paced knob wakes a waiting call") {
  Knob knob = Knob::open("emulated", paced());
  knob.start_telemetry();
  std::thread puller([&] {
    std::this_thread::sleep_for(30ms);
    knob.emulator().unplug();
  });
  const auto begin = steady_clock::now();
  CHECK_THROWS_AS(knob.sleep(60.0), Disconnected);
  CHECK(seconds_since(begin) < 30.0);
  CHECK(knob.state() == State::disconnected);
  puller.join();
}

TEST_CASE("a paced knob can be interrupted while it waits for an answer that never comes") {
  OpenOptions options = paced();
  std::atomic<bool> interrupt = false;
  options.interrupted = [&] { return interrupt.load(); };
  Knob knob = Knob::open("emulated", options);
  knob.emulator().set_link_faults({.drop_output = 1.0});
  std::thread interrupter([&] {
    std::this_thread::sleep_for(30ms);
    interrupt = true;
  });
  const auto begin = steady_clock::now();
  CHECK_THROWS_AS(knob.arm(), Interrupted);
  CHECK(seconds_since(begin) < 30.0);
  interrupter.join();
}

TEST_CASE("a paced knob that nobody talks to stays armed") {
  OpenOptions options = paced();
  options.emulator->control = ControlConfig{.watchdog_s = 0.5};
  Knob knob = Knob::open("emulated", options);
  knob.arm();
  std::this_thread::sleep_for(1200ms);
  CHECK(knob.health().state == State::armed);
}
