// How a torque begins and ends: fades, deadlines, the watchdog, and who may begin something when.
// Each of these lines was once deleted without any other test noticing; tests/mutation has the
// list.
#include <cstdint>

#include "device/game/game_rig.hpp"
#include "device/played.hpp"

using namespace torsio::protocol;
using torsio::test::at_once;
using torsio::test::GameRig;
using torsio::test::play;
using torsio::test::Rig;

TEST_CASE("nobody arms while the torque fades, and the fade goes on") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only, 0.1F)).ok());
  play(rig, 0.05F);
  rig.tick(120);
  const float held = rig.outputs.motor_command_nm;
  REQUIRE(held == 0.05F);
  rig.device->set_connected(false);
  rig.tick(10);
  rig.device->set_connected(true);
  CHECK(rig.command(Op::arm) == Status::busy);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm < held);
  CHECK(rig.outputs.motor_command_nm > 0.0F);
  rig.tick(90);
  CHECK(rig.state() == State::disarmed);
  CHECK(rig.command(Op::arm) == Status::ok);
}

TEST_CASE("the motor fades along a line to zero in the configured time, either way") {
  for (const float sign : {1.0F, -1.0F}) {
    Rig rig;
    REQUIRE(rig.set(at_once(Law::motor_only, 0.1F)).ok());
    play(rig, sign * 0.05F);
    rig.tick(120);
    rig.device->set_connected(false);
    for (int tick = 1; tick <= 100; ++tick) {
      rig.tick();
      const double expected = static_cast<double>(sign) * 0.05 * (1.0 - tick / 100.0);
      CHECK(rig.outputs.motor_command_nm == doctest::Approx(expected).scale(0.05).epsilon(1e-4));
      CHECK(rig.outputs.enabled);
    }
    rig.tick(2);
    CHECK_FALSE(rig.outputs.enabled);
    CHECK(rig.state() == State::disarmed);
  }
}

TEST_CASE("a local model is refused while the torque fades, and does not bring it back") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only, 0.1F)).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(110);
  rig.device->set_connected(false);
  rig.tick(2);
  rig.device->set_connected(true);
  LocalModel model;
  model.torque_nm = 0.05F;
  model.deadline_s = 1.0F;
  CHECK(rig.send_status(model) == Status::not_armed);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("a local model does not survive being disarmed, however that came") {
  const auto disarm = [](Rig& rig, int way) {
    if (way == 0) CHECK(rig.command(Op::disarm) == Status::ok);
    if (way == 1) CHECK(rig.command(Op::stop) == Status::ok);
    if (way == 2) rig.device->set_connected(false);
    if (way == 3) rig.inputs.emergency_stop = true;
    rig.tick(5);
    rig.device->set_connected(true);
    rig.inputs.emergency_stop = false;
    rig.tick(2);
    if (way == 3) REQUIRE(rig.command(Op::clear_fault) == Status::ok);
    REQUIRE(rig.state() == State::disarmed);
  };
  for (int way = 0; way < 4; ++way) {
    CAPTURE(way);
    Rig rig;
    REQUIRE(rig.set(at_once(Law::motor_only)).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    LocalModel model;
    model.sequence = 5;
    model.torque_nm = 0.05F;
    model.deadline_s = 10.0F;
    REQUIRE(rig.device->receive(encode(model)));
    rig.tick(2);
    REQUIRE(rig.outputs.motor_command_nm == 0.05F);
    disarm(rig, way);
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.tick(5);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
    CHECK((rig.get<Health>().state) == State::armed);
    // And a new stream may begin with any number.
    model.sequence = 1;
    REQUIRE(rig.device->receive(encode(model)));
    rig.tick(2);
    CHECK(rig.outputs.motor_command_nm == 0.05F);
  }
}

TEST_CASE("each local model sets the deadline anew, and the last one counts") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only)).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  LocalModel model;
  model.torque_nm = 0.02F;
  model.deadline_s = 0.02F;
  for (std::uint16_t i = 1; i <= 5; ++i) {
    model.sequence = i;
    REQUIRE(rig.device->receive(encode(model)));
    rig.tick(15);
    CHECK(rig.state() == State::armed);
  }
  rig.tick(8);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("an encoder of another resolution empties the scene, the same one keeps it") {
  for (const std::uint32_t counts_per_rev : {8192U, 4096U}) {
    Rig rig;
    REQUIRE(rig.set(at_once(Law::motor_only)).ok());
    play(rig, 0.03F);
    REQUIRE(rig.command(Op::disarm) == Status::ok);
    ActuatorConfig actuator;
    actuator.counts_per_rev = counts_per_rev;
    actuator.knob_coulomb_nm = 0.005F;
    REQUIRE(rig.set(actuator).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.tick(5);
    const bool kept = counts_per_rev == 8192;
    CHECK(rig.outputs.motor_command_nm == (kept ? 0.03F : 0.0F));
    // Nor are the effects there any more that a commit could bring back.
    CHECK(rig.send_status(Commit{2, 0, 1}) == (kept ? Status::ok : Status::empty_slot));
  }
}

TEST_CASE("a scene begins softly each time that the device is armed") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only, 0.05F)).ok());
  play(rig, 0.05F);
  rig.tick(60);
  REQUIRE(rig.outputs.motor_command_nm == 0.05F);
  for (int again = 0; again < 2; ++again) {
    REQUIRE(rig.command(Op::disarm) == Status::ok);
    rig.tick(3);
    REQUIRE(rig.device->receive(encode(Command{4, 0, Op::arm})));
    float last = 0.0F;
    for (int tick = 1; tick <= 52; ++tick) {
      rig.tick();
      CHECK(rig.outputs.motor_command_nm - last < 1.01F * 0.05F / 50);
      CHECK(rig.outputs.motor_command_nm >= last);
      last = rig.outputs.motor_command_nm;
    }
    CHECK(last == 0.05F);
  }
}

TEST_CASE("arming what is armed is no new beginning") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only, 0.05F)).ok());
  play(rig, 0.05F);
  rig.tick(60);
  rig.events.clear();
  CHECK(rig.command(Op::arm) == Status::ok);
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == 0.05F);
  CHECK(rig.events.empty());
}

TEST_CASE("disarming what is disarmed, or has a fault, changes nothing") {
  Rig rig;
  CHECK(rig.command(Op::disarm) == Status::ok);
  CHECK(rig.events.empty());
  rig.inputs.emergency_stop = true;
  rig.tick(2);
  CHECK(rig.command(Op::disarm) == Status::ok);
  CHECK(rig.command(Op::stop) == Status::ok);
  CHECK(rig.state() == State::fault);
  CHECK(rig.get<Health>().faults == fault::emergency_stop);
}

TEST_CASE("any accepted report is a sign of life, a refused one is none") {
  for (const bool good : {true, false}) {
    Rig rig;
    ControlConfig config = at_once(Law::motor_only);
    config.watchdog_s = 0.05F;
    REQUIRE(rig.set(config).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    for (int i = 0; i < 10; ++i) {
      Constant constant;
      constant.target.axis = good ? 0 : 1;
      REQUIRE(rig.device->receive(encode(constant)));
      rig.tick(40);
    }
    CHECK((rig.state() == State::armed) == good);
  }
}

TEST_CASE("the watchdog bites in the tick after its time, not before and not much later") {
  Rig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.watchdog_s = 0.05F;
  REQUIRE(rig.set(config).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  int ticks = 0;
  while (rig.state() == State::armed) {
    rig.tick();
    REQUIRE(++ticks < 100);
  }
  CHECK(ticks >= 50);
  CHECK(ticks <= 53);
}

TEST_CASE("a host that is late by a fault's length finds the device as it left it") {
  // Silence while nobody is armed is nothing, however long.
  Rig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.watchdog_s = 0.01F;
  REQUIRE(rig.set(config).ok());
  rig.tick(1000);
  CHECK(rig.command(Op::arm) == Status::ok);
  rig.tick(5);
  CHECK(rig.state() == State::armed);
}

TEST_CASE("time that ticks have missed counts for nobody's deadline twice") {
  Rig rig;
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.inputs.missed_ticks = 3;
  rig.tick();
  rig.inputs.missed_ticks = 0;
  rig.tick();
  CHECK(rig.get<Health>().tick_overruns == 3);
  CHECK(rig.state() == State::armed);
}

TEST_CASE("an autonomous device says so by playing on; a game on it still needs a bus") {
  GameRig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.autonomous = Toggle::on;
  REQUIRE(rig.set(config).ok());
  rig.play_constant(32767);
  rig.tick(5);
  REQUIRE(rig.owner() == Owner::game);
  rig.device->set_connected(false);
  rig.tick(60);
  CHECK(rig.state() == State::disarmed);
}
