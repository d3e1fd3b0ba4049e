// What docs/protocol.md and docs/architecture.md promise to whoever holds the knob: caps, latches,
// fades, and who may begin something when. Each of these lines was once deleted without any other
// test noticing; tests/mutation has the list.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>

#include "device/game/game_rig.hpp"

using namespace torsio::protocol;
using torsio::test::GameRig;
using torsio::test::Rig;

namespace {

/// Arms with a constant torque and without a soft start.
void play(Rig& rig, float torque_nm, std::uint8_t slot = 0) {
  Constant constant;
  constant.target.slot = slot;
  constant.torque_nm = torque_nm;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(Commit{1, 0, static_cast<std::uint16_t>(1U << slot)}) == Status::ok);
  if (rig.state() != State::armed) REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(3);
}

ControlConfig at_once(Law law) {
  ControlConfig config;
  config.law = law;
  config.passive_ramp_s = 0.0F;
  config.watchdog_s = 60.0F;
  return config;
}

std::size_t count(const Rig& rig, EventKind kind) {
  return static_cast<std::size_t>(
      std::ranges::count_if(rig.events, [&](const Event& event) { return event.kind == kind; }));
}

}  // namespace

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

TEST_CASE("nobody arms while the torque fades, and the fade goes on") {
  Rig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.passive_ramp_s = 0.1F;
  REQUIRE(rig.set(config).ok());
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
    ControlConfig config = at_once(Law::motor_only);
    config.passive_ramp_s = 0.1F;
    REQUIRE(rig.set(config).ok());
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
  ControlConfig config = at_once(Law::motor_only);
  config.passive_ramp_s = 0.1F;
  REQUIRE(rig.set(config).ok());
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
  ControlConfig config = at_once(Law::motor_only);
  config.passive_ramp_s = 0.05F;
  REQUIRE(rig.set(config).ok());
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
  ControlConfig config = at_once(Law::motor_only);
  config.passive_ramp_s = 0.05F;
  REQUIRE(rig.set(config).ok());
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

TEST_CASE("a game cannot begin while the bus is away, nor while the torque fades") {
  GameRig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.passive_ramp_s = 0.1F;
  REQUIRE(rig.set(config).ok());
  rig.device->set_connected(false);
  rig.tick(2);
  const int block = rig.play_constant(32767);
  rig.tick(5);
  CHECK(rig.state() == State::disarmed);
  rig.device->set_connected(true);
  rig.start(block);
  rig.tick(5);
  REQUIRE(rig.owner() == Owner::game);
  const float held = rig.outputs.motor_command_nm;
  rig.device->set_connected(false);
  rig.tick(3);
  rig.device->set_connected(true);
  rig.start(block);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm < held);
  rig.tick(90);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("a game that plays does not hear the scene of the SDK") {
  GameRig rig;
  Constant scene;
  scene.torque_nm = -0.06F;
  REQUIRE(rig.send_status(scene) == Status::ok);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  rig.play_constant(16384);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == torsio::test::about(0.04, 1e-3));
}

TEST_CASE("what a game is given follows its configuration at once") {
  GameRig rig;
  rig.configure([](GameConfig& config) { config.torque_max_nm = 0.02F; });
  const int block = rig.play_constant(32767);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == torsio::test::about(0.02));
  rig.stop(block);
  rig.tick(10);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  rig.configure([](GameConfig& config) { config.torque_max_nm = 0.05F; });
  rig.start(block);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == torsio::test::about(0.05));
}

TEST_CASE("all effects of a game together stay within its cap, either way") {
  for (const int sign : {1, -1}) {
    GameRig rig;
    rig.configure([](GameConfig& config) { config.torque_max_nm = 0.03F; });
    for (int i = 0; i < 5; ++i) rig.play_constant(sign * 32767);
    for (int tick = 0; tick < 20; ++tick) {
      rig.tick();
      CHECK(std::abs(rig.outputs.motor_command_nm) <= 0.03F * 1.00001F);
    }
    CHECK(rig.outputs.motor_command_nm == torsio::test::about(sign * 0.03));
  }
}

TEST_CASE("the user's cap holds a game as it holds a scene") {
  GameRig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.motor_torque_cap_nm = 0.01F;
  REQUIRE(rig.set(config).ok());
  rig.play_constant(32767);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == torsio::test::about(0.01));
  // Half of full level is half of what can be given.
  GameRig half;
  REQUIRE(half.set(config).ok());
  half.play_constant(16384);
  half.tick(10);
  CHECK(half.outputs.motor_command_nm == torsio::test::about(0.005));
}

TEST_CASE(
    "a soft start ends at the full torque, of a local model too, and never has an old one in it") {
  Rig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.passive_ramp_s = 0.05F;
  REQUIRE(rig.set(config).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  LocalModel model;
  model.sequence = 1;
  model.torque_nm = 0.05F;
  model.deadline_s = 10.0F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick(60);
  CHECK(rig.outputs.motor_command_nm == 0.05F);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  for (int i = 0; i < 60; ++i) {
    rig.tick();
    CHECK(rig.outputs.motor_command_nm == 0.0F);
  }
}

TEST_CASE("a refused commit does not touch what plays, whatever was written before it") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only)).ok());
  play(rig, 0.03F);
  Constant other;
  other.torque_nm = 0.01F;
  REQUIRE(rig.send_status(other) == Status::ok);
  CHECK(rig.send_status(Commit{2, 0, 0x8001}) == Status::empty_slot);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == 0.03F);
  CHECK(rig.send_status(Commit{3, 0, 1}) == Status::ok);
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == 0.01F);
}

TEST_CASE("a deadline shorter than a tick is still one") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only)).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  LocalModel model;
  model.sequence = 1;
  model.deadline_s = 1e-4F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick(5);
  CHECK(count(rig, EventKind::deadline_missed) == 1);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("a duration shorter than a tick is not without end") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only)).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  Constant constant;
  constant.torque_nm = 0.03F;
  constant.timing.duration_s = 1e-4F;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("every order is answered once and in order, however seldom the interrupt comes") {
  Rig rig;
  for (std::uint16_t i = 1; i <= 6; ++i) {
    REQUIRE(rig.device->receive(encode(Command{i, 0, Op::disarm})));
    for (int round = 0; round < 5; ++round) rig.device->service();
  }
  rig.tick(20);
  REQUIRE(rig.acknowledgements.size() == 6);
  for (std::uint16_t i = 1; i <= 6; ++i) CHECK(rig.acknowledgements[i - 1U].sequence == i);
}

TEST_CASE("what comes behind a save waits for it") {
  Rig rig;
  REQUIRE(rig.device->receive(encode(Command{1, 0, Op::save})));
  REQUIRE(rig.device->receive(encode(Command{2, 0, Op::arm})));
  rig.tick(20);
  CHECK(rig.acknowledgements.empty());
  REQUIRE(rig.device->take_slot_write());
  rig.device->storage_written();
  rig.tick(5);
  REQUIRE(rig.acknowledgements.size() == 2);
  CHECK(rig.acknowledgements[0].sequence == 1);
  CHECK(rig.status(rig.acknowledgements[1]) == Status::ok);
  CHECK(rig.state() == State::armed);
}

TEST_CASE("a setting that finds no room is refused as busy, and counted") {
  Rig rig;
  while (rig.device->receive(encode(Command{1, 0, Op::keep_alive}))) {
  }
  const std::uint32_t before = rig.get<Health>().reports_refused;
  CHECK(rig.device->set_feature(encode(ControlConfig{})).status == Status::busy);
  CHECK(rig.get<Health>().reports_refused == before + 1);
}

TEST_CASE("the way to the bootloader is asked for once") {
  torsio::device::BoardInfo board;
  board.has_bootloader = true;
  Rig rig(board);
  REQUIRE(rig.command(Op::bootloader) == Status::ok);
  CHECK(rig.device->take_bootloader_request());
  CHECK_FALSE(rig.device->take_bootloader_request());
}

TEST_CASE("a fault whose cause lasted for some ticks can be cleared at once when it is over") {
  Rig rig;
  for (int i = 0; i < 4; ++i) {
    rig.inputs.encoder_count += 4000;
    rig.tick();
  }
  REQUIRE(rig.state() == State::fault);
  rig.tick(5);
  CHECK(rig.command(Op::clear_fault) == Status::ok);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("a counter that becomes narrower is no jump") {
  Rig rig;
  for (int i = 0; i < 100; ++i) {
    rig.inputs.encoder_count += 1000;
    rig.tick();
  }
  const auto position = rig.get<Clock>().position_counts;
  ActuatorConfig actuator;
  actuator.counter_bits = 16;
  REQUIRE(rig.set(actuator).ok());
  rig.tick(3);
  CHECK(rig.get<Health>().faults == 0);
  CHECK(rig.get<Clock>().position_counts == position);
}

TEST_CASE("a wall pushes out of the side that is solid") {
  for (const Side side : {Side::above, Side::below}) {
    Rig rig;
    REQUIRE(rig.set(at_once(Law::motor_only)).ok());
    Wall wall;
    wall.side = side;
    wall.stiffness_nm_per_rad = 0.5F;
    REQUIRE(rig.send_status(wall) == Status::ok);
    REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.inputs.encoder_count += static_cast<std::uint32_t>(side == Side::above ? 50 : -50);
    rig.tick(2);
    CHECK(rig.outputs.motor_command_nm * (side == Side::above ? -1.0F : 1.0F) > 0.01F);
    rig.inputs.encoder_count -= static_cast<std::uint32_t>(side == Side::above ? 100 : -100);
    rig.tick(2);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
  }
}

TEST_CASE("telemetry tells a local model, and a torque that fades") {
  Rig rig;
  ControlConfig config = at_once(Law::motor_only);
  config.passive_ramp_s = 0.05F;
  REQUIRE(rig.set(config).ok());
  REQUIRE(rig.send_status(Stream{1, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(60);
  CHECK((rig.telemetry.back().flags & (flag::local_model | flag::passive)) == 0);
  LocalModel model;
  model.sequence = 1;
  model.deadline_s = 0.05F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick(20);
  CHECK((rig.telemetry.back().flags & flag::local_model) != 0);
  rig.tick(60);
  CHECK((rig.telemetry.back().flags & flag::passive) != 0);
}
