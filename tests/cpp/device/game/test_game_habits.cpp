// Habits of games and drivers that the standard does not foresee, each with its source,
// against what must be felt. "hid-pidff" is Linux's drivers/hid/usbhid/hid-pidff.c.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using doctest::Approx;

namespace {

double share(const GameRig& rig) {
  return static_cast<double>(rig.outputs.motor_command_nm) / static_cast<double>(GameRig::kFullNm);
}

constexpr double kShareStep = 2.0 / 32767;

void narrow(protocol::GameConfig& config) { config.range_deg = 90; }

/// What a spring gives at so many counts in each of 300 ticks, to either side.
std::array<double, 2> sides(GameRig& rig, const GameRig::ConditionOptions& options,
                            int counts = 10) {
  const int block = rig.play_condition(kSpring, options);
  rig.condition(block, {.positive = 1, .parameter_block = 1});  // no such axis
  rig.tick(600);                                                // springs come up in 50 ms
  std::array<double, 2> found{};
  for (double& side : found) {
    rig.turn(counts, 300);
    side = share(rig) * 32767;
    rig.turn(-counts, 300);
    counts = -counts;
  }
  rig.free(block);
  rig.tick(60);
  return found;
}

std::array<double, 2> saturations(GameRig& rig, int positive, int negative) {
  return sides(rig, {.positive_saturation = positive, .negative_saturation = negative});
}

}  // namespace

TEST_CASE(
    "habit: an endless constant force, updated thousands of times a second: the newest wins") {
  // Assetto Corsa on the grid (github.com/berarma/new-lg4ff, issue 40), ETS2 (Kimplul/hid-tmff2,
  // issue 10): queues of hundreds of stale forces in other devices and drivers.
  GameRig rig;
  const int block = rig.play_constant(0);
  for (int ms = 0; ms < 2000; ++ms) {
    for (int n = 0; n < 8; ++n) rig.constant(block, ms * 8 + n);
    rig.tick();
    // One tick, and a line from the last update to this one.
    CHECK(share(rig) * 32767 >= ms * 8 - 17);
  }
  rig.constant(block, 100);
  rig.tick(3);
  CHECK(share(rig) == Approx(100.0 / 32767).scale(1).epsilon(kShareStep));
}

TEST_CASE("habit: a wave is uploaded and played in each frame") {
  // SDL_HapticRumblePlay's effect is a sine of a second; begun anew in each frame it is hardly
  // felt.
  for (const int period_ms : {1000, 100, 40}) {
    CAPTURE(period_ms);
    GameRig rig(100'000);
    const int block = rig.create(kSine);
    EffectOptions options;
    options.duration_ms = 5000;
    const auto play = [&] {
      rig.set_effect(block, options);
      rig.periodic(block, 16384, 0, 0, period_ms);
      rig.start(block);
    };
    const double step = 2 * 3.14159265358979 / (10.0 * period_ms);
    int ticks = 0;
    for (int frame = 0; frame < 120; ++frame) {
      play();
      for (const float nm : rig.torques(167)) {
        const double expected = 0.04 * std::sin(step * ticks++);
        CHECK(static_cast<double>(nm) == Approx(expected).scale(0.04).epsilon(0.02));
      }
    }
    // One that changes its period from frame to frame goes on from where it is.
    double phase = step * (ticks - 1);
    rig.periodic(block, 16384, 0, 0, 2 * period_ms);
    rig.start(block);
    for (const float nm : rig.torques(100)) {
      phase += step / 2;
      CHECK(static_cast<double>(nm) == Approx(0.04 * std::sin(phase)).scale(0.04).epsilon(0.03));
    }
    rig.periodic(block, 16384, 0, 0, period_ms);
    rig.tick(1000);  // for longer than a frame: who starts it now wants its beginning
    play();
    CHECK(rig.torques(2)[1] == Approx(0.04 * step).scale(0.04).epsilon(0.02));
    rig.tick(1000);
    options.delay_ms = 20;
    play();
    rig.tick(100);
    play();  // before it is heard
    CHECK(rig.torques(202)[201] == Approx(0.04 * step).scale(0.04).epsilon(0.02));
  }
}

TEST_CASE("habit: a ramp with equal ends is a constant force, with an end or without") {
  // Allowed by DirectInput (DIRAMPFORCE) and evdev; no report that names a game was found.
  for (const int length_ms : {int{kWithoutEnd}, 500}) {
    GameRig rig;
    EffectOptions options;
    options.duration_ms = length_ms;
    const int block = rig.create(kRamp);
    rig.set_effect(block, options);
    rig.ramp(block, -9000, -9000);
    rig.start(block);
    rig.tick(300);
    CHECK(share(rig) == Approx(-9000 / 32767.0).scale(1).epsilon(kShareStep));
    rig.ramp(block, 9000, 9000);
    rig.tick(45);
    CHECK(share(rig) == Approx(9000 / 32767.0).scale(1).epsilon(kShareStep));
  }
}

TEST_CASE("habit: created once and played for an hour") {
  // For DIEFFECT's duration of INFINITE and SDL_HAPTIC_INFINITY; no report that names a
  // game was found. An update, once a second here, is a sign of life.
  GameRig rig;
  const int constant = rig.play_constant(8000);
  const int wave = rig.create(kSquare);
  rig.set_effect(wave);
  rig.periodic(wave, 4000, 0, 0, 1000);
  rig.start(wave);
  for (int second = 0; second < 3600; ++second) {
    rig.constant(constant, 8000);
    rig.tick(1000);
  }
  rig.tick(250);  // a wave of a second is in its first half, and high
  CHECK(share(rig) == Approx(12000 / 32767.0).scale(0).epsilon(1e-3));
  rig.tick(500);
  CHECK(share(rig) == Approx(4000 / 32767.0).scale(0).epsilon(1e-3));
}

TEST_CASE("habit: reset twice, stop all, actuators on, whenever no effect is left") {
  // hid-pidff from 6.15 on: whenever the count of effects is 0.
  GameRig rig;
  for (int round = 0; round < 5; ++round) {
    for (const int what : {4, 4, 3, 1}) rig.control(what);
    rig.gain(32767);
    const int block = rig.play_constant(20000);
    CHECK(block == 1);
    rig.tick(60);
    CHECK(share(rig) == Approx(20000 / 32767.0).scale(0).epsilon(1e-3));
    rig.stop(block);
    rig.free(block);
    rig.tick(60);
    CHECK(share(rig) == 0.0);
  }
}

TEST_CASE("habit: the negative saturation comes as a signed number, full as 0") {
  // hid-pidff of Linux 7.2 and 7.3, pidff_set_condition_report: right_saturation goes through
  // pidff_set, left_saturation through pidff_set_signed, both are 16 bits without sign.
  const auto right = [](std::int64_t asked) { return static_cast<int>(asked * 32767 / 0xFFFF); };
  const auto left = [](std::uint16_t asked) {
    const std::int64_t number = static_cast<std::int16_t>(asked);
    return static_cast<int>(number < 0 ? -number * 32767 / 0x8000 : number * 32767 / 0x7FFF);
  };
  GameRig linux_7(100'000);
  linux_7.configure(narrow);
  for (const int asked : {0, 1, 2, 600, 0x3FFF, 0x7FFE, 0x7FFF, 0x8000, 0x8001, 0xC000, 0xFFFF}) {
    for (const int what : {4, 4, 3, 1}) linux_7.control(what);
    const int meant = right(asked);
    const auto [plus, minus] = saturations(linux_7, meant, left(static_cast<std::uint16_t>(asked)));
    CHECK(std::abs(plus + meant) < 1);
    CHECK(std::abs(minus - meant) < 1);
  }
  // Two sides that differ are as they come, and so is everything of other hosts.
  for (const int what : {4, 4, 3, 1}) linux_7.control(what);
  CHECK(std::abs(saturations(linux_7, 32767, 8000)[1] - 8000) < 1);
  GameRig other(100'000);
  other.configure(narrow);
  for (const std::vector<int>& begin :
       {std::vector<int>{}, {4}, {4, 4}, {4, 4, 3}, {4, 3, 1}, {4, 4, 3, 1, 4}}) {
    for (const int what : begin) other.control(what);
    CHECK(std::abs(saturations(other, 32767, 0)[1]) < 1);
  }
  for (const int what : {4, 4}) other.control(what);
  other.gain(32767);
  for (const int what : {3, 1}) other.control(what);
  CHECK(std::abs(saturations(other, 32767, 0)[1]) < 1);
}

TEST_CASE("habit: fields that a driver takes for missing stay 0") {
  // hid-pidff of 2026 skips negative coefficient, negative saturation and dead band
  // (JacKeTUs/universal-pidff, pull request 115), else the sides are alike.
  for (int missing = 0; missing < 8; ++missing) {
    CAPTURE(missing);
    GameRig rig(100'000);
    rig.configure([](protocol::GameConfig& config) {
      narrow(config);
      config.spring_gain = 1;
    });
    const GameRig::ConditionOptions sent{.positive = 16384,
                                         .negative = (missing & 1) != 0 ? 0 : 16384,
                                         .positive_saturation = 6000,
                                         .negative_saturation = (missing & 2) != 0 ? 0 : 6000,
                                         .dead_band = (missing & 4) != 0 ? 0 : 2000};
    for (const int counts : {1, 10}) {
      const double half_range_rad = std::numbers::pi / 4;
      const double beyond = 300 * counts * kCountRad / half_range_rad * 32767 - sent.dead_band;
      const auto [plus, minus] = sides(rig, sent, counts);
      CHECK(std::abs(plus + std::min(beyond / 2, 6000.0)) < 1);
      CHECK(std::abs(minus - ((missing & 3) != 0 ? 0 : std::min(beyond / 2, 6000.0))) < 1);
    }
  }
}

TEST_CASE("habit: the device gain is set before the first effect is made") {
  // fftest and SDL_SetHapticGain do so, and hid-pidff from 6.15 on resets behind it.
  GameRig rig;
  rig.gain(16384);
  for (int round = 0; round < 2; ++round) {
    for (const int what : {4, 4, 3, 1}) rig.control(what);
    const int block = rig.play_constant(20000);
    rig.tick(60);
    CHECK(share(rig) == Approx(0.5 * 20000 / 32767.0).epsilon(1e-3));
    rig.free(block);
    rig.tick(60);
  }
}

TEST_CASE("habit: without end as 0 and as all ones") {
  // hid-pidff: 0 in 6.1, all ones of the field from 6.15 on.
  for (const int length_ms : {0, 0xFFFF}) {
    GameRig rig;
    EffectOptions options;
    options.duration_ms = length_ms;
    const int block = rig.play_constant(20000, options);
    for (int second = 0; second < 70; ++second) {
      rig.gain(32767);
      rig.tick(1000);
    }
    CHECK(share(rig) == Approx(20000 / 32767.0).scale(0).epsilon(1e-3));
    rig.stop(block);
    rig.tick(3);
    CHECK(share(rig) == 0.0);
  }
}

TEST_CASE("habit: a menu silences the device for minutes, and the game goes on") {
  // DIPROP_FFGAIN and evdev's FF_GAIN; DISFFC_PAUSE; DISFFC_SETACTUATORSOFF, with which "effects
  // continue to play but are ignored".
  using Say = void (*)(GameRig&, bool);
  const std::pair<Say, bool> menus[] = {
      {[](GameRig& rig, bool begins) { rig.gain(begins ? 0 : 32767); }, true},
      {[](GameRig& rig, bool begins) { rig.control(begins ? 5 : 6); }, true},
      {[](GameRig& rig, bool begins) { rig.control(begins ? 2 : 1); }, false},
  };
  for (const auto& [say, keeps] : menus) {
    GameRig rig;
    rig.play_constant(20000);
    rig.tick(5);
    say(rig, true);
    rig.tick(120'000);
    CHECK(share(rig) == 0.0);
    CHECK(rig.owner() == (keeps ? protocol::Owner::game : protocol::Owner::none));
    say(rig, false);
    rig.tick(5);
    CHECK(share(rig) == Approx(20000 / 32767.0).scale(0).epsilon(1e-3));
    // A program that hangs behind its menu has its force for as long as any other.
    rig.tick(9900);
    CHECK(share(rig) == Approx(20000 / 32767.0).scale(0).epsilon(1e-3));
    rig.tick(200);
    CHECK(share(rig) == 0.0);
  }
}

TEST_CASE("habit: an endless effect is updated and never started again") {
  // hid-pidff from 6.15 on sends no start with an update. PCSX2 and BeamNG work round devices that
  // time out meanwhile (PCSX2/pcsx2, pull requests 11906 and 11915).
  GameRig rig;
  const int block = rig.play_constant(20000);
  rig.tick(12'000);  // stands still in a menu, for longer than the device waits
  CHECK(share(rig) == 0.0);
  int lost = 0;
  for (int n = 0; n < 300; ++n) {
    const int level = 10000 + 10 * n;
    rig.constant(block, level);
    rig.tick(1);
    lost += share(rig) > 0.2 ? 0 : 1;
    rig.tick(15);
  }
  CHECK(lost == 0);
}

TEST_CASE("habit: only what has changed is sent, in one report, in the other, or in both") {
  // SDL's DirectInput code of 2026 names what has changed (DIEP_TYPESPECIFICPARAMS, DIEP_GAIN ...).
  using Say = void (*)(GameRig&, int, bool);
  struct Kind {
    int type;
    Say specific;
    double before;  // share of full torque at the angle below, with all of the effect's gain
    double after;
  };
  const Kind kinds[] = {
      {kConstant, [](GameRig& r, int b, bool after) { r.constant(b, after ? -20000 : 10000); },
       10000, -20000},
      {kRamp,
       [](GameRig& r, int b, bool after) {
         r.ramp(b, after ? 9000 : -12000, after ? 9000 : -12000);
       },
       -12000, 9000},
      {kSquare, [](GameRig& r, int b, bool after) { r.periodic(b, 0, after ? 6000 : 15000, 0, 9); },
       15000, 6000},
      {kSpring,
       [](GameRig& r, int b, bool after) {
         r.condition(b, {.positive = after ? 8000 : 16000});
         if (!after) r.condition(b, {.positive = 1, .parameter_block = 1});  // no such axis
       },
       -16000, -8000},
  };
  for (const Kind& kind : kinds) {
    for (int order = 0; order < 3; ++order) {
      CAPTURE(kind.type);
      CAPTURE(order);
      GameRig rig;
      rig.configure([](protocol::GameConfig& config) {
        config.range_deg = 90;
        config.spring_gain = 1;
        config.join_updates = protocol::Toggle::off;
      });
      const int block = rig.create(kind.type);
      rig.set_effect(block);
      kind.specific(rig, block, false);
      rig.start(block);
      rig.turn(8, 128);  // 45 degrees: all of a spring with a whole coefficient
      CHECK(share(rig) * 32767 == Approx(kind.before).epsilon(1e-3));
      const auto set_gain = [&] { rig.set_effect(block, {.gain = 16384}); };
      if (order == 1) kind.specific(rig, block, true);
      if (order != 1) set_gain();
      rig.tick(60);
      CHECK(share(rig) * 32767 == Approx(order == 1 ? kind.after : kind.before / 2).epsilon(1e-3));
      if (order == 1) set_gain();
      if (order != 1) kind.specific(rig, block, true);
      if (order == 2) set_gain();  // and once more, as it is
      rig.tick(60);
      CHECK(share(rig) * 32767 == Approx(kind.after / 2).epsilon(1e-3));
    }
  }
}
