// The control loop by itself: orders and inputs that no report can bring about.
#include <doctest/doctest.h>

#include <limits>
#include <memory>
#include <vector>

#include "device/control_loop.hpp"
#include "device/game/forces.hpp"

using namespace torsio;
using device::ControlLoop;
using device::Order;
using protocol::EventKind;
using protocol::State;
using protocol::Status;

namespace {

struct Loop {
  Loop() : Loop(protocol::ControlConfig{}) {}
  explicit Loop(protocol::ControlConfig control) {
    device::Config config;
    config.control = control;
    config.control.law = protocol::Law::motor_only;
    settings = device::make_loop_config(config, 1'000'000);
    loop = std::make_unique<ControlLoop>(settings, game);
  }
  void give(Order order) {
    REQUIRE(loop->takes_order());
    loop->give(order);
    tick();
  }
  void give(Order::Kind kind) {
    Order order;
    order.kind = kind;
    give(order);
  }
  void play(float torque_nm) {
    auto scene = std::make_unique<core::Scene>();
    scene->effect[0] = core::Constant{torque_nm, {}};
    scene->active = 1;
    Order order;
    order.kind = Order::Kind::play;
    order.commit = {scene.get(), 1};
    give(order);
    scenes.push_back(std::move(scene));
  }
  void tick(int count = 1) {
    for (; count > 0; --count) out = loop->tick(in);
  }
  State state() const { return loop->snapshot().state; }
  Status answer() {
    Status status = Status::ok;
    while (const device::Answer* answer = loop->mail.answers.front()) {
      if (!answer->is_event) status = static_cast<Status>(answer->acknowledgement.status);
      loop->mail.answers.pop();
    }
    return status;
  }

  device::LoopConfig settings;
  device::game::Forces game{{}};
  std::unique_ptr<ControlLoop> loop;
  std::vector<std::unique_ptr<core::Scene>> scenes;
  device::TickInputs in;
  device::TickOutputs out;
};

protocol::ControlConfig without_ramp() {
  protocol::ControlConfig control;
  control.passive_ramp_s = 0;
  return control;
}

}  // namespace

TEST_CASE("a torque that is no number is a fault that latches, and cuts the power") {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    Loop loop(without_ramp());
    loop.play(0.02F);
    loop.give(Order::Kind::arm);
    loop.tick(2);
    REQUIRE(loop.out.motor_command_nm == 0.02F);
    loop.play(bad);
    CHECK(loop.state() == State::fault);
    CHECK(loop.loop->snapshot().faults == protocol::fault::numeric);
    CHECK_FALSE(loop.out.enabled);
    CHECK(loop.out.motor_command_nm == 0.0F);
    loop.play(0.02F);
    loop.tick(5);
    CHECK(loop.state() == State::fault);
    static_cast<void>(loop.answer());
    loop.give(Order::Kind::arm);
    CHECK(loop.answer() == Status::fault_latched);
    loop.give(Order::Kind::clear_fault);
    CHECK(loop.answer() == Status::ok);
    CHECK(loop.state() == State::disarmed);
  }
}

TEST_CASE("an order that was refused before it came changes nothing and is answered") {
  Loop loop(without_ramp());
  Order order;
  order.kind = Order::Kind::arm;
  order.verdict = {Status::out_of_range, 3};
  order.acknowledged = false;
  loop.give(order);
  CHECK(loop.state() == State::disarmed);
  const device::Answer* const answer = loop.loop->mail.answers.front();
  REQUIRE(answer != nullptr);
  CHECK(answer->acknowledgement.status == static_cast<std::uint8_t>(Status::out_of_range));
  CHECK(answer->acknowledgement.field == 3);
  CHECK(loop.loop->snapshot().counters.reports_refused == 1);
  CHECK(loop.loop->snapshot().counters.reports_accepted == 0);
}

TEST_CASE("the longest tick is remembered, shorter ones are not") {
  Loop loop;
  for (const std::uint32_t ns : {1000U, 50'000U, 2000U, 960'000U, 3000U}) {
    loop.in.tick_time_ns = ns;
    loop.tick();
  }
  CHECK(loop.loop->snapshot().counters.tick_time_max_ns == 960'000U);
  CHECK(loop.loop->snapshot().counters.tick_time_ns == 3000U);
}

TEST_CASE("a fade that fault inputs interrupt ends at once") {
  protocol::ControlConfig control;
  control.passive_ramp_s = 0.1F;
  Loop loop(control);
  loop.play(0.05F);
  loop.give(Order::Kind::arm);
  loop.tick(120);
  loop.loop->set_connected(false);
  loop.tick(5);
  REQUIRE(loop.out.motor_command_nm > 0.0F);
  loop.in.actuator_fault = true;
  loop.tick();
  CHECK(loop.out.motor_command_nm == 0.0F);
  CHECK_FALSE(loop.out.enabled);
  CHECK(loop.state() == State::fault);
}

TEST_CASE("events tell why the torque fades, and then that it is gone") {
  Loop loop;
  loop.give(Order::Kind::arm);
  (void)loop.answer();
  loop.loop->set_connected(false);
  loop.tick();
  const device::Answer* answer = loop.loop->mail.answers.front();
  REQUIRE((answer != nullptr && answer->is_event));
  CHECK(answer->event.kind == EventKind::watchdog);
  CHECK(answer->event.state == State::armed);
  (void)loop.answer();
  loop.tick(60);
  answer = loop.loop->mail.answers.front();
  REQUIRE((answer != nullptr && answer->is_event));
  CHECK(answer->event.kind == EventKind::state_changed);
  CHECK(answer->event.state == State::disarmed);
}

TEST_CASE("the loss of the bus is heard in the next tick, also of a loop with nothing to decide") {
  Loop loop;
  loop.play(0.03F);
  loop.give(Order::Kind::arm);
  loop.tick(200);
  REQUIRE(loop.out.motor_command_nm == 0.03F);
  loop.loop->set_connected(false);
  loop.tick();
  CHECK(loop.out.motor_command_nm < 0.03F);
}

TEST_CASE("late ticks are counted anew after one that was later still") {
  Loop loop(without_ramp());
  loop.give(Order::Kind::arm);
  loop.in.tick_time_ns = 1'300'000;
  loop.tick();
  loop.in.tick_time_ns = 1000;
  loop.tick(20);
  loop.in.tick_time_ns = 1'100'000;  // of 1,000,000
  loop.tick(17);
  CHECK(loop.loop->snapshot().faults == protocol::fault::overrun);
}

TEST_CASE("any number of missed ticks is an overrun, beyond what 32 bits can weigh too") {
  for (const std::uint32_t missed : {16U, 1U << 30U, 0xFFFFFFFFU}) {
    Loop loop(without_ramp());
    loop.give(Order::Kind::arm);
    loop.in.missed_ticks = missed;
    loop.tick();
    CHECK(loop.loop->snapshot().faults == protocol::fault::overrun);
  }
}

TEST_CASE("accepted reports are counted") {
  Loop loop;
  loop.give(Order::Kind::keep_alive);
  loop.give(Order::Kind::arm);
  CHECK(loop.loop->snapshot().counters.reports_accepted == 2);
}

TEST_CASE("what a tick changes while it is read is read again") {
  // A tick that comes before, between and after the two words of a position, in the first round.
  for (int when = 0; when < 3; ++when) {
    CAPTURE(when);
    std::uint64_t ticks = 0xFFFF'FFFFU;
    std::uint32_t low = 0xFFFF'FFFFU;
    std::uint32_t high = 0xFFFF'FFFFU;
    int rounds = 0;
    const auto tick_comes_at = [&](int place) {
      if (rounds > 1 || place != when) return;
      ++ticks;
      low = 0;
      high = 0;
    };
    struct Taken {
      std::uint64_t tick;
      std::uint32_t low;
      std::uint32_t high;
    };
    const Taken taken = device::between_ticks(ticks, [&](std::uint64_t tick) {
      ++rounds;
      Taken now{tick, 0, 0};
      tick_comes_at(0);
      now.low = low;
      tick_comes_at(1);
      now.high = high;
      tick_comes_at(2);
      return now;
    });
    CHECK(rounds == 2);
    CHECK(taken.tick == 0x1'0000'0000U);
    CHECK(taken.low == 0);
    CHECK(taken.high == 0);
  }
}
