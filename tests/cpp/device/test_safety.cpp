// The promises of docs/reference/protocol.md and docs/explanation/architecture.md to the hand on
// the knob: caps, and faults that latch. Each of these lines was once deleted without any other
// test noticing; tests/mutation has the list.
#include <cmath>
#include <cstdint>

#include "device/played.hpp"

using namespace torsio::protocol;
using torsio::test::at_once;
using torsio::test::count;
using torsio::test::play;
using torsio::test::Rig;

TEST_CASE("the user's caps hold both torques, whichever way and whatever the law") {
  for (const Law law : {Law::paper, Law::compensated, Law::parallel, Law::motor_only}) {
    for (const float sign : {1.0F, -1.0F}) {
      Rig rig;
      ControlConfig config = at_once(law);
      config.motor_torque_cap_nm = 0.01F;
      config.brake_torque_cap_nm = 0.02F;
      REQUIRE(rig.set(config).ok());
      play(rig, sign * 0.085F);
      REQUIRE(rig.state() == State::armed);
      CHECK(rig.outputs.motor_command_nm == sign * 0.01F);
      CHECK(rig.outputs.brake_command_nm == (law == Law::motor_only ? 0.0F : 0.02F));
    }
  }
}

TEST_CASE("what the actuator can give holds both torques where the user's caps are wider") {
  for (const float sign : {1.0F, -1.0F}) {
    Rig rig;
    ActuatorConfig actuator;
    actuator.motor_torque_max_nm = 0.015F;
    actuator.brake_torque_max_nm = 0.025F;
    REQUIRE(rig.set(actuator).ok());
    REQUIRE(rig.set(at_once(Law::paper)).ok());
    play(rig, sign * 0.085F);
    CHECK(rig.outputs.motor_command_nm == sign * 0.015F);
    CHECK(rig.outputs.brake_command_nm == 0.025F);
  }
}

TEST_CASE("the brake that is held on the way to passive stays within its caps") {
  for (const bool of_user : {true, false}) {
    Rig rig;
    ActuatorConfig actuator;
    ControlConfig config;
    config.passive_ramp_s = 0.02F;
    config.passive_brake_nm = 0.1F;
    if (of_user) config.brake_torque_cap_nm = 0.03F;
    if (!of_user) actuator.brake_torque_max_nm = 0.03F;
    REQUIRE(rig.set(actuator).ok());
    REQUIRE(rig.set(config).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.device->set_connected(false);
    rig.tick();
    REQUIRE(rig.outputs.enabled);
    CHECK(rig.outputs.brake_command_nm == 0.03F);
  }
}

TEST_CASE("the motor's rate holds both ways, also from where a fault has left it") {
  Rig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.motor_slew_nm_per_s = 10.0F;  // 0.01 in a tick of 1 ms
  REQUIRE(rig.set(config).ok());
  for (const float goal : {0.05F, -0.05F}) {
    float last = rig.outputs.motor_command_nm;
    Constant constant;
    constant.torque_nm = goal;
    REQUIRE(rig.send_status(constant) == Status::ok);
    REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
    if (rig.state() != State::armed) {
      REQUIRE(rig.device->receive(encode(Command{1, 0, Op::arm})));
    }
    for (int i = 0; i < 15; ++i) {
      rig.tick();
      // The commit's own ticks came before.
      if (i > 0) CHECK(std::abs(rig.outputs.motor_command_nm - last) < 0.010001F);
      last = rig.outputs.motor_command_nm;
    }
    CHECK(last == goal);
  }
  rig.inputs.emergency_stop = true;
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.inputs.emergency_stop = false;
  rig.tick(2);
  REQUIRE(rig.command(Op::clear_fault) == Status::ok);
  REQUIRE(rig.device->receive(encode(Command{1, 0, Op::arm})));
  rig.tick();
  CHECK(std::abs(rig.outputs.motor_command_nm) < 0.010001F);  // it begins at zero
}

TEST_CASE("turning too fast is a fault either way") {
  for (const int counts : {40, -40}) {  // 30.7 rad/s in a tick
    Rig rig;
    ControlConfig config;
    config.speed_limit_rad_s = 20.0F;
    REQUIRE(rig.set(config).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    for (int i = 0; i < 50; ++i) {
      rig.inputs.encoder_count += static_cast<std::uint32_t>(counts);
      rig.tick();
    }
    CHECK(rig.get<Health>().faults == fault::over_speed);
    CHECK_FALSE(rig.outputs.enabled);
  }
}

TEST_CASE("turning fast is no fault without a limit, and none below it") {
  for (const float limit_rad_s : {0.0F, 40.0F}) {
    Rig rig;
    ControlConfig config;
    config.speed_limit_rad_s = limit_rad_s;
    REQUIRE(rig.set(config).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    for (int i = 0; i < 50; ++i) {
      rig.inputs.encoder_count += 40;  // 30.7 rad/s
      rig.tick();
    }
    CHECK(rig.state() == State::armed);
  }
}

TEST_CASE("turning fast with nobody armed is no fault") {
  Rig rig;
  ControlConfig config;
  config.speed_limit_rad_s = 20.0F;
  REQUIRE(rig.set(config).ok());
  for (int i = 0; i < 50; ++i) {
    rig.inputs.encoder_count += 40;
    rig.tick();
  }
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("a jump of more than a quarter of a turn is a fault either way, a quarter is none") {
  for (const int sign : {1, -1}) {
    for (const int counts : {2048, 2049}) {
      Rig rig;
      rig.tick();
      rig.inputs.encoder_count += static_cast<std::uint32_t>(sign * counts);
      rig.tick();
      CHECK(rig.get<Health>().faults == (counts > 2048 ? fault::encoder : 0));
    }
  }
}

TEST_CASE("a device says whether a periodic effect plays: only then may the knob tremble so fast") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::paper)).ok());
  CHECK_FALSE(rig.device->shakes());
  play(rig, 0.01F);
  CHECK_FALSE(rig.device->shakes());
  Periodic shaking;
  shaking.target.slot = 1;
  shaking.frequency_hz = 400.0F;
  shaking.amplitude_nm = 0.01F;
  REQUIRE(rig.send_status(shaking) == Status::ok);
  REQUIRE(rig.send_status(Commit{2, 0, 3}) == Status::ok);
  CHECK(rig.device->shakes());
  REQUIRE(rig.send_status(Commit{3, 0, 1}) == Status::ok);
  CHECK_FALSE(rig.device->shakes());
  REQUIRE(rig.send_status(Commit{4, 0, 2}) == Status::ok);
  CHECK(rig.device->shakes());
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  CHECK_FALSE(rig.device->shakes());
}

TEST_CASE("a fault is added to those that are latched, and all are told until they are cleared") {
  Rig rig;
  rig.inputs.emergency_stop = true;
  rig.tick();
  rig.inputs.emergency_stop = false;
  rig.inputs.actuator_fault = true;
  rig.tick();
  rig.inputs.actuator_fault = false;
  rig.tick(3);
  CHECK(rig.get<Health>().faults == (fault::emergency_stop | fault::actuator));
  CHECK(rig.events.back().faults == (fault::emergency_stop | fault::actuator));
  CHECK(rig.events.back().state == State::fault);
  CHECK(rig.command(Op::clear_fault) == Status::ok);
  CHECK(rig.get<Health>().faults == 0);
}

TEST_CASE("a fault that lasts is told once, not in every tick") {
  Rig rig;
  rig.inputs.emergency_stop = true;
  rig.tick(50);
  CHECK(count(rig, EventKind::state_changed) == 1);
}

TEST_CASE("clearing what is no fault leaves an armed device as it is") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only)).ok());
  play(rig, 0.02F);
  CHECK(rig.command(Op::clear_fault) == Status::ok);
  CHECK(rig.state() == State::armed);
  CHECK(rig.outputs.motor_command_nm == 0.02F);
}
