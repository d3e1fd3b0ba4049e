// A game's effects and the motor's torque: closed forms, written down here.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using doctest::Approx;

namespace {

constexpr double kFull = 0.08;
// Levels are whole numbers of 1/32767, and so are directions.
constexpr double kStep = 2 * kFull / 32767;

double wave(int type, double phase) {
  phase -= std::floor(phase);
  switch (type) {
    case kSquare:
      return phase < 0.5 ? 1 : -1;
    case kSine:
      return std::sin(2 * std::numbers::pi * phase);
    case kTriangle:
      return phase < 0.25 ? 4 * phase : phase < 0.75 ? 2 - 4 * phase : 4 * phase - 4;
    case kSawUp:
      return 2 * phase - 1;
    default:
      return 1 - 2 * phase;
  }
}

/// Compares the torque of each of the next ticks with a function of the tick's number.
template <class Form>
void check_torques(GameRig& rig, int ticks, Form&& expected_nm) {
  for (int i = 0; i < ticks; ++i) {
    CAPTURE(i);
    rig.tick();
    CHECK(static_cast<double>(rig.outputs.motor_command_nm) ==
          Approx(expected_nm(i)).scale(1).epsilon(kStep));
  }
}

EffectOptions lasting(int duration_ms) {
  EffectOptions options;
  options.duration_ms = duration_ms;
  return options;
}

}  // namespace

TEST_CASE("a constant force begins after its delay and ends after its duration, to the tick") {
  for (const std::uint32_t period_ns : {1'000'000U, 100'000U}) {
    GameRig rig(period_ns);
    const int per_ms = static_cast<int>(1'000'000 / period_ns);
    EffectOptions options = lasting(11);
    options.delay_ms = 7;
    rig.play_constant(16384, options);
    check_torques(rig, 25 * per_ms, [&](int i) {
      return i >= 7 * per_ms && i < 18 * per_ms ? kFull * 16384 / 32767 : 0.0;
    });
  }
}

TEST_CASE("a direction is where the force comes from; one axis takes its share") {
  struct Case {
    int enable;
    int degrees;
    double share;
  };
  for (const Case& c :
       {Case{2, 90, -1}, Case{2, 270, 1}, Case{2, 0, 0}, Case{2, 180, 0}, Case{2, 30, -0.5},
        Case{2, 225, std::sqrt(0.5)},
        // Axis named and no direction given: as from the right.
        Case{1, 0, -1}, Case{1, 270, -1}, Case{3, 0, -1}, Case{3, 270, 1}, Case{0, 0, -1}}) {
    GameRig rig;
    EffectOptions options;
    options.enable = c.enable;
    options.direction = static_cast<int>(std::lround(c.degrees / 360.0 * 32767));
    rig.play_constant(32767, options);
    rig.tick(3);
    CHECK(static_cast<double>(rig.outputs.motor_command_nm) ==
          Approx(c.share * kFull).scale(1).epsilon(2e-4 * kFull));
  }
}

TEST_CASE("a vibration that comes from nowhere shakes the knob, as Linux's rumble does") {
  GameRig rig;
  const int block = rig.create(kSine);
  EffectOptions options;
  options.direction = 0;
  rig.set_effect(block, options);
  rig.periodic(block, 20000, 0, 0, 40);
  rig.start(block);
  check_torques(rig, 200, [](int i) { return -kFull * 20000 / 32767 * wave(kSine, i / 40.0); });
}

TEST_CASE("a ramp goes from start to end over its duration") {
  GameRig rig;
  const int block = rig.create(kRamp);
  rig.set_effect(block, lasting(200));
  rig.ramp(block, -32767, 16384);
  rig.start(block);
  check_torques(rig, 210, [](int i) { return i < 200 ? kFull * (-1 + 1.5 * i / 200.0) : 0.0; });
}

TEST_CASE("the periodic forces have their shape, amplitude, offset, phase and period") {
  for (const int type : {kSquare, kSine, kTriangle, kSawUp, kSawDown}) {
    GameRig rig(100'000);
    const int block = rig.create(type);
    rig.set_effect(block);
    rig.periodic(block, 20000, -5000, 8192, 50);  // a quarter of a turn ahead
    rig.start(block);
    const auto nm = rig.torques(2000);
    for (int i = 0; i < 2000; ++i) {
      const double phase = 8192.0 / 32767 + i / 500.0;
      const double turn = phase - std::floor(phase);
      // Within a tick of an edge it may be on either side.
      const double edge = type == kSquare ? std::min({turn, std::abs(turn - 0.5), 1 - turn})
                                          : std::min(turn, 1 - turn);
      if (type != kSine && type != kTriangle && edge < 2e-3) continue;
      const double expected = kFull * (20000 * wave(type, phase) - 5000) / 32767;
      CHECK(static_cast<double>(nm[static_cast<std::size_t>(i)]) ==
            Approx(expected).scale(1).epsilon(kStep));
    }
  }
}

TEST_CASE("attack and fade are lines from their levels to the peak") {
  GameRig rig;
  const int block = rig.create(kConstant);
  rig.set_effect(block, lasting(100));
  rig.constant(block, -20000);
  rig.envelope(block, 5000, 40, 30000, 20);
  rig.start(block);
  check_torques(rig, 100, [](int i) {
    double level = 20000;
    if (i < 40) level = 5000 + 15000 * i / 40.0;
    if (100 - i < 20) level = 30000 - 10000 * (100 - i) / 20.0;
    return -kFull * level / 32767;
  });
}

TEST_CASE("attack and fade that overlap leave no jump, and an envelope needs no order") {
  GameRig rig;
  const int block = rig.create(kConstant);
  rig.envelope(block, 0, 80, 0, 80);
  rig.constant(block, 32767);
  rig.set_effect(block, lasting(100));
  rig.start(block);
  const auto nm = rig.torques(101);
  for (std::size_t i = 1; i < 101; ++i) {
    CHECK(std::abs(nm[i] - nm[i - 1]) < 1.05 * kFull / 80);
    CHECK(nm[i] >= 0.0F);
  }
}

TEST_CASE("the envelope of a wave shapes its amplitude but not its offset") {
  GameRig rig;
  const int block = rig.create(kSquare);
  rig.set_effect(block, lasting(100));
  rig.periodic(block, 10000, 10000, 0, 20);
  rig.envelope(block, 0, 100, 32767, 0);
  rig.start(block);
  check_torques(rig, 100, [](int i) {
    const double sign = i / 10 % 2 == 0 ? 1 : -1;
    return kFull * (10000 + sign * 10000 * i / 100.0) / 32767;
  });
}

TEST_CASE("loops repeat the effect with its envelope; the delay comes once") {
  GameRig rig;
  const int block = rig.create(kRamp);
  EffectOptions options = lasting(20);
  options.delay_ms = 5;
  rig.set_effect(block, options);
  rig.ramp(block, 0, 32767);
  rig.start(block, 3);
  check_torques(rig, 80,
                [](int i) { return i >= 5 && i < 65 ? kFull * ((i - 5) % 20) / 20.0 : 0.0; });
}

TEST_CASE("a loop count of 255 has no end") {
  GameRig rig;
  const int block = rig.create(kConstant);
  rig.set_effect(block, lasting(3));
  rig.constant(block, 32767);
  rig.start(block, 255);
  rig.tick(3 * 600);
  CHECK(rig.outputs.motor_command_nm == Approx(kFull));
}

TEST_CASE("effect gain, device gain and the user's gain multiply; the cap holds the sum") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.gain = 0.5F; });
  EffectOptions options;
  options.gain = 16384;
  rig.play_constant(32767, options);
  rig.gain(8192);
  rig.tick(3);
  CHECK(rig.outputs.motor_command_nm == about(kFull / 16));

  GameRig full;
  for (int i = 0; i < 3; ++i) full.play_constant(32767);
  full.tick(3);
  CHECK(full.outputs.motor_command_nm == Approx(kFull));
}

TEST_CASE("updates in every millisecond are joined by lines, whatever the tick rate") {
  for (const std::uint32_t period_ns : {1'000'000U, 100'000U, 50'000U}) {
    GameRig rig(period_ns);
    rig.configure([](protocol::GameConfig& config) { config.blend_s = 1e-3F; });
    const int per_ms = static_cast<int>(1'000'000 / period_ns);
    const int block = rig.play_constant(0);
    rig.tick(2 * per_ms);
    float last = 0;
    for (int ms = 1; ms <= 100; ++ms) {
      rig.constant(block, static_cast<int>(30000 * std::sin(ms / 16.0)));
      for (int i = 0; i < per_ms; ++i) {
        rig.tick();
        // The steepest slope of the sine, spread over the ticks of a millisecond.
        CHECK(std::abs(rig.outputs.motor_command_nm - last) <
              1.1 * kFull * 30000 / 32767 / 16 / per_ms + 1e-6);
        last = rig.outputs.motor_command_nm;
      }
      CHECK(static_cast<double>(last) ==
            Approx(kFull * 30000 / 32767 * std::sin(ms / 16.0)).scale(1).epsilon(1e-4));
    }
  }
}

TEST_CASE("a paused device is silent, and effects go on where they were") {
  GameRig rig;
  const int block = rig.create(kRamp);
  rig.set_effect(block, lasting(100));
  rig.ramp(block, 0, 32767);
  rig.start(block);
  rig.tick(41);
  const float before = rig.outputs.motor_command_nm;
  CHECK(before == Approx(kFull * 0.4));
  rig.control(5);
  rig.tick(300);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.control(6);
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == about(kFull * 0.41, 0.03));
  rig.tick(62);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("a spring answers to offset, dead band, each side's coefficient and saturation") {
  GameRig rig;
  // Half the axis is 1 rad; weak, so that the limit of stability is far away.
  rig.configure([](protocol::GameConfig& config) {
    config.range_deg = 114.59156F;
    config.spring_gain = 1;
  });
  const int block = rig.create(kSpring);
  rig.set_effect(block);
  GameRig::ConditionOptions options;
  options.offset = 6553;     // 0.2 rad
  options.dead_band = 3277;  // 0.1 rad
  options.positive = 32767;
  options.negative = 16384;
  options.positive_saturation = 9830;  // 0.3
  options.negative_saturation = 32767;
  rig.condition(block, options);
  options.parameter_block = 1;  // no such axis
  options.positive = -32767;
  rig.condition(block, options);
  rig.start(block);
  rig.tick(2);
  for (int counts = -1300; counts <= 1300; counts += 50) {
    // A little at a time: a jump is a broken encoder.
    while (rig.inputs.encoder_count != static_cast<std::uint32_t>(counts)) {
      const auto now = static_cast<std::int32_t>(rig.inputs.encoder_count);
      rig.inputs.encoder_count = static_cast<std::uint32_t>(now < counts ? now + 10 : now - 10);
      rig.tick();
    }
    rig.tick(2);
    const double angle = counts * 2 * std::numbers::pi / 8192;
    const double beyond = angle - 0.2;
    double expected = 0;
    if (beyond > 0.1) expected = -std::min(beyond - 0.1, 0.3) * kFull;
    if (beyond < -0.1) expected = std::min(-(beyond + 0.1) * 0.5, 1.0) * kFull;
    CHECK(static_cast<double>(rig.outputs.motor_command_nm) ==
          Approx(expected).scale(1).epsilon(2e-5));
  }
}

TEST_CASE("a damper resists in proportion to speed, and a negative one does nothing") {
  for (const int coefficient : {32767, -32767}) {
    GameRig rig;
    rig.configure([](protocol::GameConfig& config) { config.speed_full_rad_s = 40; });
    GameRig::ConditionOptions options;
    options.positive = coefficient;
    options.negative = coefficient;
    rig.play_condition(kDamper, options);
    rig.turn(13, 300);
    const double speed = 13 * 2 * std::numbers::pi / 8192 / 1e-3;
    if (coefficient > 0) {
      CHECK(rig.outputs.motor_command_nm == about(-kFull * speed / 40));
    } else {
      CHECK(rig.outputs.motor_command_nm == 0.0F);
    }
  }
}

TEST_CASE("an inertia resists in proportion to acceleration") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.acceleration_full_rad_s2 = 1e4F; });
  rig.play_condition(kInertia, {});
  double count = 0;
  double mean = 0;
  for (int i = 0; i < 400; ++i) {
    count += 0.25 * i;  // counts per tick, growing by a quarter in each
    rig.inputs.encoder_count = static_cast<std::uint32_t>(std::lround(count));
    rig.tick();
    if (i >= 200) mean += static_cast<double>(rig.outputs.motor_command_nm) / 200;
  }
  const double acceleration = 0.25 * 2 * std::numbers::pi / 8192 / 1e-6;
  CHECK(mean == about(-kFull * acceleration / 1e4, 0.01));
}

TEST_CASE("a friction holds its torque at any speed and turns with the direction") {
  GameRig rig;
  GameRig::ConditionOptions options;
  options.positive = 8192;
  options.negative = 4096;
  rig.play_condition(kFriction, options);
  for (const int step : {3, 30, -3, -30}) {
    rig.turn(step, 600);
    CHECK(rig.outputs.motor_command_nm == about(step > 0 ? -kFull / 4 : kFull / 8));
  }
}

TEST_CASE("a friction's offset is a surface that moves, and its dead band lets slow motion go") {
  GameRig moving;
  GameRig::ConditionOptions options;
  options.offset = 1638;  // 1 rad/s
  options.negative = 8192;
  moving.play_condition(kFriction, options);
  moving.tick(1000);
  CHECK(moving.outputs.motor_command_nm == about(kFull / 4));

  GameRig loose;
  options = {};
  options.positive = 8192;
  options.dead_band = 16384;  // 10 rad/s
  loose.play_condition(kFriction, options);
  loose.turn(6, 600);  // 4.6 rad/s
  CHECK(loose.outputs.motor_command_nm == 0.0F);
  loose.turn(30, 600);
  CHECK(loose.outputs.motor_command_nm == about(-kFull / 4));

  GameRig both;
  options.negative = 8192;
  options.offset = 24575;  // 15 rad/s: a knob at rest is too slow by more than the dead band
  both.play_condition(kFriction, options);
  both.tick(100);
  CHECK(both.outputs.motor_command_nm == about(kFull / 4));
}

TEST_CASE("a button starts what it triggers, and again while it is held") {
  GameRig rig;
  const int block = rig.create(kConstant);
  EffectOptions options;
  options.duration_ms = 10;
  options.trigger = 2;
  options.repeat_ms = 30;
  rig.set_effect(block, options);
  rig.constant(block, 32767);
  rig.tick(5);
  rig.device->game().set_buttons(1);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.device->game().set_buttons(2);
  int on = 0;
  for (int i = 0; i < 90; ++i) {
    rig.tick();
    if (rig.outputs.motor_command_nm > 0.0F) ++on;
  }
  CHECK(on == 30);
  rig.device->game().set_buttons(0);
  rig.tick(60);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}
