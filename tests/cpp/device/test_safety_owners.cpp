// A game and the SDK together, and the limits of a game. Each of these lines was once
// deleted without any other test noticing; tests/mutation has the list.
#include <cmath>

#include "device/game/game_rig.hpp"
#include "device/played.hpp"

using namespace torsio::protocol;
using torsio::test::at_once;
using torsio::test::GameRig;
using torsio::test::Rig;

TEST_CASE("a game cannot begin while the bus is away, nor while the torque fades") {
  GameRig rig;
  REQUIRE(rig.set(at_once(Law::motor_only, 0.1F)).ok());
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
  // Half of full level is half of the possible torque.
  GameRig half;
  REQUIRE(half.set(config).ok());
  half.play_constant(16384);
  half.tick(10);
  CHECK(half.outputs.motor_command_nm == torsio::test::about(0.005));
}

TEST_CASE(
    "a soft start ends at the full torque, of a local model too, and never has an old one in it") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only, 0.05F)).ok());
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
