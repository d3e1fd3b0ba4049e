// Lines of the games' part that only an odd game, an odd moment or an odd configuration reaches.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using protocol::Op;
using protocol::Status;

namespace {

/// Reports that wait for the host on the game's interface, at most `most`.
std::vector<std::array<std::uint8_t, 64>> inputs(GameRig& rig, int most = 100) {
  std::vector<std::array<std::uint8_t, 64>> reports;
  std::array<std::uint8_t, 64> report{};
  while (most-- > 0 && rig.device->game().next_input(report) != 0) reports.push_back(report);
  return reports;
}

}  // namespace

TEST_CASE("attack and fade that leave no time between them never turn the force round") {
  GameRig rig;
  EffectOptions options;
  options.duration_ms = 50;
  const int block = rig.create(kConstant);
  rig.set_effect(block, options);
  rig.constant(block, 32767);
  // Each alone would take twice as long as the effect lasts.
  rig.envelope(block, 0, 100, 0, 100);
  rig.start(block);
  for (const float nm : rig.torques(60)) CHECK(nm >= 0.0F);
}

TEST_CASE("a device that is told twice to pause goes on where it was paused first") {
  GameRig rig;
  const int block = rig.create(kRamp);
  EffectOptions options;
  options.duration_ms = 1000;
  rig.set_effect(block, options);
  rig.ramp(block, 0, 32767);
  rig.start(block);
  rig.tick(101);
  rig.control(5);
  rig.tick(100);
  rig.control(5);  // and a gain, which travels with it
  rig.gain(32767);
  rig.tick(100);
  rig.control(6);
  rig.tick(1);
  // A tenth of its time has passed, and a tick more or less.
  CHECK(rig.outputs.motor_command_nm == about(0.08 * 0.1, 0.03));
}

TEST_CASE("a new gain of the device is blended as any other change") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.blend_s = 0.02F; });
  rig.play_constant(32767);
  rig.tick(50);
  rig.gain(0);
  float last = rig.outputs.motor_command_nm;
  REQUIRE(last == about(0.08));
  for (const float nm : rig.torques(30)) {
    CHECK(std::abs(nm - last) <= 1.01F * 0.08F / 20);
    last = nm;
  }
  CHECK(last == 0.0F);
}

TEST_CASE("a game that is cut off while it blends does not sound in the SDK's scene") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.blend_s = 0.05F; });
  rig.play_constant(32767);
  rig.tick(10);
  REQUIRE(rig.outputs.motor_command_nm > 0.0F);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  for (const float nm : rig.torques(60)) CHECK(nm == 0.0F);
}

TEST_CASE("springs count by their stiffer side, and whichever way they push") {
  struct Sides {
    int positive, negative;
  };
  // The torque of two stiff springs three counts from the middle, on the side that is stiff.
  const auto torque_nm = [](const Sides& sides) {
    GameRig rig;
    rig.configure([](protocol::GameConfig& config) {
      config.range_deg = 10;
      config.spring_gain = 1000;
    });
    GameRig::ConditionOptions options;
    options.positive = sides.positive;
    options.negative = sides.negative;
    rig.play_condition(kSpring, options);
    rig.play_condition(kSpring, options);
    rig.tick(60);
    rig.turn(sides.positive != 0 ? 1 : -1, 3);
    return static_cast<double>(rig.outputs.motor_command_nm);
  };
  const double both = torque_nm({32767, 32767});
  REQUIRE(both < -1e-4);
  REQUIRE(std::abs(both) < 3 * kCountRad * 10);
  CHECK(torque_nm({32767, 0}) == about(both));
  CHECK(torque_nm({0, 32767}) == about(-both));
  CHECK(torque_nm({-32767, 0}) == about(-both));
  CHECK(torque_nm({0, -32767}) == about(both));
}

TEST_CASE("a wave faster than the loop can render still alternates, and one of no period is none") {
  GameRig rig;
  const int block = rig.create(kSquare);
  rig.set_effect(block);
  rig.periodic(block, 32767, 0, 0, 1);  // a wave in each tick
  rig.start(block);
  rig.tick(2);
  double sum = 0;
  for (const float nm : rig.torques(100)) {
    CHECK(std::abs(nm) == about(0.08));
    sum += static_cast<double>(nm);
  }
  CHECK(std::abs(sum) < 0.09);
  rig.periodic(block, 32767, 8192, 0, 0);
  rig.tick(5);
  for (const float nm : rig.torques(10)) CHECK(nm == about(0.02));  // its offset
}

TEST_CASE("what finds the way to the interrupt full comes after it, in its order") {
  for (const bool stops : {true, false}) {
    GameRig rig;
    const int block = rig.play_constant(16384);
    rig.tick(10);
    for (int i = 0; i < 8; ++i) {
      const int other = rig.create(kConstant);
      rig.set_effect(other);
    }
    if (stops) {
      rig.control(3);
    } else {
      rig.gain(0);
    }
    rig.tick(60);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
    if (stops) continue;
    rig.gain(32767);
    rig.constant(block, 32767);
    rig.tick(10);
    CHECK(rig.outputs.motor_command_nm == about(0.08));
  }
}

TEST_CASE("a start that is still on its way when the bus is lost is none when it is back") {
  GameRig rig;
  rig.play_constant(16384);
  rig.play_constant(16384);  // finds no room
  rig.device->set_connected(false);
  rig.device->set_connected(true);
  rig.tick(100);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  // The next start is one again.
  rig.start(1);
  rig.tick(10);
  CHECK(rig.outputs.motor_command_nm == about(0.04));
}

TEST_CASE("a host that comes is told where the axis is, and the state") {
  GameRig rig;
  rig.tick(2);
  REQUIRE(inputs(rig).size() == 2);
  REQUIRE(inputs(rig).empty());
  rig.device->set_connected(false);
  rig.tick(2);
  rig.device->set_connected(true);
  rig.tick(2);
  const auto reports = inputs(rig);
  REQUIRE(reports.size() == 2);
  CHECK(std::min(reports[0][0], reports[1][0]) == 1);
  CHECK(std::max(reports[0][0], reports[1][0]) == 2);
}

TEST_CASE("a button that is held plays once where no repetition is asked for") {
  // An interval of 0 means none (DirectInput), and all ones means without end.
  for (const int repeat_ms : {0, 0xFFFF}) {
    GameRig rig;
    const int block = rig.create(kConstant);
    EffectOptions options;
    options.duration_ms = 10;
    options.trigger = 1;
    options.repeat_ms = repeat_ms;
    rig.set_effect(block, options);
    rig.constant(block, 32767);
    rig.tick(2);
    rig.device->game().set_buttons(1);
    int on = 0;
    for (int i = 0; i < 66'000; ++i) {
      rig.tick();
      if (rig.outputs.motor_command_nm > 0.0F) ++on;
    }
    CHECK(on == 10);
  }
}

TEST_CASE("a button that was let go plays again when it is pressed") {
  GameRig rig;
  const int block = rig.create(kConstant);
  EffectOptions options;
  options.duration_ms = 10;
  options.trigger = 1;
  rig.set_effect(block, options);
  rig.constant(block, 32767);
  rig.tick(2);
  for (int press = 0; press < 3; ++press) {
    rig.device->game().set_buttons(1);
    int on = 0;
    for (int i = 0; i < 50; ++i) {
      rig.tick();
      if (rig.outputs.motor_command_nm > 0.0F) ++on;
    }
    CHECK(on == 10);
    rig.device->game().set_buttons(0);
    rig.tick(50);
  }
}

TEST_CASE("the axis stays at its end however far the knob was turned") {
  for (const std::uint32_t counts_per_rev : {4U, 360U, 8192U, 1U << 24}) {
    device::Config config;
    config.actuator.counts_per_rev = counts_per_rev;
    device::game::PidEngine engine(config, 50'000);
    const auto x = [&](std::int64_t counts) {
      engine.settle(false);  // tells the axis anew
      (void)engine.service({0, counts, 0, protocol::Owner::none});
      std::array<std::uint8_t, 64> report{};
      do {
        REQUIRE(engine.next_input(report) != 0);
      } while (report[0] != 1);
      return static_cast<std::int16_t>(report[1] | (report[2] << 8));
    };
    for (int bit = 30; bit < 63; ++bit) {
      for (const std::int64_t part : {std::int64_t{0}, (std::int64_t{1} << bit) / 2}) {
        const std::int64_t counts = (std::int64_t{1} << bit) + part;
        CAPTURE(counts);
        CHECK(x(counts) == 32767);
        CHECK(x(-counts) == -32767);
      }
    }
    CHECK(x(std::numeric_limits<std::int64_t>::max()) == 32767);
    CHECK(x(std::numeric_limits<std::int64_t>::min()) == -32767);
  }
}

TEST_CASE("no report is written where there is no room for the longest") {
  GameRig rig;
  (void)rig.create(kConstant);
  rig.tick(2);
  std::array<std::uint8_t, 64> report{};
  report.fill(0xEE);
  const auto untouched = report;
  for (const std::size_t room : {0U, 1U, 3U, 31U}) {
    CHECK(rig.device->game().get_feature(0x22, std::span(report).first(room)) == 0);
    CHECK(rig.device->game().next_input(std::span(report).first(room)) == 0);
  }
  CHECK(report == untouched);
  CHECK(rig.device->game().get_feature(0x22, std::span(report).first(32)) == 5);
}

TEST_CASE("the monitor says for half a second how much was asked at most") {
  GameRig rig;
  const int block = rig.play_constant(32767);
  rig.play_constant(32767);
  rig.tick(1100);
  rig.stop(block);
  rig.tick(100);
  CHECK(rig.get<protocol::GameMonitor>().asked_percent == 200);
  rig.tick(1500);
  CHECK(rig.get<protocol::GameMonitor>().asked_percent == 100);
}

TEST_CASE("an operation that does not exist is no update of its effect") {
  GameRig rig;
  const int block = rig.play_constant(1000);
  rig.tick(5);
  const auto before = rig.get<protocol::GameMonitor>();
  REQUIRE(before.effects == 1);
  for (const int operation : {0, 4, 255}) rig.operate(block, operation, 1);
  rig.tick(5);
  CHECK(rig.get<protocol::GameMonitor>().effect[0].updates == before.effect[0].updates);
}

TEST_CASE("a direction out of its range changes nothing") {
  GameRig rig;
  const int block = rig.play_constant(16384);
  rig.tick(10);
  const float before = rig.outputs.motor_command_nm;
  for (const int direction : {32768, 40000, 0xFFFF}) {
    EffectOptions options;
    options.direction = direction;
    rig.set_effect(block, options);
    rig.tick(10);
    CHECK(rig.outputs.motor_command_nm == before);
  }
}

TEST_CASE("the monitor tells that nothing is given in a pause") {
  GameRig rig;
  rig.play_constant(16384);
  rig.tick(5);
  CHECK(rig.get<protocol::GameMonitor>().effect[0].torque != 0);
  rig.control(5);
  rig.tick(5);
  CHECK(rig.get<protocol::GameMonitor>().effect[0].torque == 0);
  CHECK(rig.get<protocol::GameMonitor>().torque == 0);
}
