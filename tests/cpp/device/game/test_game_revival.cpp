// An effect that the device ended comes back with the game's next update. An effect that the game
// ended does not. A force that nobody updates ends soon.
#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using doctest::Approx;
using protocol::Op;
using protocol::Owner;

namespace {

constexpr int kHalf = 16384;
const auto kHalfNm = about(0.08 * kHalf / 32767);

/// A constant force whose game has fallen silent for long enough.
struct Silenced : GameRig {
  Silenced() {
    configure([](protocol::GameConfig& config) { config.silence_s = 0.5F; });
    block = play_constant(32767);
    tick(520);
    REQUIRE(outputs.motor_command_nm == 0.0F);
  }
  int block = 0;
};

/// A host that fetches an input report whenever there is one, as systems do while a program has
/// the device open.
void live(GameRig& rig, int ticks) {
  std::array<std::uint8_t, 64> report{};
  for (int i = 0; i < ticks; ++i) {
    rig.tick();
    while (rig.device->game().next_input(report) != 0) {
    }
  }
}

}  // namespace

TEST_CASE("an update of one effect does not bring back another") {
  Silenced rig;
  const int other = rig.create(kConstant);
  rig.set_effect(other);
  rig.constant(other, 32767);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("what the game has ended stays ended, also after the device had ended it") {
  for (const int how : {0, 1, 2, 3, 4, 5}) {
    CAPTURE(how);
    Silenced rig;
    switch (how) {
      case 0:
        rig.stop(rig.block);
        break;
      case 1:
        rig.control(3);  // stop all
        break;
      case 2:
        rig.control(2);  // between actuators off and on
        rig.stop(rig.block);
        rig.control(1);
        break;
      case 3:
        rig.control(4);  // reset
        REQUIRE(rig.create(kConstant) == rig.block);
        break;
      case 4:
        rig.free(rig.block);
        REQUIRE(rig.create(kConstant) == rig.block);
        break;
      default: {
        const int other = rig.create(kSpring);
        rig.start_solo(other);
      }
    }
    rig.set_effect(rig.block);
    rig.constant(rig.block, kHalf);
    rig.tick(20);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
  }
}

TEST_CASE("an update that came before the stop does not outlive it") {
  Silenced rig;
  rig.constant(rig.block, kHalf);
  rig.stop(rig.block);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("an update brings a force back when the SDK has handed the actuator back, not before") {
  GameRig rig;
  const int block = rig.play_constant(32767);
  rig.tick(40);
  REQUIRE(rig.command(Op::arm) == protocol::Status::ok);
  rig.tick(100);
  rig.constant(block, 1000);  // in vain, but it still wants to play
  rig.tick(20);
  CHECK(rig.owner() == Owner::sdk);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  REQUIRE(rig.command(Op::disarm) == protocol::Status::ok);
  rig.tick(20);
  CHECK(rig.owner() == Owner::none);
  rig.constant(block, kHalf);
  rig.tick(2);
  CHECK(rig.owner() == Owner::game);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
}

TEST_CASE("an update does not undo the SDK's stop of a game, nor a fault") {
  for (const bool fault : {false, true}) {
    CAPTURE(fault);
    GameRig rig;
    const int block = rig.play_constant(32767);
    rig.tick(40);
    if (fault) {
      rig.inputs.emergency_stop = true;
      rig.tick(2);
      rig.inputs.emergency_stop = false;
      rig.tick(2);
      REQUIRE(rig.command(Op::clear_fault) == protocol::Status::ok);
    } else {
      REQUIRE(rig.command(Op::disarm) == protocol::Status::ok);
    }
    rig.constant(block, kHalf);
    rig.tick(20);
    CHECK(rig.owner() == Owner::none);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
    rig.start(block);
    rig.tick(2);
    CHECK(rig.outputs.motor_command_nm == kHalfNm);
  }
}

TEST_CASE("an update brings a force back after the bus was suspended") {
  // As a computer that sleeps does (USB 2.0, 7.1.7).
  GameRig rig;
  const int block = rig.play_constant(32767);
  rig.tick(40);
  rig.device->set_connected(false);
  rig.tick(200);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.device->set_connected(true);
  rig.tick(50);
  CHECK(rig.outputs.motor_command_nm == 0.0F);  // nobody has asked yet
  rig.constant(block, kHalf);
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
}

TEST_CASE("what has an end comes back for the rest of its time only") {
  GameRig rig;
  EffectOptions options;
  options.duration_ms = 1000;
  const int block = rig.play_constant(32767, options);
  rig.tick(300);
  rig.device->set_connected(false);
  rig.tick(200);
  rig.device->set_connected(true);
  rig.constant(block, kHalf);
  rig.tick(400);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
  rig.tick(110);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.constant(block, 32767);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm == 0.0F);

  rig.start(block);
  rig.tick(300);
  rig.device->set_connected(false);
  rig.tick(2000);
  rig.device->set_connected(true);
  rig.constant(block, kHalf);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  CHECK(rig.owner() == Owner::none);  // nor does it take the actuator
}

TEST_CASE("a new configuration brings nothing back") {
  Silenced rig;
  rig.tick(2000);
  REQUIRE(rig.owner() == Owner::none);
  rig.configure([](protocol::GameConfig& config) { config.gain = 0.5F; });
  rig.tick(50);
  CHECK(rig.owner() == Owner::none);
}

TEST_CASE("a game whose device nobody has open any more loses its forces in half a second") {
  GameRig rig;
  rig.play_constant(32767);
  rig.play_condition(kSpring, {});
  live(rig, 3000);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
  rig.tick(450);  // nobody fetches reports
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
  rig.tick(160);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.tick(1010);
  CHECK(rig.owner() == Owner::none);
}

TEST_CASE("a game that dies in its pause menu leaves no force for the next one") {
  GameRig rig;
  rig.play_constant(32767);
  live(rig, 100);
  rig.control(5);
  live(rig, 20'000);
  CHECK(rig.owner() == Owner::game);
  rig.tick(1700);  // nobody fetches reports
  CHECK(rig.owner() == Owner::none);
  rig.control(6);
  live(rig, 20);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("actuators that come on bring back no force of a game that is gone") {
  for (const bool is_muted : {true, false}) {
    CAPTURE(is_muted);
    GameRig rig;
    rig.play_constant(32767);
    live(rig, 100);
    if (is_muted) rig.control(2);
    live(rig, 100);
    rig.tick(2700);  // nobody fetches reports
    CHECK(rig.owner() == Owner::none);
    rig.control(2);
    live(rig, 100);
    rig.control(1);
    live(rig, 100);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
  }
}

TEST_CASE("a pause, and actuators that are off, end with the game that wanted them") {
  for (const int silence : {2, 5}) {
    CAPTURE(silence);
    GameRig rig;
    rig.play_constant(32767);
    live(rig, 100);
    rig.control(silence);
    live(rig, 100);
    rig.tick(2700);  // nobody fetches reports
    rig.play_constant(16384);
    live(rig, 100);
    CHECK(rig.outputs.motor_command_nm == Approx(0.04).epsilon(0.001));
  }
}

TEST_CASE("actuators that come on take nothing from the SDK, and an update follows it") {
  GameRig rig;
  const int block = rig.play_constant(32767);
  rig.tick(40);
  rig.control(2);
  rig.tick(100);
  REQUIRE(rig.command(Op::arm) == protocol::Status::ok);
  rig.control(1);
  rig.tick(60);
  CHECK(rig.owner() == Owner::sdk);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  REQUIRE(rig.command(Op::disarm) == protocol::Status::ok);
  rig.tick(20);
  CHECK(rig.owner() == Owner::none);
  rig.constant(block, kHalf);
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
}

TEST_CASE("a program that never fetches reports keeps its force until the silence is over") {
  GameRig rig;
  rig.play_constant(32767);
  rig.tick(9900);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
}

TEST_CASE("a device that is open again gets its force back with the next update") {
  GameRig rig;
  const int block = rig.play_constant(32767);
  live(rig, 100);
  rig.tick(700);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  live(rig, 100);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.constant(block, kHalf);
  live(rig, 2);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
}

TEST_CASE("what a game starts during a fault is over with it") {
  GameRig rig;
  rig.inputs.emergency_stop = true;
  rig.tick(2);
  const int block = rig.play_constant(kHalf);
  rig.tick(20);
  rig.inputs.emergency_stop = false;
  REQUIRE(rig.command(Op::clear_fault) == protocol::Status::ok);
  rig.constant(block, 32767);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.start(block);
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == about(0.08));
}

TEST_CASE("a gain of nothing ends with the game that wanted it, another one stays") {
  for (const int gain : {0, kHalf}) {
    CAPTURE(gain);
    GameRig rig;
    rig.play_constant(kHalf);
    live(rig, 100);
    rig.gain(gain);
    if (gain != 0) rig.control(5);
    live(rig, 100);
    rig.tick(1000);  // dead
    rig.play_constant(kHalf);
    live(rig, 20);
    const double share = gain == 0 ? 1.0 : gain / 32767.0;
    CHECK(rig.outputs.motor_command_nm == about(share * 0.08 * kHalf / 32767));
  }
}

TEST_CASE("the effects of a program that is gone take no place from the next one's") {
  GameRig rig;
  int first = 0;
  for (int n = 0; n < 40; ++n) first = rig.play_constant(400);
  live(rig, 100);
  REQUIRE(rig.load(kConstant)[1] == 2);  // full
  live(rig, 100);
  REQUIRE(rig.load(kConstant)[1] == 2);  // also while it lives on
  rig.tick(1000);                        // dead
  const int block = rig.play_constant(kHalf);
  live(rig, 20);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
  rig.constant(first, 32767);  // nobody's any more
  live(rig, 20);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
  CHECK(block == 1);
}

TEST_CASE("the next program's effects are not taken for those of the one that is gone") {
  for (const int left : {38, 39}) {
    CAPTURE(left);
    GameRig rig;
    for (int n = 0; n < left; ++n) rig.play_constant(400);
    live(rig, 100);
    rig.tick(1000);  // dead
    const int own = left == 39 ? rig.create(kConstant) : rig.play_constant(kHalf);
    for (int n = 0; n < 39; ++n) REQUIRE(rig.load(kConstant)[1] == 1);
    CHECK(rig.load(kConstant)[1] == 2);
    rig.set_effect(own);
    rig.constant(own, kHalf);
    rig.start(own);
    live(rig, 20);
    CHECK(rig.outputs.motor_command_nm == kHalfNm);
  }
}

TEST_CASE("a program that goes on after it was taken for gone keeps its effects") {
  GameRig rig;
  int last = 0;
  for (int n = 0; n < 40; ++n) last = rig.play_constant(400);
  live(rig, 100);
  rig.tick(1000);
  rig.constant(last, kHalf);
  live(rig, 20);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
  CHECK(rig.load(kConstant)[1] == 2);
}

TEST_CASE("who presses a button is there, however long the game was silent") {
  GameRig rig;
  const int block = rig.create(kConstant);
  EffectOptions options;
  options.trigger = 1;
  rig.set_effect(block, options);
  rig.constant(block, kHalf);
  live(rig, 11'000);
  rig.device->game().set_buttons(1);
  live(rig, 9000);
  CHECK(rig.outputs.motor_command_nm == kHalfNm);
  live(rig, 1100);  // the default silence
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}
