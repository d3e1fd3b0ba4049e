// Between a game's updates: lines instead of steps, half a frame late, never beyond; hits pass. And
// taking the actuator: nothing moves, and a spring comes up gently.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;
using doctest::Approx;

namespace {

constexpr int kTicksPerMs = 10;

/// Reports of an update, each in its own frame of the bus.
enum class Part : std::uint8_t { level, effect, envelope, start };

/// A constant force at 10 kHz, updated by a game with a frame of so many ms.
struct Frames : GameRig {
  explicit Frames(double frame_ms, bool joined = true, float gain = 1)
      : GameRig(100'000), frame_ms_(frame_ms) {
    configure([&](protocol::GameConfig& config) {
      config.join_updates = joined ? protocol::Toggle::on : protocol::Toggle::off;
      config.gain = gain;
    });
    block = play_constant(0);
    tick(20 * kTicksPerMs);
  }

  /// One frame. The report arrives within a millisecond of when it is sent, as on the bus.
  /// @returns torque of each of its ticks, as a share of full
  std::vector<double> frame(double share, const std::vector<Part>& parts = {Part::level}) {
    ++frames_;
    const auto end = std::lround(std::ceil(frames_ * frame_ms_) * kTicksPerMs);
    std::vector<double> found;
    for (const Part part : parts) {
      if (!found.empty() || part != parts.front()) play(found, kTicksPerMs);
      send(part, static_cast<int>(std::lround(share * 32767)));
    }
    play(found, static_cast<int>(end - at_) - static_cast<int>(found.size()));
    at_ = end;
    return found;
  }

  int block = 0;

 private:
  void send(Part part, int level) {
    switch (part) {
      case Part::level:
        return constant(block, level);
      case Part::effect:
        return set_effect(block);
      case Part::envelope:
        return envelope(block, 0, 0, 0, 0);
      case Part::start:
        return start(block);
    }
  }
  void play(std::vector<double>& found, int ticks) {
    for (const float nm : torques(ticks)) {
      found.push_back(static_cast<double>(nm) / static_cast<double>(kFullNm));
    }
  }

  double frame_ms_;
  int frames_ = 0;
  long at_ = 0;
};

double wave(double time_s) { return 0.5 * std::sin(2 * std::numbers::pi * 1.5 * time_s); }

struct Ripple {
  double step = 0;   // largest change in a tick
  double error = 0;  // largest distance from the curve, half a frame and the mean wait earlier
};

/// Plays a sine as a game does, and looks at the second of its seconds.
Ripple play_wave(double frame_ms, bool joined, double late_ms,
                 const std::vector<Part>& parts = {Part::level}) {
  Frames rig(frame_ms, joined);
  Ripple ripple;
  double last = 0;
  double time_s = 0;
  for (int n = 0; n * frame_ms < 2000; ++n) {
    for (const double share : rig.frame(wave(n * frame_ms * 1e-3), parts)) {
      time_s += 1e-4;
      if (time_s > 1) {
        ripple.step = std::max(ripple.step, std::abs(share - last));
        ripple.error = std::max(ripple.error, std::abs(share - wave(time_s - 1e-3 * late_ms)));
      }
      last = share;
    }
  }
  return ripple;
}

}  // namespace

TEST_CASE(
    "a curve at 60, 120 and 360 Hz is joined: a tenth of the steps, one frame behind at most") {
  for (const double rate_hz : {60.0, 120.0, 360.0}) {
    CAPTURE(rate_hz);
    const double frame_ms = 1e3 / rate_hz;
    const Ripple held = play_wave(frame_ms, false, 0);
    // A line from the last value to this one reaches it at the frame's end: a whole frame after the
    // game meant it, where a held value is half a frame late in the mean.
    const Ripple joined = play_wave(frame_ms, true, frame_ms);
    const double slope_per_s = 0.5 * 2 * std::numbers::pi * 1.5;
    CHECK(held.step == Approx(slope_per_s * 1e-3 * frame_ms).scale(0).epsilon(0.4));
    CHECK(joined.step < 0.1 * held.step);
    // A chord's distance from its arc, and the bus's jitter of a frame.
    CHECK(joined.error < 0.003 + slope_per_s * 1.1e-3);
  }
}

TEST_CASE("joined updates never go beyond what the game sent") {
  for (const double rate_hz : {60.0, 120.0, 360.0}) {
    Frames rig(1e3 / rate_hz);
    double most = 0;
    double sent = 0;
    for (int n = 0; n < 200; ++n) {
      sent = std::min(1.0, n / 30.0);
      for (const double share : rig.frame(sent)) most = std::max(most, share);
      CHECK(most <= sent + 1.0 / 32767);  // a step of the report
    }
    CHECK(most == Approx(1.0).scale(0).epsilon(1e-5));
  }
}

TEST_CASE("a hit passes at once in the middle of a curve, and so does its end") {
  Frames rig(1e3 / 60);
  for (int n = 0; n < 60; ++n) rig.frame(wave(n / 60.0));
  const double before = wave(59 / 60.0);
  const std::vector<double> hit = rig.frame(before + 0.4);
  CHECK(hit[1] == Approx(before + 0.4).scale(0).epsilon(1e-3));
  const std::vector<double> after = rig.frame(before);
  CHECK(after[1] == Approx(before).scale(0).epsilon(1e-3));
}

TEST_CASE("a hit is one also for a player who has turned the forces down") {
  for (const float gain : {1.0F, 0.3F, 0.1F}) {
    CAPTURE(gain);
    Frames rig(1e3 / 60, true, gain);
    for (int n = 0; n < 30; ++n) rig.frame(0.01 * (n % 2));
    CHECK(rig.frame(0.3)[1] == Approx(0.3 * static_cast<double>(gain)).scale(0).epsilon(1e-3));
  }
}

TEST_CASE("a game at 30 Hz is joined, though its frames come early and late") {
  const auto largest_step = [](bool joined) {
    Frames rig(1e3 / 60, joined);
    double largest = 0;
    float last = 0;
    int at_ms = 0;
    for (int n = 0; at_ms < 3000; ++n) {
      rig.constant(rig.block, static_cast<int>(std::lround(32767 * wave(1e-3 * at_ms))));
      const int frame_ms = 33 + 3 * (n % 3 - 1);
      at_ms += frame_ms;
      for (const float nm : rig.torques(frame_ms * kTicksPerMs)) {
        if (at_ms > 1000) largest = std::max(largest, static_cast<double>(std::abs(nm - last)));
        last = nm;
      }
    }
    return largest;
  };
  CHECK(largest_step(true) < 0.1 * largest_step(false));
}

TEST_CASE("without joining an update is held from the next tick on") {
  Frames rig(1e3 / 60, false);
  for (int n = 0; n < 10; ++n) {
    CHECK(rig.frame(0.01 * n)[1] == Approx(0.01 * n).scale(0.01).epsilon(1e-2));
  }
}

TEST_CASE("a change of several reports counts as one frame, and a start of what plays is no end") {
  using enum Part;
  // Wine's DirectInput: level, envelope, effect; with DIEP_START a start behind them. Linux's
  // driver: effect, then level. SDL's rumble: the effect anew, and a start.
  for (const std::vector<Part>& parts : {std::vector{effect, level},
                                         {level, start},
                                         {level, effect},
                                         {level, envelope, effect},
                                         {level, effect, start},
                                         {effect, level, start},
                                         {effect, envelope, level}}) {
    CAPTURE(parts.size());
    CAPTURE(static_cast<int>(parts.back()));
    for (const double rate_hz : {60.0, 120.0, 250.0}) {
      CAPTURE(rate_hz);
      const double frame_ms = 1e3 / rate_hz;
      const double level_ms = static_cast<double>(std::ranges::find(parts, level) - parts.begin());
      const Ripple held = play_wave(frame_ms, false, 0, parts);
      const Ripple joined = play_wave(frame_ms, true, frame_ms + level_ms, parts);
      const double slope_per_s = 0.5 * 2 * std::numbers::pi * 1.5;
      CHECK(joined.step < 0.15 * held.step);
      CHECK(joined.error < 0.003 + slope_per_s * 1.1e-3);
    }
  }
}

TEST_CASE("a start of what plays with an attack or a delay begins anew") {
  for (const bool delayed : {false, true}) {
    Frames rig(20);
    rig.frame(0.05);
    rig.frame(0.06);
    EffectOptions options;
    options.delay_ms = delayed ? 5 : 0;
    rig.set_effect(rig.block, options);
    if (!delayed) rig.envelope(rig.block, 0, 5, 0, 0);
    rig.start(rig.block);
    const std::vector<float> found = rig.torques(60 * kTicksPerMs);
    CHECK(found[2] < 0.02F * GameRig::kFullNm);
    CHECK(found[51] == about(0.06 * 0.08));
  }
}

TEST_CASE("two changes of one update are joined as one, over the frame of the game") {
  Frames rig(20);
  for (int n = 0; n < 20; ++n) rig.frame(0.005 * n);
  double last = 0;
  double step = 0;
  const auto pass = [&](double share, int ms) {
    rig.constant(rig.block, static_cast<int>(std::lround(share * 32767)));
    for (const float nm : rig.torques(ms * kTicksPerMs)) {
      const double now = static_cast<double>(nm) / static_cast<double>(GameRig::kFullNm);
      if (last != 0) step = std::max(step, std::abs(now - last));
      last = now;
    }
  };
  for (int n = 20; n < 60; ++n) {
    pass(0.005 * n - 0.0025, 1);
    pass(0.005 * n, 19);
  }
  CHECK(step < 1.3 * 0.005 / (20 * kTicksPerMs));
}

TEST_CASE("the waves' own edges are not touched by updates") {
  GameRig rig(100'000);
  const int block = rig.create(kSquare);
  rig.set_effect(block);
  rig.periodic(block, 32767, 0, 0, 10);
  rig.start(block);
  rig.tick(10);
  double step = 0;
  float last = rig.outputs.motor_command_nm;
  for (int n = 0; n < 60; ++n) {
    rig.periodic(block, 32767, n % 2, 0, 10);
    for (const float nm : rig.torques(167)) {
      step = std::max(step, std::abs(static_cast<double>(nm - last)));
      last = nm;
    }
  }
  CHECK(step == Approx(0.16).scale(0).epsilon(1e-3));
}

TEST_CASE("a wave that begins or ends in a curve of steady levels does so at once") {
  GameRig rig(100'000);
  const int block = rig.create(kSquare);
  rig.set_effect(block);
  rig.start(block);
  const auto soon_after = [&](int magnitude, int offset) {
    rig.periodic(block, magnitude, offset, 0, 1000);
    rig.tick(3);
    const float nm = rig.outputs.motor_command_nm;
    rig.tick(97);
    return static_cast<double>(nm);
  };
  for (const int offset : {100, 200, 300}) (void)soon_after(0, offset);
  CHECK(soon_after(1000, 300) == about(0.08 * 1300 / 32767));
  CHECK(soon_after(0, 300) == about(0.08 * 300 / 32767));
}

TEST_CASE("a force that comes back brings no line that it was on") {
  Frames rig(20);
  for (const double share : {0.05, 0.1, 0.15}) (void)rig.frame(share);
  rig.constant(rig.block, 32767 / 5);
  rig.tick(2 * kTicksPerMs);
  rig.control(2);  // actuators off
  rig.tick(5);
  rig.control(1);
  rig.tick(3);
  CHECK(static_cast<double>(rig.outputs.motor_command_nm) == about(0.08 / 5));
}

// Taking the actuator ---------------------------------------------------------------------------

TEST_CASE("a spring that begins far from its middle comes up along a line, without a kick") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.range_deg = 114.59156F; });
  rig.turn(5, 100);
  rig.play_condition(kSpring, {});
  const std::vector<float> rise = rig.torques(60);
  const float full = rise.back();
  CHECK(full < -0.02F);
  float last = 0.0F;
  for (const float nm : rise) {
    CHECK(std::abs(nm - last) < 1.1F * std::abs(full) / 50);
    last = nm;
  }
}

TEST_CASE("a spring that is started anew in each frame comes up all the same") {
  GameRig rig;
  rig.configure([](protocol::GameConfig& config) { config.range_deg = 114.59156F; });
  rig.turn(5, 100);
  const int block = rig.play_condition(kSpring, {});
  for (int n = 0; n < 10; ++n) {
    rig.tick(16);
    rig.start(block);
  }
  const float often = rig.outputs.motor_command_nm;
  rig.tick(100);
  CHECK(often == rig.outputs.motor_command_nm);
  CHECK(often < -0.02F);
}

TEST_CASE("what drivers say when they take the device moves nothing") {
  GameRig rig;
  rig.turn(5, 100);
  // Linux since 6.15, at the first upload: reset twice, stop all, actuators on; then full gain.
  for (const int what : {4, 4, 3, 1}) rig.control(what);
  rig.gain(32767);
  rig.create(kSpring);
  for (const float nm : rig.torques(200)) CHECK(nm == 0.0F);
  CHECK(rig.owner() == protocol::Owner::none);
}

TEST_CASE("walls at the ends of the axis hold while a game has the actuator, and only there") {
  GameRig rig(100'000);
  rig.configure([](protocol::GameConfig& config) {
    config.range_deg = 60;
    config.end_stiffness_nm_per_rad = 1;
  });
  rig.turn(5, 150);  // beyond the end at 30 degrees, of 33
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  const int block = rig.play_constant(1000);
  rig.tick(600);  // the walls come up in 50 ms
  const double beyond = 750 * 2 * std::numbers::pi / 8192 - std::numbers::pi / 6;
  const double pushed = 0.08 * 1000 / 32767;
  CHECK(static_cast<double>(rig.outputs.motor_command_nm) ==
        Approx(pushed - beyond).scale(1).epsilon(1e-5));
  rig.control(5);  // the wall stays through a pause of the game
  rig.tick(1000);
  CHECK(static_cast<double>(rig.outputs.motor_command_nm) ==
        Approx(-beyond).scale(1).epsilon(1e-5));
  rig.control(6);
  rig.turn(-5, 40);
  rig.tick(100);
  CHECK(static_cast<double>(rig.outputs.motor_command_nm) == Approx(pushed).scale(1).epsilon(1e-5));
  rig.turn(-10, 200);  // and the other one
  rig.stop(block);
  rig.tick(100);
  CHECK(rig.outputs.motor_command_nm > 0.05F);
  rig.tick(10'700);  // it lets go of the actuator, in 50 ms
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("walls that hold the knob when a game has ended let go along a line") {
  for (const int how : {0, 1, 2}) {
    CAPTURE(how);
    GameRig rig(100'000);
    rig.configure([](protocol::GameConfig& config) {
      config.range_deg = 60;
      config.end_stiffness_nm_per_rad = 8;
    });
    rig.turn(5, 180);
    const int block = rig.play_constant(1000);
    rig.tick(1000);
    if (how == 0) rig.stop(block);
    if (how == 1) rig.control(3);
    if (how == 2) rig.control(4);
    rig.tick(5000);  // the game's force is gone
    float last = rig.outputs.motor_command_nm;
    REQUIRE(last < -0.07F);
    float step = 0;
    for (const float nm : rig.torques(10'000)) {
      step = std::max(step, std::abs(nm - last));
      last = nm;
    }
    CHECK(last == 0.0F);
    CHECK(rig.owner() == protocol::Owner::none);
    CHECK(step <= 1.01F * 0.08F / 500);  // 50 ms
  }
}
