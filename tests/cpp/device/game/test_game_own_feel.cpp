// The player's own feel, gains for each kind of effect, and a knob that goes the other way, each
// against the closed forms of docs/reference/games.md.
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using protocol::Owner;

namespace {

// The limits of stability do not reach there at 10 kHz.
constexpr std::uint32_t kFeelPeriodNs = 100'000;
constexpr double kFeelSpeedRadS = kCountRad * 1e4;  // a count in each tick

int axis(GameRig& rig) {
  std::array<std::uint8_t, 64> report{};
  REQUIRE(rig.device->game().get_input(1, report) == 6);
  return static_cast<std::int16_t>(report[1] | (report[2] << 8));
}

}  // namespace

TEST_CASE("own damper and friction are felt without a game, while the knob is turned") {
  GameRig rig(kFeelPeriodNs);
  rig.configure([](protocol::GameConfig& config) {
    config.own_damper_percent = 50;
    config.own_friction_percent = 20;
  });
  rig.tick(2000);
  CHECK(rig.state() == protocol::State::disarmed);
  for (const int way : {1, -1}) {
    rig.turn(way, 3000);  // past the soft start
    CHECK(rig.owner() == Owner::game);
    const double nm = -way * (0.5 * kFeelSpeedRadS / 20 + 0.2) * GameRig::kFullNm;
    CHECK(rig.outputs.motor_command_nm == about(nm, 0.02));
  }
  // A second after the last turn, and after the second that a game may pause.
  rig.tick(19'000);
  CHECK(rig.owner() == Owner::game);
  rig.tick(2500);
  CHECK(rig.owner() == Owner::none);
  CHECK_FALSE(rig.outputs.enabled);
}

TEST_CASE("own feel comes up along a line, takes nothing from the SDK and needs a host") {
  GameRig rig(kFeelPeriodNs);
  rig.configure([](protocol::GameConfig& config) { config.own_friction_percent = 100; });
  float last = 0;
  for (int i = 0; i < 1000; ++i) {
    rig.turn(1, 1);
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.2F * GameRig::kFullNm / 500 + 2e-4F);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(last == about(-GameRig::kFullNm, 0.01));
  REQUIRE(rig.command(protocol::Op::arm) == protocol::Status::ok);
  rig.turn(1, 1000);
  CHECK(rig.owner() == Owner::sdk);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  REQUIRE(rig.device->receive(protocol::encode(protocol::Command{9, 0, protocol::Op::disarm})));
  rig.tick(100);
  CHECK(rig.state() == protocol::State::disarmed);  // until it is turned again
  rig.turn(1, 10);
  CHECK(rig.owner() == Owner::game);
  REQUIRE(rig.device->receive(protocol::encode(protocol::Command{9, 0, protocol::Op::disarm})));
  rig.tick(100);
  CHECK(rig.state() == protocol::State::disarmed);
  rig.device->set_connected(false);
  rig.turn(1, 1000);
  CHECK(rig.state() == protocol::State::disarmed);
  rig.device->set_connected(true);
  rig.configure([](protocol::GameConfig& config) {
    config.own_friction_percent = 100;
    config.enabled = protocol::Toggle::off;
  });
  rig.turn(1, 1000);
  CHECK(rig.state() == protocol::State::disarmed);
}

TEST_CASE("zeroing the knob is no turn") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.own_friction_percent = 100; });
  rig.turn(1, 300);
  rig.tick(2200);
  REQUIRE(rig.command(protocol::Op::zero) == protocol::Status::ok);
  rig.tick(10);
  CHECK(rig.state() == protocol::State::disarmed);
}

TEST_CASE("own spring centres while no game plays, for as long as it is stronger than friction") {
  GameRig rig(kFeelPeriodNs);
  rig.configure([](protocol::GameConfig& config) {
    config.own_spring_percent = 40;
    config.spring_gain = 4;
  });
  rig.turn(1, 1000);
  rig.tick(30'000);  // held there
  const double nm = -1.6 * GameRig::kFullNm * 1000 * kCountRad / (450 * std::numbers::pi / 180);
  CHECK(rig.outputs.motor_command_nm == about(nm));
  // A game that plays has it alone; behind it the spring is back.
  const int block = rig.play_constant(0);
  rig.tick(1000);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.stop(block);
  rig.tick(1);
  CHECK(std::abs(rig.outputs.motor_command_nm) < 0.01 * std::abs(nm));  // not at once
  rig.tick(1000);
  CHECK(rig.outputs.motor_command_nm == about(nm));
  // Friction, 6 mN m, holds it at 300 counts without a motor.
  rig.turn(-1, 700);
  rig.tick(21'500);
  CHECK(rig.owner() == Owner::none);
}

TEST_CASE("own damper is felt under a game, whose gain and pause leave it") {
  GameRig rig(kFeelPeriodNs);
  rig.configure([](protocol::GameConfig& config) { config.own_damper_percent = 50; });
  (void)rig.play_constant(16384);
  rig.turn(1, 3000);
  const double damper_nm = -0.5 * kFeelSpeedRadS / 20 * GameRig::kFullNm;
  CHECK(rig.outputs.motor_command_nm == about(0.5 * GameRig::kFullNm + damper_nm, 0.02));
  rig.gain(0);
  rig.turn(1, 1000);
  CHECK(rig.outputs.motor_command_nm == about(damper_nm, 0.02));
  rig.gain(32767);
  rig.control(5);  // pause
  rig.turn(1, 1000);
  CHECK(rig.outputs.motor_command_nm == about(damper_nm, 0.02));
}

TEST_CASE("each kind of effect has a gain of the player's, and the cap may be a share") {
  using Change = void (*)(protocol::GameConfig&);
  const auto felt = [](int type, Change change) {
    GameRig rig(kFeelPeriodNs);
    rig.configure([change](protocol::GameConfig& config) {
      config.spring_gain = 1;
      config.range_deg = 90;
      change(config);
    });
    const int block = rig.create(type);
    rig.set_effect(block);
    rig.constant(block, 16384);
    rig.ramp(block, 16384, 16384);
    rig.periodic(block, 16384, 0, 0, 30'000);
    rig.condition(block, {.positive = 16384});
    rig.start(block);
    rig.tick(3000);                  // past the soft start
    for (int i = 1; i < 300; ++i) {  // 1,000 rad/s^2
      rig.inputs.encoder_count = static_cast<std::uint32_t>(i * i / 150);
      rig.tick();
    }
    return static_cast<double>(rig.outputs.motor_command_nm);
  };
  const std::pair<int, Change> kinds[] = {
      {kConstant, [](protocol::GameConfig& c) { c.constants_gain_percent = 30; }},
      {kRamp, [](protocol::GameConfig& c) { c.constants_gain_percent = 30; }},
      {kSquare, [](protocol::GameConfig& c) { c.waves_gain_percent = 30; }},
      {kSpring, [](protocol::GameConfig& c) { c.springs_gain_percent = 30; }},
      {kDamper, [](protocol::GameConfig& c) { c.dampers_gain_percent = 30; }},
      {kInertia, [](protocol::GameConfig& c) { c.inertias_gain_percent = 30; }},
      {kFriction, [](protocol::GameConfig& c) { c.frictions_gain_percent = 30; }},
  };
  for (const auto& [type, change] : kinds) {
    CAPTURE(type);
    const double whole = felt(type, [](protocol::GameConfig&) {});
    CHECK(std::abs(whole) > 0.01);
    CHECK(felt(type, change) == about(0.3 * whole, 0.02));
  }
  // 0.085 N m is what the motor has.
  CHECK(felt(kConstant, [](protocol::GameConfig& c) { c.torque_max_percent = 40; }) ==
        about(0.5 * 0.4 * 0.085));
}

TEST_CASE("reversed, the axis and every force go the other way, and a spring still centres") {
  const auto felt = [](bool is_reversed, int type, int counts) {
    GameRig rig(kFeelPeriodNs);
    rig.configure([is_reversed](protocol::GameConfig& config) {
      config.spring_gain = 1;
      config.reversed = is_reversed ? protocol::Toggle::on : protocol::Toggle::off;
    });
    if (type == kConstant) {
      (void)rig.play_constant(12000);
    } else {
      const GameRig::ConditionOptions lopsided{
          .offset = 300, .positive = 20000, .negative = 5000, .negative_saturation = 9000};
      (void)rig.play_condition(type, lopsided);
    }
    rig.turn(counts, 3000);
    return std::pair{axis(rig), static_cast<double>(rig.outputs.motor_command_nm)};
  };
  for (const int type : {kConstant, kSpring, kDamper, kFriction}) {
    for (const int counts : {1, -1}) {
      CAPTURE(type);
      const auto [x, nm] = felt(false, type, counts);
      const auto [mirrored_x, mirrored_nm] = felt(true, type, -counts);
      CHECK(x == mirrored_x);
      CHECK(std::abs(x) > 1000);
      CHECK(std::abs(nm) > 1e-4);
      CHECK(mirrored_nm == about(-nm));
    }
  }
}
