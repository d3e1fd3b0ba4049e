// The device's own reports: events, the reason why the torque went, and recordings without
// it.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "protocol/reports.hpp"
#include "sdk/wrapped_transport.hpp"
#include "torsio/knob.hpp"

using namespace torsio;
using namespace std::chrono_literals;

namespace {

std::vector<std::string> kinds(const std::vector<Event>& events) {
  std::vector<std::string> kinds;
  for (const Event& event : events) kinds.push_back(event.kind);
  return kinds;
}

using Kinds = std::vector<std::string>;

/// Loses every event.
class WithoutEvents final : public test::WrappedTransport {
 public:
  using WrappedTransport::WrappedTransport;
  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    while (WrappedTransport::read(report, timeout)) {
      if (report[0] != protocol::Layout<protocol::Event>::id) return true;
    }
    return false;
  }
};

struct Waiting {
  std::uint8_t id = 0;  // the waiting report
  bool holds = false;
  std::deque<ReportBytes> reports;
};

/// Lets one kind of report wait while everything else goes past it.
class Late final : public test::WrappedTransport {
 public:
  Late(std::unique_ptr<Transport> inner, Waiting& waiting)
      : WrappedTransport(std::move(inner)), waiting_(waiting) {}
  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    if (!waiting_.holds && !waiting_.reports.empty()) {
      report = waiting_.reports.front();
      waiting_.reports.pop_front();
      return true;
    }
    while (WrappedTransport::read(report, timeout)) {
      if (!waiting_.holds || report[0] != waiting_.id) return true;
      waiting_.reports.push_back(report);
    }
    return false;
  }

 private:
  Waiting& waiting_;
};

Knob open_emulated(bool is_paced) {
  EmulatorOptions emulator;
  emulator.paced = is_paced;
  return Knob::open("emulated", {.emulator = emulator});
}

}  // namespace

TEST_CASE("events tell arming and disarming, in order, once") {
  Knob knob = Knob::open("emulated");
  CHECK(knob.events().empty());
  CHECK_FALSE(knob.last_disarm());
  knob.arm();
  knob.disarm();
  const std::vector<Event> events = knob.events();
  REQUIRE(kinds(events) == Kinds{"state_changed", "state_changed"});
  CHECK(events[0].state == State::armed);
  CHECK(events[0].owner == Owner::sdk);
  CHECK(events[1].state == State::disarmed);
  CHECK(events[1].owner == Owner::none);
  CHECK(events[1].tick > events[0].tick);
  CHECK(events[1].time_s == doctest::Approx(1e-3 * static_cast<double>(events[1].tick)));
  CHECK(knob.events().empty());
  REQUIRE(knob.last_disarm());
  CHECK(knob.last_disarm()->reason == DisarmReason::order);
  CHECK(knob.last_disarm()->tick == events[1].tick);
}

TEST_CASE("events wait for one, in the knob's time") {
  Knob knob = Knob::open("emulated");
  const double begin_s = knob.emulator().time_s();
  CHECK(knob.events(0.5).empty());
  CHECK(knob.emulator().time_s() - begin_s == doctest::Approx(0.5));
}

TEST_CASE("a fault is an event, and the reason why the torque went") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  (void)knob.events();
  knob.emulator().set_emergency_stop(true);
  const std::vector<Event> events = knob.events(1.0);
  REQUIRE(events.size() == 1);
  CHECK(events[0].state == State::fault);
  CHECK(events[0].faults == std::vector<std::string>{"emergency_stop"});
  REQUIRE(knob.last_disarm());
  CHECK(knob.last_disarm()->reason == DisarmReason::fault);
  CHECK(knob.last_disarm()->faults == std::vector<std::string>{"emergency_stop"});
}

TEST_CASE("a missed deadline disarms, and what is refused afterwards says so") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  knob.stream_local_model({.torque_nm = 0.01, .deadline_s = 0.02});
  CHECK(knob.wait_for(State::disarmed));
  CHECK(knob.last_disarm()->reason == DisarmReason::deadline_missed);
  CHECK(kinds(knob.events()) == Kinds{"state_changed", "deadline_missed", "state_changed"});
  try {
    knob.stream_local_model({.torque_nm = 0.01});
    FAIL("was not refused");
  } catch (const Refused& error) {
    CHECK(error.status() == "not_armed");
    CHECK(error.reason() == "deadline_missed");
    CHECK(std::string(error.what()).find("outlived its deadline") != std::string::npos);
  }
}

TEST_CASE("silence of the host is the reason why the torque went") {
  EmulatorOptions emulator{.control = ControlConfig{.watchdog_s = 0.05}};
  Knob knob = Knob::open("emulated", {.emulator = emulator});
  knob.arm();
  knob.emulator().set_link_faults({.drop_output = 1.0});
  CHECK(knob.wait_for(State::disarmed));
  CHECK(knob.last_disarm()->reason == DisarmReason::watchdog);
  // The next time has a reason of its own.
  knob.emulator().set_link_faults({});
  knob.arm();
  knob.disarm();
  CHECK(knob.last_disarm()->reason == DisarmReason::order);
}

TEST_CASE("the end of the connection is an event") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  knob.sleep(0.1);
  knob.play(Spring{.stiffness_nm_per_rad = 0.1});  // its answer is the last word of the device
  knob.emulator().unplug();
  CHECK(knob.state() == State::disconnected);
  const std::vector<Event> events = knob.events();
  REQUIRE_FALSE(events.empty());
  CHECK(events.back().state == State::disconnected);
  CHECK(events.back().tick > 100);
  CHECK(knob.last_disarm()->reason == DisarmReason::disconnected);
}

TEST_CASE("a state whose event was lost is told by the telemetry") {
  for (const bool by_fault : {false, true}) {
    CAPTURE(by_fault);
    EmulatorOptions emulator;
    emulator.control = ControlConfig{.watchdog_s = 0.1};
    Knob knob = Knob::open("emulated", {.emulator = emulator});
    knob.arm();
    knob.start_telemetry();
    knob.sleep(0.02);
    // Nothing comes, as where a program is stopped and the computer's queue is full.
    knob.emulator().set_link_faults({.drop_output = 1.0, .drop_input = 1.0});
    if (by_fault) knob.emulator().set_emergency_stop(true);
    knob.sleep(0.5);
    CHECK(knob.state() == State::armed);
    knob.emulator().set_link_faults({});
    knob.sleep(0.01);
    CHECK(knob.state() == (by_fault ? State::fault : State::disarmed));
    REQUIRE(knob.last_disarm());
    CHECK(knob.last_disarm()->reason == (by_fault ? DisarmReason::fault : DisarmReason::unknown));
    CHECK(knob.last_disarm()->tick > 500);
  }
}

TEST_CASE("a health report that is quicker than its event leaves the reason to the event") {
  EmulatorOptions emulator{.control = ControlConfig{.watchdog_s = 0.05}};
  Knob knob = Knob::open("emulated", {.emulator = emulator});
  knob.arm();
  knob.emulator().set_link_faults({.drop_output = 1.0});
  for (int ms = 0; ms < 1000 && knob.health().state == State::armed; ++ms) knob.sleep(0.0005);
  CHECK(knob.state() == State::disarmed);
  knob.sleep(0.01);
  CHECK(knob.last_disarm()->reason == DisarmReason::watchdog);
}

TEST_CASE("an order to disarm is the reason also where its event was lost") {
  Knob knob = Knob::open(std::make_unique<WithoutEvents>(open_transport("emulated")));
  knob.arm();
  knob.disarm();
  CHECK(knob.events().empty());
  REQUIRE(knob.last_disarm());
  CHECK(knob.last_disarm()->reason == DisarmReason::order);
}

TEST_CASE("telemetry from before it was armed does not say that a knob has let go") {
  Waiting waiting{.id = protocol::Layout<protocol::Telemetry>::id, .reports = {}};
  Knob knob = Knob::open(std::make_unique<Late>(open_transport("emulated"), waiting));
  knob.start_telemetry();
  knob.sleep(0.02);
  waiting.holds = true;
  knob.sleep(0.02);
  knob.arm();
  waiting.holds = false;
  (void)knob.read(1, 0.01);
  CHECK(knob.state() == State::armed);
  CHECK_FALSE(knob.last_disarm());
}

TEST_CASE("a callback that lets more happen than is kept is told the newest") {
  Knob knob = open_emulated(false);
  int told = 0;
  knob.on_event([&](const Event&) {
    if (told++ != 0) return;
    for (int i = 0; i < 600; ++i) {
      knob.disarm();
      knob.arm();
    }
  });
  knob.arm();
  knob.sleep(0.01);
  CHECK(told == 1 + 1024);
}

TEST_CASE("events that nobody takes are kept up to a number, and the lost are counted") {
  Knob knob = Knob::open("emulated");
  for (int i = 0; i < 600; ++i) {
    knob.arm();
    knob.disarm();
  }
  CHECK(knob.events().size() == 1024);
  CHECK(knob.statistics().events_lost == 1200 - 1024);
}

TEST_CASE("a callback is told every event under no lock, and may use the knob") {
  for (const bool is_paced : {false, true}) {
    CAPTURE(is_paced);
    Knob knob = open_emulated(is_paced);
    std::atomic<int> told = 0;
    std::atomic<int> faults = 0;
    knob.on_event([&](const Event& event) {
      faults += knob.health().state == State::fault ? 1 : 0;
      told += event.kind == "state_changed" ? 1 : 0;
    });
    knob.arm();
    knob.disarm();
    for (int i = 0; i < 500 && told < 2; ++i) knob.sleep(0.005);
    CHECK(told == 2);
    CHECK(faults == 0);
    CHECK(knob.events().size() == 2);
    knob.on_event({});
    knob.arm();
    knob.sleep(0.02);
    CHECK(told == 2);
  }
}

TEST_CASE("a knob that is closed lets go of its callback") {
  for (const bool paced : {false, true}) {
    const auto held = std::make_shared<std::atomic<int>>(0);
    Knob knob = open_emulated(paced);
    knob.on_event([held](const Event&) { ++*held; });
    CHECK(held.use_count() == 2);
    knob.close();
    CHECK(held.use_count() == 1);
  }
}

TEST_CASE("a callback that is slow is told what happened until its knob was closed") {
  for (const bool is_paced : {false, true}) {
    CAPTURE(is_paced);
    Knob knob = open_emulated(is_paced);
    std::vector<State> told;
    knob.on_event([&](const Event& event) {
      std::this_thread::sleep_for(20ms);
      told.push_back(event.state);
    });
    knob.arm();
    knob.disarm();
    knob.arm();
    knob.close();
    CHECK(told == std::vector{State::armed, State::disarmed, State::armed, State::disarmed});
  }
}

TEST_CASE("what a callback throws ends it, and comes out of the next on_event") {
  for (const bool is_paced : {false, true}) {
    CAPTURE(is_paced);
    Knob knob = open_emulated(is_paced);
    std::atomic<int> told = 0;
    knob.on_event([&](const Event&) {
      ++told;
      throw std::runtime_error("of the callback");
    });
    knob.arm();
    for (int i = 0; i < 500 && told < 1; ++i) knob.sleep(0.005);
    knob.disarm();
    knob.sleep(0.05);
    CHECK(told == 1);
    CHECK_THROWS_WITH_AS(knob.on_event({}), "of the callback", std::runtime_error);
    CHECK_NOTHROW(knob.on_event({}));
  }
}

TEST_CASE("a callback may close its knob, whatever it is told") {
  for (const bool is_paced : {false, true}) {
    for (const bool is_unplugged : {false, true}) {
      CAPTURE(is_paced);
      CAPTURE(is_unplugged);
      Knob knob = open_emulated(is_paced);
      std::atomic<int> closed = 0;
      knob.on_event([&](const Event& event) {
        if (is_unplugged && event.state != State::disconnected) return;
        knob.close();
        ++closed;
      });
      try {
        knob.arm();
        if (is_unplugged) knob.emulator().unplug();
        for (int i = 0; i < 500; ++i) knob.sleep(0.01);
        FAIL("a closed knob goes on");
      } catch (const Error&) {  // Closed, or Disconnected if that was noticed first
      }
      for (int i = 0; i < 500 && closed == 0; ++i) std::this_thread::sleep_for(10ms);
      CHECK(closed == 1);
      CHECK_FALSE(knob.is_open());
      CHECK_THROWS_AS(knob.arm(), Closed);
    }
  }
}

TEST_CASE("a callback that closes the knob is let go by whoever closes it meanwhile") {
  // In virtual time closing itself calls back, with the event that it disarms.
  for (const bool is_paced : {false, true}) {
    CAPTURE(is_paced);
    Knob knob = open_emulated(is_paced);
    std::atomic<bool> runs = false;
    std::atomic<bool> may_close = false;
    std::atomic<bool> ended = false;
    knob.on_event([&](const Event& event) {
      runs = true;
      while (is_paced && !may_close) std::this_thread::yield();
      if (is_paced || event.state == State::disarmed) knob.close();
      ended = true;
    });
    knob.arm();
    while (is_paced && !runs) std::this_thread::yield();
    std::thread other([&] {
      std::this_thread::sleep_for(20ms);
      may_close = true;
    });
    knob.close();
    CHECK(ended);
    CHECK_FALSE(knob.is_open());
    other.join();
  }
}

TEST_CASE("a callback that has closed the knob has ended when another close returns") {
  Knob knob = open_emulated(true);
  std::atomic<bool> closed = false;
  std::atomic<bool> ended = false;
  knob.on_event([&](const Event&) {
    knob.close();
    closed = true;
    std::this_thread::sleep_for(50ms);
    ended = true;
  });
  knob.arm();
  while (!closed) std::this_thread::yield();
  knob.close();
  CHECK(ended);
}

TEST_CASE("a callback that another thread is in has ended when close returns") {
  Knob knob = open_emulated(false);
  std::atomic<bool> begun = false;
  std::atomic<bool> ended = false;
  knob.on_event([&](const Event&) {
    begun = true;
    std::this_thread::sleep_for(50ms);
    ended = true;
  });
  std::thread other([&] {
    try {
      knob.arm();
    } catch (const Closed&) {  // maybe
    }
  });
  while (!begun) std::this_thread::yield();
  knob.close();
  CHECK(ended);
  other.join();
}

TEST_CASE("a callback that lets time pass is told the next event when it has returned") {
  Knob knob = open_emulated(false);
  std::vector<std::string> told;
  knob.on_event([&](const Event& event) {
    const bool is_armed = event.state == State::armed;
    told.push_back(is_armed ? "armed" : "disarmed");
    if (is_armed) knob.disarm();
    if (is_armed) told.push_back("end of armed");
  });
  knob.arm();
  knob.sleep(0.01);
  CHECK(told == Kinds{"armed", "end of armed", "disarmed"});
}

TEST_CASE("a recording says how the torque went") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  CHECK_FALSE(knob.record(0.1).disarmed);
  knob.stream_local_model({.torque_nm = 0.01, .deadline_s = 0.02});
  const TelemetryRecord recording = knob.record(0.5);
  CHECK(recording.size() == 500);
  REQUIRE(recording.disarmed);
  CHECK(recording.disarmed->reason == DisarmReason::deadline_missed);
  CHECK_FALSE(knob.record(0.1).disarmed);  // that was before
}

TEST_CASE("a recording that must stay armed ends when the torque goes, with what it has") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  knob.stream_local_model({.torque_nm = 0.01, .deadline_s = 0.02});
  try {
    (void)knob.record(10.0, {}, true);
    FAIL("did not throw");
  } catch (const Disarmed& error) {
    CHECK(error.reason() == "deadline_missed");
    REQUIRE(error.samples() != nullptr);
    CHECK(error.samples()->size() > 20);
    CHECK(error.samples()->size() < 1000);
  }
  CHECK(knob.state() == State::disarmed);

  knob.arm();
  knob.stream_local_model({.torque_nm = 0.01, .deadline_s = 0.02});
  TelemetryRecord into;
  CHECK_THROWS_AS(knob.record(into, 10.0, {}, true), Disarmed);
  REQUIRE(into.disarmed);
  CHECK(into.disarmed->reason == DisarmReason::deadline_missed);
}

TEST_CASE("a recording that must stay armed does not begin without torque") {
  Knob knob = Knob::open("emulated");
  CHECK_THROWS_AS((void)knob.record(0.1, {}, true), Disarmed);  // nobody has armed it
  knob.arm();
  knob.stream_local_model({.torque_nm = 0.01, .deadline_s = 0.02});
  knob.sleep(0.2);
  try {
    (void)knob.record(0.1, {}, true);
    FAIL("did not throw");
  } catch (const Disarmed& error) {
    CHECK(error.reason() == "deadline_missed");
  }
  CHECK(knob.record(0.1).size() == 100);  // as good as ever
}

TEST_CASE("a recording says that it begins without torque and ends armed") {
  EmulatorOptions options;
  options.paced = true;
  Knob knob = Knob::open("emulated", {.emulator = options});
  CHECK_FALSE(knob.record(0.01).armed_late);
  TelemetryRecord recording;
  // On a busy machine the other thread may be too quick or too slow.
  for (int left = 10; left > 0 && !recording.armed_late; --left) {
    knob.disarm();
    const std::uint64_t before = knob.statistics().samples_received;
    std::thread later([&] {
      while (knob.statistics().samples_received < before + 50) std::this_thread::yield();
      knob.arm();
    });
    recording = knob.record(0.5);
    later.join();
  }
  CHECK(recording.armed_late);
  CHECK_FALSE(recording.disarmed);
  CHECK_FALSE(knob.record(0.01).armed_late);
}
