// Owners of the actuator. It changes hands without a jump.
#include <cmath>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using doctest::Approx;
using protocol::EventKind;
using protocol::Op;
using protocol::Owner;
using protocol::State;
using protocol::Status;

namespace {

/// A game with a constant force, and a scene with another.
struct TwoMasters : GameRig {
  TwoMasters() {
    configure([](protocol::GameConfig& config) { config.blend_s = 2e-3F; });
    protocol::Constant scene;
    scene.torque_nm = -0.05F;
    REQUIRE(send_status(scene) == Status::ok);
    REQUIRE(send_status(protocol::Commit{1, 0, 1}) == Status::ok);
  }
};

}  // namespace

TEST_CASE("a game gets the actuator when it starts an effect, and not before") {
  GameRig rig;
  CHECK(rig.owner() == Owner::none);
  rig.control(1);  // enable actuators
  const int block = rig.create(kConstant);
  rig.set_effect(block);
  rig.constant(block, 32767);
  rig.tick(20);
  CHECK(rig.state() == State::disarmed);
  CHECK_FALSE(rig.outputs.enabled);
  rig.start(block);
  rig.tick(3);
  CHECK(rig.state() == State::armed);
  CHECK(rig.owner() == Owner::game);
  CHECK(rig.outputs.enabled);
  REQUIRE_FALSE(rig.events.empty());
  CHECK(rig.events.back().kind == EventKind::state_changed);
  CHECK(rig.events.back().owner == Owner::game);
}

TEST_CASE("a game gets no actuator while flash is written") {
  GameRig rig;
  REQUIRE(rig.device->receive(protocol::encode(protocol::Command{3, 0, Op::save})));
  rig.tick(2);
  REQUIRE(rig.device->take_slot_write());
  rig.play_constant(32767);
  rig.tick(3);
  CHECK(rig.state() == State::disarmed);
  rig.device->storage_written();
  rig.play_constant(32767);
  rig.tick(3);
  CHECK(rig.owner() == Owner::game);
}

TEST_CASE("a start that waits for the interrupt when a save begins does not arm") {
  GameRig rig;
  const int block = rig.create(kConstant);
  rig.set_effect(block);
  rig.constant(block, 32767);
  rig.start(block);
  REQUIRE(rig.device->receive(protocol::encode(protocol::Command{3, 0, Op::save})));
  rig.device->service();  // the start is in the ring, and then the save begins
  REQUIRE(rig.device->take_slot_write());
  for (int tick = 0; tick < 3; ++tick) (void)rig.device->tick(rig.inputs);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("a game gets no actuator on the way to the bootloader") {
  GameRig rig;
  REQUIRE(rig.command(Op::bootloader) == Status::ok);
  rig.play_constant(32767);
  rig.tick(3);
  CHECK(rig.state() == State::disarmed);
  CHECK_FALSE(rig.outputs.enabled);
}

TEST_CASE("a game that plays nothing lets go of the actuator after a second") {
  GameRig rig;
  EffectOptions options;
  options.duration_ms = 50;
  rig.play_constant(32767, options);
  rig.tick(60);
  CHECK(rig.owner() == Owner::game);
  rig.tick(980);
  CHECK(rig.owner() == Owner::game);
  rig.tick(30);
  CHECK(rig.owner() == Owner::none);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("games may be shut out; they still see the axis") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.enabled = protocol::Toggle::off; });
  rig.play_constant(32767);
  rig.inputs.encoder_count += 100;
  rig.tick(10);
  CHECK(rig.state() == State::disarmed);
  std::array<std::uint8_t, 64> report{};
  std::size_t size = 0;
  int x = 0;
  while ((size = rig.device->game().next_input(report)) != 0) {
    if (report[0] == 1) x = static_cast<std::int16_t>(report[1] | (report[2] << 8));
  }
  CHECK(x == std::lround(100.0 / 8192 * 360 / 450 * 32767));
}

TEST_CASE("a game cannot take the actuator from the SDK, nor start what would sound later") {
  TwoMasters rig;
  REQUIRE(rig.command(Op::arm) == Status::ok);
  CHECK(rig.owner() == Owner::sdk);
  rig.tick(60);
  rig.play_constant(32767);
  rig.tick(20);
  CHECK(rig.owner() == Owner::sdk);
  CHECK(rig.outputs.motor_command_nm == -0.05F);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  rig.tick(50);
  CHECK(rig.state() == State::disarmed);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("the SDK takes over from a game by arming: told in acknowledgement, event and flag") {
  TwoMasters rig;
  REQUIRE(rig.send_status(protocol::Stream{1, 0, 1}) == Status::ok);
  rig.play_constant(32767);
  rig.tick(40);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
  REQUIRE_FALSE(rig.telemetry.empty());
  CHECK((rig.telemetry.back().flags & protocol::flag::game) != 0);
  float last = rig.outputs.motor_command_nm;
  rig.events.clear();
  REQUIRE(rig.device->receive(protocol::encode(protocol::Command{9, 0, Op::arm})));
  for (int i = 0; i < 80; ++i) {
    rig.tick();
    // Both fade in 50 ms: one down from 0.08, the other to -0.05.
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.01F * 0.13F / 50);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(last == -0.05F);
  CHECK(rig.acknowledgements.back().status == 0);
  CHECK(rig.acknowledgements.back().owner == Owner::sdk);
  REQUIRE(rig.events.size() == 1);
  CHECK(rig.events[0].kind == EventKind::owner_changed);
  CHECK(rig.events[0].owner == Owner::sdk);
  CHECK((rig.telemetry.back().flags & protocol::flag::game) == 0);
}

TEST_CASE("after the SDK has let go, a game gets the actuator by starting an effect again") {
  TwoMasters rig;
  const int block = rig.play_constant(32767);
  rig.tick(40);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(100);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  rig.control(1);
  rig.tick(100);
  CHECK(rig.owner() == Owner::none);
  rig.start(block);
  float last = 0;
  for (int i = 0; i < 10; ++i) {
    rig.tick();
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.01F * 0.08F / 2);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(rig.owner() == Owner::game);
}

TEST_CASE("the SDK may stop a game's force, which lets go along a line of 4 ms") {
  for (const Op op : {Op::disarm, Op::stop}) {
    GameRig rig;
    const int block = rig.play_constant(32767);
    rig.tick(10);
    const float held = rig.outputs.motor_command_nm;
    REQUIRE(held > 0.0F);
    REQUIRE(rig.device->receive(protocol::encode(protocol::Command{7, 0, op})));
    for (int i = 1; i <= 4; ++i) {
      rig.constant(block, 32767);  // an update does not bring it back
      rig.tick();
      CHECK(rig.outputs.motor_command_nm ==
            Approx(held * static_cast<float>(4 - i) / 4).scale(0.08));
    }
    rig.tick(2);
    CHECK(rig.acknowledgements.back().status == 0);
    CHECK(rig.acknowledgements.back().state == State::disarmed);
    rig.constant(block, 32767);
    rig.tick(100);
    CHECK(rig.state() == State::disarmed);
  }
}

TEST_CASE("what a game starts while the SDK lets go is not lost") {
  TwoMasters rig;
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(60);
  REQUIRE(rig.outputs.motor_command_nm == -0.05F);
  REQUIRE(rig.device->receive(protocol::encode(protocol::Command{9, 0, Op::disarm})));
  rig.tick(2);
  rig.play_constant(32767);
  float last = rig.outputs.motor_command_nm;
  for (int i = 0; i < 12; ++i) {
    rig.tick();
    // Down from -0.05 in 4 ms, then up to 0.08 in the blend of 2 ms.
    CHECK(rig.outputs.motor_command_nm >= last);
    CHECK(rig.outputs.motor_command_nm - last < 1.01F * 0.08F / 2);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(rig.owner() == Owner::game);
  CHECK(last == Approx(0.08));
}

TEST_CASE("nothing moves when a game opens the device, wherever the knob stands") {
  // At the middle, at an end, and three turns beyond it, with and without walls there.
  for (const float stiffness : {0.0F, 1.0F}) {
    for (const int counts : {0, 10'240, 34'816}) {
      GameRig rig;
      rig.configure([stiffness](protocol::GameConfig& config) {
        config.end_stiffness_nm_per_rad = stiffness;
        config.blend_s = 0.002F;
      });
      rig.turn(64, counts / 64);
      // As Linux and DirectInput do: reset, stop all, actuators on, gain, and an effect made.
      for (const int control : {4, 4, 3, 1}) rig.control(control);
      rig.gain(32767);
      const int spring = rig.create(kSpring);
      rig.set_effect(spring);
      rig.condition(spring, {});
      for (const float nm : rig.torques(50)) CHECK(nm == 0.0F);
      CHECK(rig.owner() == Owner::none);
      // Started, spring and walls come up in 50 ms, each along a line.
      rig.start(spring);
      float last = 0;
      for (const float nm : rig.torques(100)) {
        CHECK(std::abs(nm - last) < 2.02F * 0.08F / 50);
        last = nm;
      }
      CHECK(rig.owner() == Owner::game);
      if (counts != 0) CHECK(last < 0.0F);
    }
  }
}

TEST_CASE("when the bus is lost a game's force fades in the configured time") {
  GameRig rig;
  rig.play_constant(32767);
  rig.tick(10);
  rig.device->set_connected(false);
  float last = rig.outputs.motor_command_nm;
  for (int i = 0; i < 52; ++i) {
    rig.tick();
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.01F * 0.08F / 50);
    CHECK(rig.outputs.motor_command_nm <= last);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(rig.state() == State::disarmed);
  rig.device->set_connected(true);
  rig.tick(100);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("actuators off fade the force, effects go on unheard, and actuators on bring it back") {
  GameRig rig;
  rig.play_constant(8192);
  EffectOptions options;
  options.duration_ms = 500;
  rig.play_constant(16384, options);
  options.duration_ms = 150;
  rig.play_constant(8191, options);
  rig.tick(10);
  rig.control(2);
  float last = rig.outputs.motor_command_nm;
  for (int i = 0; i < 60; ++i) {
    if (i % 30 == 0) rig.gain(32767);  // such reports neither hasten nor delay it
    rig.tick();
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.01F * 0.08F / 50);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(last == 0.0F);
  CHECK(rig.state() == State::disarmed);
  rig.tick(30);
  options.duration_ms = 300;
  const int begun = rig.play_constant(-4096, options);  // 100 ms after the others
  rig.tick(100);
  rig.constant(begun, -2048);
  rig.tick(100);
  CHECK(rig.state() == State::disarmed);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.control(1);
  const auto full = [](int level) { return about(0.08 * level / 32767); };
  rig.tick(2);  // at 302 ms one is over
  CHECK(rig.owner() == Owner::game);
  CHECK(rig.outputs.motor_command_nm == full(8192 + 16384 - 2048));
  rig.tick(90);
  CHECK(rig.outputs.motor_command_nm == full(8192 + 16384 - 2048));
  rig.tick(30);
  CHECK(rig.outputs.motor_command_nm == full(8192 + 16384));
  rig.tick(100);
  CHECK(rig.outputs.motor_command_nm == full(8192));
}

TEST_CASE("actuators off, and reset as drivers begin: nothing moves, nothing comes back") {
  GameRig rig;
  rig.play_constant(32767);
  rig.tick(10);
  rig.control(2);
  rig.tick(100);
  for (const int control : {4, 4, 3, 1}) {
    rig.control(control);
    for (int i = 0; i < 20; ++i) {
      rig.tick();
      CHECK(rig.state() == State::disarmed);
      CHECK(rig.outputs.motor_command_nm == 0.0F);
    }
  }
}

TEST_CASE("a fault silences the game, and clearing it does not bring the force back") {
  GameRig rig;
  const int block = rig.play_constant(32767);
  rig.tick(10);
  rig.inputs.emergency_stop = true;
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  CHECK_FALSE(rig.outputs.enabled);
  rig.start(block);
  rig.tick(10);
  CHECK(rig.state() == State::fault);
  rig.inputs.emergency_stop = false;
  rig.tick(2);
  REQUIRE(rig.command(Op::clear_fault) == Status::ok);
  rig.tick(100);
  CHECK(rig.state() == State::disarmed);
  // Nor does another that is started bring it back.
  const int other = rig.play_constant(8192);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == about(0.08 * 8192 / 32767));
  rig.stop(other);
  rig.start(block);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
}

TEST_CASE("a game that hangs loses its endless push, but keeps spring and what has an end") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.silence_s = 0.5F; });
  const int spring = rig.create(kSpring);
  rig.set_effect(spring);
  rig.condition(spring, {});
  rig.start(spring);
  EffectOptions finite;
  finite.duration_ms = 2000;
  rig.play_constant(1000, finite);
  rig.play_constant(32767 - 1000);
  rig.tick(490);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
  rig.tick(30);
  CHECK(rig.outputs.motor_command_nm == about(0.08 * 1000 / 32767));
  rig.tick(3000);
  CHECK(rig.owner() == Owner::game);  // the spring plays
}

TEST_CASE("an order to disarm stands, whenever silence ends a game's push") {
  for (int ticks = 490; ticks < 510; ++ticks) {
    CAPTURE(ticks);
    GameRig rig;
    rig.configure([](protocol::GameConfig& config) { config.silence_s = 0.5F; });
    rig.play_constant(32767);
    rig.tick(ticks);
    REQUIRE(rig.command(Op::disarm) == Status::ok);
    rig.tick(50);  // the push fades
    for (int i = 0; i < 50; ++i) {
      rig.tick();
      CHECK(rig.state() == State::disarmed);
    }
  }
}

TEST_CASE("a game that only asks does not hang") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.silence_s = 0.5F; });
  rig.play_constant(32767);
  for (int i = 0; i < 5; ++i) {
    rig.tick(400);
    std::array<std::uint8_t, 64> answer{};
    REQUIRE(rig.device->game().get_feature(0x22, answer) == 5);
  }
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
}

TEST_CASE("a game that hangs loses what it repeats without end") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.silence_s = 0.5F; });
  const int block = rig.create(kConstant);
  EffectOptions options;
  options.duration_ms = 20;
  rig.set_effect(block, options);
  rig.constant(block, 32767);
  rig.start(block, 255);
  rig.tick(490);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
  rig.tick(30);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}
