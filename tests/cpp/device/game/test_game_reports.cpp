// The pool of blocks and its reports. A good report is answered; a bad one changes nothing.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using doctest::Approx;

namespace {

constexpr int kSuccess = 1, kFullPool = 2, kError = 3;

struct Inputs {
  std::vector<int> x;
  std::vector<std::array<int, 3>> states;  // status bits, playing, block

  explicit Inputs(device::Device& device, int most = 1000) {
    std::array<std::uint8_t, 64> r{};
    for (std::size_t size = 0; most-- > 0 && (size = device.game().next_input(r)) != 0;) {
      if (r[0] == 1) {
        CHECK(size == 6);
        x.push_back(static_cast<std::int16_t>(r[1] | (r[2] << 8)));
      } else {
        CHECK(r[0] == 2);
        CHECK(size == 4);
        states.push_back({r[1], r[2], r[3]});
      }
    }
  }
};

}  // namespace

TEST_CASE("the pool holds forty blocks; then it is full, until one is freed") {
  GameRig rig;
  for (int block = 1; block <= 40; ++block) {
    CHECK(rig.load(1 + block % 11) == std::array{block, kSuccess});
  }
  CHECK(rig.load(kConstant) == std::array{0, kFullPool});
  rig.free(17);
  CHECK(rig.load(kSine) == std::array{17, kSuccess});
  CHECK(rig.load(kSine) == std::array{0, kFullPool});
}

TEST_CASE("the pool report says how many may play at once, and that the device manages it") {
  GameRig rig;
  std::array<std::uint8_t, 64> r{};
  REQUIRE(rig.device->game().get_feature(0x23, r) == 5);
  CHECK(r[0] == 0x23);
  CHECK(r[3] == 40);
  CHECK((r[4] & 1) == 1);
  const int size = r[1] | (r[2] << 8);
  REQUIRE(rig.device->game().get_feature(0x22, r) == 5);
  CHECK((r[3] | (r[4] << 8)) == size);
  (void)rig.create(kConstant);
  REQUIRE(rig.device->game().get_feature(0x22, r) == 5);
  CHECK((r[3] | (r[4] << 8)) < size);
}

TEST_CASE("a type that does not exist is answered with an error and takes no block") {
  GameRig rig;
  CHECK(rig.load(0) == std::array{0, kError});
  CHECK(rig.load(12) == std::array{0, kError});
  CHECK(rig.load(255) == std::array{0, kError});
  CHECK(rig.load(kConstant) == std::array{1, kSuccess});
}

TEST_CASE("feature reports that do not exist are stalled") {
  GameRig rig;
  std::array<std::uint8_t, 64> r{};
  CHECK(rig.device->game().get_feature(0x01, r) == 0);
  CHECK(rig.device->game().get_feature(0x21, r) == 0);
  CHECK_FALSE(rig.device->game().set_feature(Bytes{}.u8(0x22).u8(1).data));
  CHECK_FALSE(rig.device->game().set_feature({}));
}

TEST_CASE("axis and buttons are told again ten times a second, for who has just begun to listen") {
  GameRig rig;
  rig.inputs.encoder_count += 1000;
  rig.device->set_buttons(2);
  rig.tick(5);
  const Inputs first(*rig.device);
  REQUIRE(first.x.size() == 1);
  std::size_t told = 0;
  for (int i = 0; i < 1000; ++i) {
    rig.tick();
    const Inputs again(*rig.device);
    told += again.x.size();
    CHECK((again.x.empty() || again.x == first.x));
    CHECK(again.states.empty());
  }
  CHECK(told == 10);
}

TEST_CASE("a request gets axis, buttons and what plays, and takes nothing away") {
  GameRig rig;
  rig.inputs.encoder_count += 100;
  rig.device->set_buttons(1);
  const int block = rig.create(kConstant);
  REQUIRE(rig.create(kSine) == block + 1);
  rig.start(block + 1);
  rig.tick(3);
  std::array<std::uint8_t, 64> r{};
  REQUIRE(rig.device->game().get_input(1, r) == 6);
  CHECK(static_cast<std::int16_t>(r[1] | (r[2] << 8)) ==
        std::lround(100.0 / 8192 * 360 / 450 * 32767));
  CHECK(r[3] == 1);
  CHECK((r[4] | r[5]) == 0);  // the second axis
  REQUIRE(rig.device->game().get_input(2, r) == 4);
  CHECK(std::vector(r.begin(), r.begin() + 4) ==
        std::vector<std::uint8_t>{2, 14, 1, static_cast<std::uint8_t>(block + 1)});
  CHECK(rig.device->game().get_input(3, r) == 0);
  CHECK(rig.device->game().get_input(1, std::span(r).first(3)) == 0);
  const Inputs told(*rig.device);
  CHECK(told.x.size() == 1);
  CHECK(std::ranges::count(told.states, std::array{14, 1, block + 1}) == 1);
}

TEST_CASE("all forty effects sound together") {
  GameRig rig;
  for (int i = 0; i < 40; ++i) rig.play_constant(500);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm == about(0.08 * 40 * 500 / 32767));
}

TEST_CASE("what names a free block, another kind of effect or no block at all changes nothing") {
  GameRig rig;
  const int block = rig.play_constant(10000);
  rig.tick(5);
  const float before = rig.outputs.motor_command_nm;
  for (const int other : {0, 2, 40, 41, 200, 255}) {
    rig.constant(other, 32767);
    rig.set_effect(other);
    rig.start(other);
    rig.stop(other);
    rig.free(other);
  }
  rig.ramp(block, 32767, 32767);
  rig.periodic(block, 32767, 32767, 0, 10);
  rig.condition(block, {});
  // An operation and a control that do not exist, levels out of range.
  rig.write(
      Bytes{}.u8(0x11).u8(block).u8(1).u16(1).u16(0).u16(0).u16(40000).u8(0).u8(2).u16(0).u16(0));
  rig.operate(block, 0, 1);
  rig.operate(block, 4, 1);
  rig.constant(block, -32768);
  rig.gain(32768);
  rig.control(0);
  rig.control(7);
  // Too short, empty, and of no known id.
  rig.write(Bytes{}.u8(0x15).u8(block));
  rig.write(Bytes{});
  rig.write(Bytes{}.u8(0x7F).u8(1).u8(1).u8(1));
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == before);
}

TEST_CASE("an update finds its effect whatever type it names: Linux names the one created last") {
  // hid-pidff before June 2026.
  for (const int type : {int{kSine}, int{kSpring}, 0, 12, 255}) {
    CAPTURE(type);
    GameRig rig;
    const int block = rig.play_constant(10000);
    rig.create(kSine);
    rig.tick(5);
    CHECK(rig.outputs.motor_command_nm == about(0.08 * 10000 / 32767));
    Bytes turned = Bytes{}.u8(0x11).u8(block).u8(type).u16(kWithoutEnd).u16(0).u16(0).u16(32767);
    rig.write(turned.u8(0).u8(2).u16(kEast).u16(0));
    rig.tick(5);
    CHECK(rig.outputs.motor_command_nm == about(-0.08 * 10000 / 32767));
  }
}

TEST_CASE("reports filled up to the longest length, as Windows sends them, are good") {
  GameRig rig;
  const int block = rig.play_constant(10000);
  Bytes padded = Bytes{}.u8(0x15).u8(block).u16(20000);
  padded.data.resize(18, 0xCC);
  rig.write(padded);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08 * 20000 / 32767));
}

TEST_CASE("the effects of two games' endpoints interleave: each report finds its block") {
  GameRig rig;
  const int a = rig.create(kConstant);
  rig.constant(a, 3000);
  const int b = rig.create(kConstant);
  rig.set_effect(b);
  rig.start(b);
  const int c = rig.create(kConstant);
  rig.set_effect(a);
  rig.constant(b, 5000);
  rig.start(a);
  rig.set_effect(c);
  rig.free(b);
  const int d = rig.create(kConstant);  // in b's place
  CHECK(d == b);
  rig.constant(c, 7000);
  rig.start(c);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm == about(0.08 * 10000 / 32767));
}

TEST_CASE("ten thousand updates a second for a minute build up no delay") {
  GameRig rig;
  std::array<int, 40> blocks{};
  for (int& block : blocks) block = rig.play_constant(0);
  rig.tick(40);
  // All levels go up by one in a millisecond. Each block is written every 4 ms, and four blocks go
  // to the control loop in a tick: no level is ever older than 14 ms.
  int oldest_ms = 0;
  for (int ms = 0; ms < 60'000; ++ms) {
    const int level = ms % 800;
    for (std::size_t i = 0; i < 10; ++i) {
      rig.constant(blocks[(static_cast<std::size_t>(ms) * 10 + i) % 40], level);
    }
    rig.tick();
    const double mean = static_cast<double>(rig.outputs.motor_command_nm) / 0.08 * 32767 / 40;
    if (level > 20) oldest_ms = std::max(oldest_ms, static_cast<int>(level - mean));
  }
  CHECK(oldest_ms <= 14);
  for (const int block : blocks) rig.constant(block, 100);
  // Ten ticks until all are there, and a frame that joins the last to the one before.
  rig.tick(24);
  CHECK(rig.outputs.motor_command_nm == about(0.08 * 4000 / 32767));
}

TEST_CASE("start and stop between two ticks: the last one counts") {
  GameRig rig;
  const int block = rig.play_constant(32767);
  rig.stop(block);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.start(block);
  rig.tick(3);
  rig.stop(block);
  rig.start(block);
  rig.tick(3);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08));
}

TEST_CASE("a freed block falls silent, and its number is given out clean") {
  GameRig rig;
  const int block = rig.play_constant(32767);
  rig.envelope(block, 0, 1000, 0, 1000);
  rig.tick(5);
  rig.free(block);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  const int again = rig.create(kConstant);
  CHECK(again == block);
  rig.start(again);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.set_effect(again);
  rig.constant(again, 16384);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == about(0.04));
}

TEST_CASE("a block that is freed and given out again in a rush does not go on") {
  GameRig rig;
  const int block = rig.play_constant(32767);
  std::array<int, 8> others{};
  for (int& other : others) {
    other = rig.create(kConstant);
    rig.set_effect(other);
  }
  rig.tick(20);
  // More between two ticks than the control loop takes in one.
  for (const int other : others) rig.constant(other, 1000);
  rig.free(block);
  REQUIRE(rig.create(kConstant) == block);
  rig.set_effect(block);
  rig.constant(block, 20000);
  rig.tick(20);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("stop all behind as much as the control loop takes in one tick stops all nevertheless") {
  for (int rush = 1; rush <= 16; ++rush) {
    CAPTURE(rush);
    GameRig rig;
    rig.play_constant(32767);
    std::vector<int> others;
    for (int i = 0; i < rush; ++i) {
      others.push_back(rig.create(kConstant));
      rig.set_effect(others.back());
      rig.tick(2);
    }
    for (const int other : others) rig.constant(other, 1000);
    rig.control(3);
    rig.tick(100);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
  }
}

TEST_CASE("start solo stops the others, stop all stops everything, reset frees it too") {
  GameRig rig;
  rig.play_constant(10000);
  const int second = rig.play_constant(5000);
  rig.tick(5);
  rig.start_solo(second);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == Approx(0.08 * 5000 / 32767));
  rig.control(3);
  rig.tick(25);
  CHECK(rig.outputs.motor_command_nm == about(0.04 * 5000 / 32767, 0.05));  // in 50 ms
  rig.tick(30);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.start(second);
  rig.gain(16384);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == about(0.04 * 5000 / 32767));
  rig.control(4);
  rig.tick(55);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.start(second);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.play_constant(5000);  // the gain stays
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == about(0.04 * 5000 / 32767));
}

TEST_CASE("the axis is exact, centred, monotonic and ends at its ends") {
  for (const float range_deg : {10.0F, 360.0F, 900.0F, 36000.0F}) {
    GameRig rig;
    rig.configure([&](protocol::GameConfig& config) { config.range_deg = range_deg; });
    rig.tick(2);
    CHECK(Inputs(*rig.device).x == std::vector{0});
    int last = 0;
    // Steps of less than a quarter of a turn.
    for (int count = 0; count < 1'000'000; count += 1 + count / 3 % 2003) {
      rig.inputs.encoder_count = static_cast<std::uint32_t>(count);
      rig.tick(2);
      const double exact = count * 360.0 / 8192 / (range_deg / 2.0) * 32767;
      const Inputs in(*rig.device);
      const int x = in.x.empty() ? last : in.x.back();
      CHECK(x >= last);
      CHECK(std::abs(x - std::min(exact, 32767.0)) <= 0.501);
      last = x;
    }
  }
}

TEST_CASE("the state report tells which effects begin and end, and who has the actuator") {
  GameRig rig;
  rig.tick(2);
  (void)Inputs(*rig.device);
  const int a = rig.create(kConstant);
  EffectOptions options;
  options.duration_ms = 20;
  const int b = rig.play_constant(1000, options);
  rig.tick(5);
  CHECK(a != b);
  Inputs begin(*rig.device);
  REQUIRE(begin.states.size() == 1);
  CHECK(begin.states[0] == std::array{0x0E, 1, b});  // enabled, let, powered
  rig.tick(30);
  Inputs end(*rig.device);
  REQUIRE(end.states.size() == 1);
  CHECK(end.states[0] == std::array{0x0E, 0, b});
  rig.control(5);
  rig.tick(2);
  Inputs paused(*rig.device);
  REQUIRE(paused.states.size() == 1);
  CHECK((paused.states[0][0] & 1) == 1);
  rig.control(6);
  rig.inputs.emergency_stop = true;
  rig.tick(3);
  Inputs stopped(*rig.device);
  REQUIRE_FALSE(stopped.states.empty());
  CHECK((stopped.states.back()[0] & 0x08) == 0);
}

TEST_CASE("the override switch is off only while games are shut out or the SDK has the actuator") {
  GameRig rig;
  const auto state = [&rig] {
    rig.control(1);  // the answer is the state
    rig.tick(2);
    const Inputs found(*rig.device);
    REQUIRE_FALSE(found.states.empty());
    return found.states.back()[0];
  };
  CHECK((state() & 0x04) != 0);  // DirectInput reads 0 as: the user has switched forces off
  REQUIRE(rig.command(protocol::Op::arm) == protocol::Status::ok);
  CHECK((state() & 0x04) == 0);
  REQUIRE(rig.command(protocol::Op::disarm) == protocol::Status::ok);
  CHECK((state() & 0x04) != 0);
  rig.configure([](protocol::GameConfig& config) { config.enabled = protocol::Toggle::off; });
  CHECK((state() & 0x04) == 0);
}

TEST_CASE("a knob that never rests does not keep the state reports back") {
  GameRig rig;
  rig.play_constant(1000);
  std::vector<std::array<int, 3>> states;
  for (int i = 0; i < 10; ++i) {
    rig.inputs.encoder_count += 50;
    rig.tick();
    for (const auto& state : Inputs(*rig.device, 1).states) states.push_back(state);
  }
  CHECK_FALSE(states.empty());
}
