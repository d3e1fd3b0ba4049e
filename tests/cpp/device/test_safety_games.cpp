// Limits of a game's effects: the promises of docs/reference/games.md beside the torques
// themselves.
#include <algorithm>
#include <cmath>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using protocol::Op;
using protocol::Owner;
using protocol::State;
using protocol::Status;

TEST_CASE("an effect that is started again is there once") {
  for (const int type : {kConstant, kSquare}) {
    GameRig rig;
    const int block = rig.create(type);
    rig.set_effect(block);
    rig.constant(block, 8192);
    rig.periodic(block, 8192, 0, 0, 1000);
    for (int n = 0; n < 3; ++n) {
      rig.start(block);
      rig.tick(5);
    }
    CHECK(rig.outputs.motor_command_nm == about(0.02));
  }
}

TEST_CASE("starting another effect is no new arming") {
  GameRig rig;
  rig.play_constant(8192);
  rig.tick(5);
  rig.events.clear();
  rig.play_constant(8192);
  rig.tick(5);
  CHECK(rig.events.empty());
}

TEST_CASE("starting what does not exist arms nobody") {
  GameRig rig;
  rig.start(7);
  const int block = rig.create(kConstant);
  rig.set_effect(block);
  rig.constant(block, 32767);
  rig.free(block);
  rig.start(block);
  rig.tick(5);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("what was cut off is not the beginning of what comes next") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.blend_s = 0.05F; });
  const int block = rig.play_constant(32767);
  rig.tick(100);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  rig.tick(5);
  rig.constant(block, 1000);
  rig.start(block);
  for (int i = 0; i < 80; ++i) {
    rig.tick();
    CHECK(std::abs(rig.outputs.motor_command_nm) <= 1.01F * 0.08F * 1000 / 32767);
  }
  CHECK(rig.outputs.motor_command_nm > 0.0F);
}

TEST_CASE("a host that says one word to a game's knob and no more does not stop the game") {
  GameRig rig;
  rig.play_constant(32767);
  rig.tick(5);
  REQUIRE(rig.send_status(protocol::Stream{1, 0, 0}) == Status::ok);
  rig.tick(2000);
  CHECK(rig.owner() == Owner::game);
  CHECK(rig.outputs.motor_command_nm == about(0.08));
}

TEST_CASE("a second without anything to play counts from the last thing that played") {
  GameRig rig;
  EffectOptions options;
  options.duration_ms = 50;
  const int block = rig.play_constant(32767, options);
  for (int again = 0; again < 3; ++again) {
    rig.tick(900);
    REQUIRE(rig.owner() == Owner::game);
    rig.start(block);
    rig.tick(3);
  }
  rig.tick(1100);
  CHECK(rig.owner() == Owner::none);
}

TEST_CASE("a game whose actuators are disabled as the bus is lost fades all the same") {
  GameRig rig;
  rig.play_constant(32767);
  rig.tick(20);
  rig.control(2);
  rig.device->set_connected(false);
  float last = rig.outputs.motor_command_nm;
  for (int i = 0; i < 60; ++i) {
    rig.tick();
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.01F * 0.08F / 50);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(last == 0.0F);
}

TEST_CASE("a silence of 0 is no limit, and an effect without end has none") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.silence_s = 0; });
  rig.play_constant(32767);
  rig.tick(66'000);
  CHECK(rig.outputs.motor_command_nm == about(0.08));
}

TEST_CASE("each side of a condition holds its saturation") {
  for (const int type : {kSpring, kFriction}) {
    for (const int way : {1, -1}) {
      CAPTURE(type);
      GameRig rig;
      GameRig::ConditionOptions options;
      (way > 0 ? options.positive_saturation : options.negative_saturation) = 8192;
      rig.play_condition(type, options);
      rig.tick(2);
      rig.turn(100 * way, 400);
      CHECK(rig.outputs.motor_command_nm == about(-0.02 * way));
      rig.turn(-100 * way, 800);
      CHECK(rig.outputs.motor_command_nm == about(0.08 * way));
    }
  }
}

TEST_CASE("effects of no strength are no fault") {
  GameRig rig;
  const int friction = rig.create(kFriction);
  EffectOptions silent;
  silent.gain = 0;
  rig.set_effect(friction, silent);
  rig.condition(friction, {});
  rig.start(friction);
  const int ramp = rig.create(kRamp);
  EffectOptions finite;
  finite.duration_ms = 100;
  rig.set_effect(ramp, finite);
  rig.ramp(ramp, 0, 0);
  rig.start(ramp);
  rig.turn(3, 50);
  CHECK(rig.state() == State::armed);
  CHECK(rig.get<protocol::Health>().faults == 0);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("full level is what the motor can give, where that is less than the game's torque") {
  GameRig rig;
  protocol::ActuatorConfig actuator;
  actuator.motor_torque_max_nm = 0.02F;
  REQUIRE(rig.set(actuator).ok());
  rig.play_constant(16384);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == about(0.01));
}

TEST_CASE("orders to the interrupt are refused when there is no room") {
  device::game::Forces forces{{}};
  for (int i = 0; i < 4; ++i) CHECK(forces.give({}));
  CHECK_FALSE(forces.give({}));
}
