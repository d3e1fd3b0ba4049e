// States, faults, watchdog and deadlines.
#include <cmath>
#include <initializer_list>

#include "device/played.hpp"

using namespace torsio::protocol;
using doctest::Approx;
using torsio::test::arm_at_once;
using torsio::test::Rig;

TEST_CASE("a device boots disarmed and gives no torque before it is armed") {
  Rig rig;
  Constant constant;
  constant.torque_nm = 0.02F;
  CHECK(rig.send_status(constant) == Status::ok);
  CHECK(rig.send_status(Commit{2, 0, 1}) == Status::ok);
  rig.tick(100);
  CHECK(rig.state() == State::disarmed);
  CHECK_FALSE(rig.outputs.enabled);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  CHECK(rig.outputs.brake_command_nm == 0.0F);
}

TEST_CASE("arming starts softly: no step in torque") {
  Rig rig;
  ControlConfig config;
  config.passive_ramp_s = 0.05F;
  config.law = Law::motor_only;
  REQUIRE(rig.set(config).ok());
  Constant constant;
  constant.torque_nm = 0.05F;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(Commit{2, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  float last = rig.outputs.motor_command_nm;
  for (int i = 0; i < 60; ++i) {
    rig.tick();
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.001F * 0.05F / 50);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(last == 0.05F);
}

TEST_CASE("disarm and stop let go along a line of 4 ms; stop forgets the scene") {
  for (const Op op : {Op::disarm, Op::stop}) {
    for (const std::uint32_t period_ns : {1'000'000U, 100'000U}) {
      torsio::device::BoardInfo board;
      board.control_period_ns = period_ns;
      Rig rig(board);
      rig.arm_with_constant(0.03F);
      const int soft_start = static_cast<int>(25'000'000 / period_ns);
      rig.tick(soft_start);
      REQUIRE(rig.send_status(Stream{1, 0, 1}) == Status::ok);
      const float held = rig.outputs.motor_command_nm;
      REQUIRE(held != 0.0F);
      const std::size_t answered = rig.acknowledgements.size();
      REQUIRE(rig.device->receive(encode(Command{7, 0, op})));
      const int ticks = static_cast<int>(4'000'000 / period_ns);
      for (int i = 1; i <= ticks; ++i) {
        rig.tick();
        const double left = held * (1.0 - static_cast<double>(i) / ticks);
        CHECK(rig.outputs.motor_command_nm == Approx(left).scale(0.03).epsilon(1e-5));
        CHECK(rig.outputs.brake_command_nm == 0.0F);
        CHECK(rig.outputs.enabled);
        CHECK(rig.acknowledgements.size() == answered);
      }
      rig.tick();
      CHECK_FALSE(rig.outputs.enabled);
      CHECK(rig.outputs.motor_command_nm == 0.0F);
      rig.tick();
      REQUIRE(rig.acknowledgements.size() == answered + 1);
      CHECK(rig.acknowledgements.back().state == State::disarmed);
      // Only silence and deadlines fade out, so only they say so.
      for (const Telemetry& report : rig.telemetry) {
        CHECK((report.flags & torsio::protocol::flag::passive) == 0);
      }
      CHECK(rig.command(Op::arm) == Status::ok);
      rig.tick(soft_start);
      if (op == Op::stop) {
        CHECK(rig.outputs.motor_command_nm == 0.0F);
        CHECK(rig.send_status(Commit{3, 0, 1}) == Status::empty_slot);
      } else {
        CHECK(rig.outputs.motor_command_nm == held);
      }
    }
  }
}

TEST_CASE("whoever has no soft start wants no soft end either") {
  Rig rig;
  rig.arm_with_constant(0.03F);
  REQUIRE(rig.command(Op::stop) == Status::ok);
  ControlConfig config;
  config.passive_ramp_s = 0;
  REQUIRE(rig.set(config).ok());
  Constant constant;
  constant.torque_nm = 0.03F;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(Commit{2, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  REQUIRE(rig.outputs.motor_command_nm != 0.0F);
  REQUIRE(rig.device->receive(encode(Command{7, 0, Op::disarm})));
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  CHECK_FALSE(rig.outputs.enabled);
}

TEST_CASE("a fault cuts at once what is being let go of") {
  Rig rig;
  rig.arm_with_constant(0.03F);
  REQUIRE(rig.device->receive(encode(Command{7, 0, Op::disarm})));
  rig.tick(2);
  REQUIRE(rig.outputs.enabled);
  REQUIRE(rig.outputs.motor_command_nm != 0.0F);
  rig.inputs.emergency_stop = true;
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  CHECK_FALSE(rig.outputs.enabled);
  CHECK(rig.state() == State::fault);
  rig.tick();
  CHECK(rig.acknowledgements.back().sequence == 7);
  CHECK(rig.acknowledgements.back().state == State::fault);
}

TEST_CASE("disarming shortens the fade of a host that was silent, and releases the brake") {
  Rig rig;
  ControlConfig config;
  config.passive_ramp_s = 0.02F;
  config.watchdog_s = 0.1F;
  config.passive_brake_nm = 0.01F;
  REQUIRE(rig.set(config).ok());
  Constant constant;
  constant.torque_nm = 0.03F;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(105);  // the watchdog has bitten: 20 ms to go
  REQUIRE(rig.outputs.brake_command_nm == 0.01F);
  const float held = rig.outputs.motor_command_nm;
  REQUIRE(held != 0.0F);
  REQUIRE(rig.device->receive(encode(Command{7, 0, Op::disarm})));
  rig.tick();
  CHECK(rig.outputs.brake_command_nm == 0.0F);
  rig.tick(3);
  CHECK(rig.outputs.motor_command_nm == Approx(0.0).scale(1e-3));
  rig.tick();
  CHECK_FALSE(rig.outputs.enabled);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("silence of the host makes the motor ramp down, then disarms") {
  Rig rig;
  rig.arm_with_constant(0.03F);  // watchdog 0.1 s, ramp 0.02 s
  const float held = rig.outputs.motor_command_nm;
  REQUIRE(rig.send_status(Stream{1, 0, 0}) == Status::ok);  // the last sign of life
  rig.tick(100);
  CHECK(rig.outputs.motor_command_nm == held);
  rig.events.clear();
  rig.tick(3);
  REQUIRE(rig.events.size() == 1);
  CHECK(rig.events[0].kind == EventKind::watchdog);
  float last = held;
  int ticks = 0;
  while (rig.outputs.enabled) {
    CHECK(rig.outputs.motor_command_nm <= last);
    CHECK(last - rig.outputs.motor_command_nm <= 3.01F * held / 20);
    last = rig.outputs.motor_command_nm;
    rig.tick();
    REQUIRE(++ticks < 30);
  }
  CHECK(last == Approx(0.0).scale(1e-3));
  CHECK(rig.state() == State::disarmed);
  CHECK(rig.events.back().state == State::disarmed);
}

TEST_CASE("keep_alive feeds the watchdog and is not acknowledged; garbage does not feed it") {
  Rig rig;
  rig.arm_with_constant(0.03F);
  const std::size_t acknowledged = rig.acknowledgements.size();
  for (int i = 0; i < 10; ++i) {
    REQUIRE(rig.device->receive(encode(Command{9, 0, Op::keep_alive})));
    rig.tick(80);
  }
  CHECK(rig.state() == State::armed);
  CHECK(rig.acknowledgements.size() == acknowledged);
  for (int i = 0; i < 10 && rig.state() == State::armed; ++i) {
    ReportBytes garbage{};
    garbage[0] = 0x77;
    REQUIRE(rig.device->receive(garbage));
    rig.tick(80);
  }
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("an autonomous device plays on without a host or a bus") {
  Rig rig;
  ControlConfig config;
  config.autonomous = Toggle::on;
  config.watchdog_s = 0.05F;
  REQUIRE(rig.set(config).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.device->set_connected(false);
  rig.tick(1000);
  CHECK(rig.state() == State::armed);
}

TEST_CASE("losing the bus fails passive at once, with the brake as configured") {
  Rig rig;
  ControlConfig config;
  config.passive_brake_nm = 0.04F;
  config.passive_ramp_s = 0.02F;
  REQUIRE(rig.set(config).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  REQUIRE(rig.send_status(Stream{1, 0, 1}) == Status::ok);
  rig.device->set_connected(false);
  rig.tick();
  CHECK(rig.outputs.enabled);
  CHECK(rig.outputs.brake_command_nm == 0.04F);
  rig.tick(20);
  // The sensor's brake model follows the real commands.
  const float step = rig.get<Identity>().torque_step_nm;
  CHECK(rig.telemetry.back().sample[0].brake_capacity * step > 0.005F);
  rig.tick(5);
  CHECK(rig.state() == State::disarmed);
  CHECK(rig.outputs.brake_command_nm == 0.0F);
}

TEST_CASE("faults cut the torque in the same tick, latch, and clear only without their cause") {
  Rig rig;
  rig.arm_with_constant(0.03F);
  rig.inputs.emergency_stop = true;
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  CHECK_FALSE(rig.outputs.enabled);
  CHECK(rig.command(Op::arm) == Status::fault_latched);
  CHECK(rig.command(Op::clear_fault) == Status::fault_persists);
  rig.inputs.emergency_stop = false;
  rig.tick(2);
  CHECK(rig.state() == State::fault);
  CHECK(rig.get<Health>().faults == fault::emergency_stop);
  CHECK(rig.command(Op::clear_fault) == Status::ok);
  CHECK(rig.state() == State::disarmed);
  CHECK(rig.get<Health>().faults == 0);
  CHECK(rig.command(Op::arm) == Status::ok);
}

TEST_CASE("each cause sets its bit") {
  {
    Rig rig;
    rig.inputs.actuator_fault = true;
    rig.tick();
    CHECK(rig.get<Health>().faults == fault::actuator);
  }
  {
    Rig rig;
    rig.tick();
    rig.inputs.encoder_count += 3000;  // more than a quarter of a turn in a tick
    rig.tick();
    CHECK(rig.get<Health>().faults == fault::encoder);
  }
  {
    Rig rig;
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.inputs.missed_ticks = 20;
    rig.tick();
    CHECK(rig.get<Health>().faults == fault::overrun);
    CHECK(rig.get<Health>().tick_overruns == 20);
  }
  {
    Rig rig;
    ControlConfig config;
    config.speed_limit_rad_s = 20.0F;
    REQUIRE(rig.set(config).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    for (int i = 0; i < 50; ++i) {
      rig.inputs.encoder_count += 40;  // 30.7 rad/s
      rig.tick();
    }
    CHECK(rig.get<Health>().faults == fault::over_speed);
  }
}

TEST_CASE("missed ticks count as time") {
  Rig rig;
  rig.tick(10);
  rig.inputs.missed_ticks = 5;
  rig.tick();
  CHECK(rig.get<Clock>().tick == 16);
  CHECK(rig.get<Clock>().time_ns == 16'000'000);
}

TEST_CASE("on its way to the bootloader nobody can arm any more") {
  torsio::device::BoardInfo board;
  board.has_bootloader = true;
  Rig rig(board);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  CHECK(rig.command(Op::bootloader) == Status::not_disarmed);
  CHECK_FALSE(rig.device->take_bootloader_request());
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);  // a refused one leaves nothing behind
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  REQUIRE(rig.command(Op::bootloader) == Status::ok);
  CHECK(rig.command(Op::arm) == Status::busy);
  CHECK(rig.device->take_bootloader_request());
  REQUIRE(rig.device->receive(encode(Command{3, 0, Op::save})));
  rig.tick(2);
  REQUIRE(rig.device->take_slot_write());
  rig.device->storage_written();
  rig.tick(2);
  CHECK(rig.command(Op::arm) == Status::busy);
  CHECK(rig.state() == State::disarmed);
}

namespace {

/// Ticks until the device gives up, or 0. Every `every`th tick has `inputs`.
int ticks_to_overrun(std::uint32_t missed_ticks, std::uint32_t tick_time_ns, int every,
                     std::uint32_t step_time_ns = 0) {
  torsio::device::BoardInfo board;
  board.control_period_ns = 100'000;
  Rig rig(board);
  ControlConfig config;
  config.watchdog_s = 1.0F;
  REQUIRE(rig.set(config).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  for (int tick = 1; tick <= 2000; ++tick) {
    const bool late = tick % every == 0;
    rig.inputs.missed_ticks = late ? missed_ticks : 0;
    rig.inputs.tick_time_ns = late ? tick_time_ns : 20'000;
    rig.inputs.step_time_ns = step_time_ns;
    rig.tick();
    if (rig.state() != State::armed) {
      CHECK(rig.get<Health>().faults == fault::overrun);
      CHECK_FALSE(rig.outputs.enabled);
      return tick;
    }
  }
  return 0;
}

}  // namespace

TEST_CASE("a load that does not fit is a fault, jitter is none") {
  // A period of 100 us; 95 us may be used.
  CHECK(ticks_to_overrun(0, 95'000, 1) == 0);
  CHECK(ticks_to_overrun(0, 95'001, 1) == 16);
  CHECK(ticks_to_overrun(1, 130'000, 1) == 16);
  CHECK(ticks_to_overrun(2, 0, 1) == 8);
  CHECK(ticks_to_overrun(15, 0, 1000) == 0);
  CHECK(ticks_to_overrun(16, 0, 1000) == 1000);
  CHECK(ticks_to_overrun(1, 130'000, 5) == 0);
  const int every_fourth = ticks_to_overrun(1, 130'000, 4);
  CHECK(every_fourth > 200);
  CHECK(every_fourth < 300);
}

TEST_CASE("what the interrupt does between two ticks is lost to the main loop as well") {
  CHECK(ticks_to_overrun(0, 85'000, 1, 10'000) == 0);
  CHECK(ticks_to_overrun(0, 85'001, 1, 10'000) == 16);
  CHECK(ticks_to_overrun(0, 85'001, 4, 10'000) > 200);
  CHECK(ticks_to_overrun(0, 1, 1, 95'001) == 16);
}

TEST_CASE("what was late before arming is no fault, and an overrun can be cleared") {
  Rig rig;
  rig.inputs.missed_ticks = 100;
  rig.tick();
  rig.inputs.missed_ticks = 0;
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.inputs.missed_ticks = 15;
  rig.tick();
  CHECK(rig.state() == State::armed);
  rig.tick();
  CHECK(rig.get<Health>().faults == fault::overrun);
  rig.inputs.missed_ticks = 0;
  rig.tick();
  CHECK(rig.command(Op::clear_fault) == Status::ok);
  CHECK(rig.command(Op::arm) == Status::ok);
  rig.tick(10);
  CHECK(rig.state() == State::armed);
}

TEST_CASE("a local model holds until its deadline, then the device fails passive") {
  Rig rig;
  arm_at_once(rig);
  LocalModel model;
  model.sequence = 1;
  model.torque_nm = 0.02F;
  model.stiffness_nm_per_rad = 1.0F;
  model.deadline_s = 0.02F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == Approx(0.02));
  rig.inputs.encoder_count += 10;
  rig.tick();
  CHECK(rig.outputs.motor_command_nm ==
        Approx(0.02 - 10 * 2.0 * M_PI / 8192).scale(0).epsilon(1e-4));
  rig.tick(18);
  CHECK(rig.state() == State::armed);
  rig.tick(2);
  CHECK(rig.state() == State::disarmed);
  bool missed = false;
  for (const Event& event : rig.events) missed |= event.kind == EventKind::deadline_missed;
  CHECK(missed);
}

TEST_CASE("local models: newest wins, stale ones are refused, a zero deadline ends the stream") {
  Rig rig;
  ControlConfig config;
  config.law = Law::motor_only;
  config.passive_ramp_s = 0.0F;
  REQUIRE(rig.set(config).ok());
  LocalModel model;
  model.sequence = 0xFFFF;
  model.torque_nm = 0.01F;
  CHECK(rig.send_status(model) == Status::not_armed);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick();
  CHECK(rig.send_status(model) == Status::stale);
  model.sequence = 0;  // newer than 0xFFFF
  model.torque_nm = 0.03F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == Approx(0.03));
  model.sequence = 1;
  model.deadline_s = 0.0F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick(100);
  CHECK(rig.state() == State::armed);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}
