// Threads against each other, again and again, for -fsanitize=thread: recordings while telemetry is
// stopped, an end while all are in calls, callbacks that are replaced or close their knob.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "sdk/fake_hidapi.hpp"
#include "torsio/hotplug.hpp"
#include "torsio/knob.hpp"

using namespace torsio;
using namespace std::chrono_literals;

namespace {

Knob open_one(bool is_paced) {
  EmulatorOptions emulator;
  emulator.paced = is_paced;
  return Knob::open("emulated", {.emulator = emulator});
}

/// Threads that call again and again until the knob is gone: Closed or Disconnected ends each of
/// them, and nothing else of the library's does.
class Users {
 public:
  ~Users() { join(); }
  Users() = default;
  Users(const Users&) = delete;
  Users& operator=(const Users&) = delete;

  void add(std::function<void()> call) {
    threads_.emplace_back([this, call = std::move(call)] {
      for (++inside_;;) {
        try {
          call();
        } catch (const Closed&) {
          return;
        } catch (const Disconnected&) {
          return;
        } catch (const Error&) {  // refused, because another thread has disarmed, for example
        }
      }
    });
  }
  /// Until each has begun.
  void wait() const {
    while (inside_ < static_cast<int>(threads_.size())) std::this_thread::yield();
    std::this_thread::sleep_for(25ms);
  }
  void join() {
    for (std::thread& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }

 private:
  std::vector<std::thread> threads_;
  std::atomic<int> inside_ = 0;
};

/// Everybody who may be inside when a program ends.
void use(Users& users, Knob& knob) {
  users.add([&] { (void)knob.record(0.02); });
  users.add([&] { (void)knob.record(0.02, 500.0); });
  users.add([&] { knob.stop_telemetry(); });
  users.add([&] {
    knob.start_telemetry({}, true);
    (void)knob.latest();
    (void)knob.read(100, 0.002);
  });
  users.add([&] {
    knob.arm();
    knob.stream_local_model({.torque_nm = 1e-3, .deadline_s = 0.05});
    knob.disarm();
  });
  users.add([&] {
    (void)knob.events(0.002);
    (void)knob.last_disarm();
    (void)knob.statistics();
    (void)knob.health();
  });
  users.add([&] {
    for (const Step step : knob.every(0.001)) {
      if (step.index == 3) break;
    }
  });
}

}  // namespace

TEST_CASE("races: a knob that is closed, pulled or let go by a callback under everybody's hands") {
  enum class Ends { closed, unplugged, closed_twice, closed_by_its_callback };
  for (const bool is_paced : {true, false}) {
    for (const Ends how :
         {Ends::closed, Ends::unplugged, Ends::closed_twice, Ends::closed_by_its_callback}) {
      CAPTURE(is_paced);
      CAPTURE(static_cast<int>(how));
      Knob knob = open_one(is_paced);
      std::atomic<bool> may_close = false;
      std::atomic<int> told = 0;
      knob.on_event([&](const Event&) {
        ++told;
        if (how == Ends::closed_by_its_callback && may_close) knob.close();
      });
      Users users;
      use(users, knob);
      users.wait();
      while (told == 0) std::this_thread::yield();
      if (how == Ends::unplugged) knob.emulator().unplug();
      if (how == Ends::closed_twice) {
        std::thread other([&] { knob.close(); });
        knob.close();
        other.join();
      }
      if (how == Ends::closed) knob.close();
      may_close = true;
      users.join();
      CHECK_THROWS_AS(knob.arm(), Error);
    }
  }
}

TEST_CASE("races: callbacks of events that are replaced while they run and use their knob") {
  for (const bool is_paced : {true, false}) {
    CAPTURE(is_paced);
    Knob knob = open_one(is_paced);
    std::atomic<int> told = 0;
    Users users;
    users.add([&] {
      knob.arm();
      knob.disarm();
    });
    users.add([&] { (void)knob.record(0.01); });
    for (int i = 0; i < 20 || told == 0; ++i) {
      // A callback's own objects go with it.
      knob.on_event([&, own = std::make_shared<int>(i)](const Event& event) {
        if (event.state == State::disconnected) return;
        told += *own >= 0 ? 1 : 0;
        (void)knob.health();
        (void)knob.events();
      });
      knob.sleep(0.01);
      if (i % 4 == 3) knob.on_event({});
    }
    knob.close();
  }
}

TEST_CASE("races: watches that are stopped by their callback and by others while knobs come") {
  for (int round = 0; round < 10; ++round) {
    test::FakeBus bus;
    bus.plug_in({.path = "1-1:1.0", .serial = L"A1"});
    bus.plug_in({.path = "1-2:1.0", .serial = L"B2"});
    std::atomic<DeviceWatch*> made = nullptr;
    std::atomic<int> calls = 0;
    DeviceWatch watch([&](const DeviceEvent& event) {
      ++calls;
      try {
        Knob::open(event.device.serial).close();
      } catch (const Error&) {  // gone again
      }
      DeviceWatch* own = nullptr;
      while ((own = made.load()) == nullptr) std::this_thread::yield();
      if (round % 2 == 0) own->stop();
    });
    made = &watch;
    DeviceWatch other;
    std::thread lister([&] {
      for (int i = 0; i < 5; ++i) (void)list_devices();
    });
    std::thread taker([&] { CHECK(other.next(20.0)); });
    std::thread plugger([&] { bus.plug_in({.path = "1-3:1.0", .serial = L"C3"}); });
    std::thread stopper([&] {
      while (calls == 0) std::this_thread::yield();
      watch.stop();
    });
    watch.stop();
    for (std::thread* thread : {&lister, &taker, &plugger, &stopper}) {
      if (thread == &stopper && calls == 0) calls = 1;  // stopped before it was told anything
      thread->join();
    }
    other.stop();
    CHECK(watch.is_stopped());
    CHECK(other.is_stopped());
  }
}
