// A recording, several threads, a child process and a lying device do not break the library.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "protocol/reports.hpp"
#include "sdk/wrapped_transport.hpp"
#include "torsio/knob.hpp"

#ifndef _WIN32
#include <sys/wait.h>
#include <unistd.h>
#endif

using namespace torsio;
using namespace std::chrono_literals;

namespace {

OpenOptions paced_device() {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->paced = true;
  return options;
}

/// Its samples follow each other at one distance and none is missing.
bool is_whole(const std::vector<TelemetrySample>& samples, std::uint64_t ticks) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].tick != samples[i - 1].tick + 1) return false;
  }
  return samples.size() == ticks;
}

/// Over a device that lies in one of its answers.
template <class Report, class Change>
void open_with(Change change) {
  Knob knob = Knob::open(test::emulated_with<Report>(change));
  (void)knob.clock();
  (void)knob.record(0.01);
}

}  // namespace

TEST_CASE("recordings of several threads are all whole, whoever starts and stops telemetry") {
  for (const bool is_paced : {true, false}) {
    CAPTURE(is_paced);
    OpenOptions options = paced_device();
    options.emulator->paced = is_paced;
    Knob knob = Knob::open("emulated", options);
    std::atomic<bool> go_on = true;
    std::atomic<int> done = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < 2; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 5; ++i) done += is_whole(knob.record(0.03), 30) ? 1 : 0;
      });
    }
    std::thread stopper([&] {
      while (go_on) {
        knob.stop_telemetry();
        knob.sleep(0.001);
      }
    });
    for (std::thread& thread : threads) thread.join();
    go_on = false;
    stopper.join();
    CHECK(done == 10);
    CHECK(knob.statistics().samples_lost == 0);
  }
}

TEST_CASE("telemetry runs after a recording only if somebody has started it") {
  Knob knob = Knob::open("emulated");
  CHECK(knob.record(0.01).size() == 10);
  knob.sleep(0.05);
  CHECK(knob.read(100, 0.02).empty());
  knob.start_telemetry();
  CHECK(knob.record(0.01).size() == 10);
  CHECK_FALSE(knob.read(100, 0.02).empty());
}

TEST_CASE("an interrupted recording keeps its samples and stops telemetry") {
  int left = 3;
  OpenOptions options = paced_device();
  options.interrupted = [&] { return --left < 0; };
  Knob knob = Knob::open("emulated", options);
  left = 10;
  std::size_t kept = 0;
  try {
    (void)knob.record(60.0);
  } catch (const Interrupted& error) {
    REQUIRE(error.samples() != nullptr);
    kept = error.samples()->size();
  }
  CHECK(kept > 20);
  left = 1'000'000;
  // They can be read as well, and more do not come.
  std::size_t read = 0;
  while (const std::size_t some = knob.read(4096, 0.05).size()) read += some;
  CHECK(read >= kept);
  CHECK(read < kept + 300);
}

TEST_CASE("a recording whose user throws keeps its samples where they are put") {
  int left = 100;
  OpenOptions options = paced_device();
  options.interrupted = [&]() -> bool {
    if (--left < 0) throw std::runtime_error("the user's own");
    return false;
  };
  Knob knob = Knob::open("emulated", options);
  left = 10;
  TelemetryRecord samples;
  CHECK_THROWS_WITH_AS(knob.record(samples, 60.0), "the user's own", std::runtime_error);
  CHECK(samples.size() > 20);
  left = 1'000'000;
}

TEST_CASE("an unplugged or closed recording gives what came until then") {
  for (const bool pulled : {true, false}) {
    CAPTURE(pulled);
    Knob knob = Knob::open("emulated", paced_device());
    std::thread ender([&] {
      while (knob.statistics().samples_received < 200) std::this_thread::yield();
      if (pulled) return knob.emulator().unplug();
      knob.close();
    });
    std::size_t kept = 0;
    try {
      (void)knob.record(60.0);
    } catch (const Error& error) {
      CHECK((dynamic_cast<const Disconnected*>(&error) != nullptr) == pulled);
      REQUIRE(error.samples() != nullptr);
      kept = error.samples()->size();
    }
    ender.join();
    CHECK(kept > 0);
    CHECK(kept < 10'000);
  }
}

#ifndef _WIN32  // Windows does not fork
TEST_CASE("a forked child can neither use nor keep its parent's knob") {
  Knob knob = Knob::open("emulated", paced_device());
  knob.arm();
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    bool as_it_should = !knob.is_open();
    try {
      knob.disarm();
      as_it_should = false;
    } catch (const Closed& error) {
      as_it_should = as_it_should && std::string(error.what()).find("fork") != std::string::npos;
    }
    {
      const Knob destroyed = std::move(knob);
    }
    _exit(as_it_should ? 0 : 1);
  }
  int status = -1;
  for (int tries = 0; tries < 500 && waitpid(child, &status, WNOHANG) == 0; ++tries) {
    std::this_thread::sleep_for(20ms);
  }
  if (status == -1) {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
  CHECK(status == 0);
  CHECK(knob.health().state == State::armed);
}
#endif

TEST_CASE("a stop or a fault that is let go can be cleared at once") {
  Knob knob = Knob::open("emulated");
  Emulator& world = knob.emulator();
  const auto clears = [&](auto&& set) {
    set(true);
    REQUIRE(knob.wait_for(State::fault));
    CHECK_THROWS_AS(knob.clear_fault(), Refused);
    set(false);
    CHECK_NOTHROW(knob.clear_fault());
    CHECK(knob.state() == State::disarmed);
  };
  clears([&](bool pressed) { world.set_emergency_stop(pressed); });
  clears([&](bool present) { world.set_actuator_fault(present); });
}

TEST_CASE("an identity that no device can have is refused") {
  using protocol::Identity;
  for (const std::uint32_t period_ns : {0U, 1U, 2U, 1000U, 49'999U, 1'000'001U, UINT32_MAX}) {
    CAPTURE(period_ns);
    CHECK_THROWS_AS(open_with<Identity>([&](Identity& it) { it.control_period_ns = period_ns; }),
                    Error);
  }
  CHECK_THROWS_AS(open_with<Identity>([](Identity& it) { it.counts_per_rev = 0; }), Error);
  CHECK_THROWS_AS(open_with<Identity>([](Identity& it) { it.effects = 255; }), Error);
  CHECK_THROWS_AS(open_with<Identity>([](Identity& it) { it.curve_points = 65535; }), Error);
  CHECK_THROWS_AS(open_with<Identity>([](Identity& it) { it.torque_step_nm = 0.0F; }), Error);
  CHECK_THROWS_AS(open_with<Identity>([](Identity& it) { it.torque_step_nm = -1.0F; }), Error);
  CHECK_NOTHROW(open_with<Identity>([](Identity& it) { it.control_period_ns = 50'000; }));
}

TEST_CASE("a serial number that is no text is shown as question marks") {
  const Knob knob = Knob::open(test::emulated_with<protocol::Identity>(
      [](auto& identity) { identity.serial = {0xFF, 'a', 0x01, 0x7F}; }));
  CHECK(knob.info().serial == "?a??");
}

TEST_CASE("a clock that no device can have is refused") {
  using protocol::Clock;
  CHECK_THROWS_AS(open_with<Clock>([](Clock& it) { it.position_counts = INT64_MAX; }), Error);
  CHECK_THROWS_AS(open_with<Clock>([](Clock& it) { it.position_counts = INT64_MIN; }), Error);
  CHECK_THROWS_AS(open_with<Clock>([](Clock& it) { it.tick = UINT64_MAX; }), Error);
  CHECK_NOTHROW(open_with<Clock>([](Clock& it) { it.position_counts = std::int64_t{1} << 61; }));
}
