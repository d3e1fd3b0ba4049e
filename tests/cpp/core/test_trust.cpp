// What costs the sensor the trust, and what gives it back, with numbers worked out by hand.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <numbers>

#include "bound_bench.hpp"
#include "core/controller.hpp"

namespace {

using namespace torsio::core;
using doctest::Approx;

}  // namespace

TEST_CASE("a sensor that rings quickly and for long costs the trust, and leaves the bound alone") {
  const auto ring = [](BoundBench& bench, int times, std::uint64_t ticks) {
    for (int n = 0; n < times; ++n) {
      bench.now += ticks;
      const float other_nm = bench.state.rang_up ? -1.0F : 1.0F;
      judge_ringing(bench.state, other_nm, bench.now);
      judge_ringing(bench.state, 2.0F * other_nm, bench.now + 1);  // goes on, one way
    }
  };
  BoundBench bench;
  bench.state.in_time_nm = 0.0F;
  bench.state.swing_counts = 20;
  bench.now = 1000;
  ring(bench, 8, 30);  // as a hard bounce may do
  CHECK(bench.state.trust == 1.0F);
  ring(bench, 40, 60);  // a hand's
  CHECK(bench.state.trust == 1.0F);
  CHECK(bench.state.doubt == 0);
  ring(bench, 9, 30);
  CHECK(bench.state.trust == bench.state.params.least_share);
  CHECK(bench.state.doubt == 64);
  CHECK(bench.state.unexpected_swings == 4);
  // Without the inertia too.
  bench.state.trust = 1.0F;
  ring(bench, 3, 30);
  CHECK(static_cast<double>(bench.state.trust) == Approx(0.6 * 0.6 * 0.6));
  CHECK(bench.state.doubt == 64);
  CHECK(bench.state.share == 1.0F);
}

TEST_CASE("after each ring the brake's inertia is in doubt for twice as many turns, up to 2048") {
  BoundBench bench;
  BoundState& state = bench.state;
  state.in_time_nm = 0.0F;
  std::uint32_t counted = 0;
  for (const std::uint32_t turns : {64U, 128U, 256U, 512U, 1024U, 2048U, 2048U}) {
    const bool soft = turns != 256;
    state.swing_counts = soft ? 20 : 0;
    for (int n = 0; n <= 9; ++n) judge_ringing(state, n % 2 == 0 ? 1.0F : -1.0F, bench.now + n);
    CHECK(state.doubt == turns);
    counted += soft ? 4 : 0;
    CHECK(state.unexpected_swings == counted);
    for (std::uint32_t turn = 0; turn < turns; ++turn) {
      CHECK(state.doubt == turns - turn);
      turn_round(state, 0);
    }
    CHECK(state.doubt == 0);
    state.rings = 0;
  }
  // Each turn without a ring makes the next doubt shorter.
  turn_round(state, 0);
  CHECK(state.next_doubt == 2047);
  for (int turn = 0; turn < 3000; ++turn) turn_round(state, 0);
  CHECK(state.next_doubt == 64);
}

TEST_CASE(
    "a slow swing in doubt or far is no hand's where the scene alone would swing the knob so") {
  const auto trust_after = [](std::uint32_t doubt, double part, double back, int pushes = 1,
                              std::int32_t turn_counts = 1000, bool flywheel = false) {
    BoundBench bench;
    bench.state.params.flywheel = flywheel;
    bench.state.doubt = doubt;
    bench.state.params.turn_counts = turn_counts;
    bench.state.params.swing_nm = static_cast<float>(part * 0.01 * 220 * 220 / 20);
    for (int n = 0; n < 8; ++n) {
      const int sign = n % 2 == 0 ? 1 : -1;
      for (int rest = 0; rest < 200; ++rest) bench.step(0.01 * back * sign, 0);
      bench.state.pushes = pushes;
      for (int count = 1; count <= 20; ++count) bench.step(1e-3 * back * sign * (10 - count), sign);
    }
    CHECK(bench.state.share == 1.0F);
    return bench.state.trust;
  };
  CHECK(trust_after(100, 2.0 / (std::numbers::pi * std::numbers::pi), 1.0) < 1.0F);  // a spring
  CHECK(trust_after(100, 0.25, 1.0) < 1.0F);  // a constant torque
  CHECK(trust_after(0, 0.25, 1.0) == 1.0F);
  CHECK(trust_after(0, 0.25, 1.0, 1, 161) == 1.0F);
  CHECK(trust_after(0, 0.25, 1.0, 1, 160) < 1.0F);  // over an eighth of a turn
  CHECK(trust_after(0, 0.25, 1.0, 1, 1000, true) < 1.0F);
  CHECK(trust_after(100, 0.03, 1.0) == 1.0F);     // a hand that is slower
  CHECK(trust_after(100, 0.6, 1.0) == 1.0F);      // or quicker
  CHECK(trust_after(100, 0.25, -1.0) == 1.0F);    // or turns back against the torque
  CHECK(trust_after(100, 0.25, 1.0, 0) == 1.0F);  // or against friction
}

TEST_CASE("a look tells whether the scene drives the swing that goes on") {
  BoundBench bench;
  BoundState& state = bench.state;
  for (const float way : {1.0F, -1.0F}) {
    state.last_nm = 0.01F * way;
    judge_way(state, 1, kLookTicks);
    CHECK(state.pushes == 2);
    state.last_nm = -0.01F * way;
    judge_way(state, 1, kLookTicks);
    judge_way(state, 1, kLookTicks);
    judge_way(state, 1, kLookTicks);
    CHECK(state.pushes == -1);
    state.last_nm = 0.0F;
    judge_way(state, 1, kLookTicks);
    CHECK(state.pushes == -1);
    turn_round(state, 0);
    CHECK(state.pushes == 0);
  }
}

TEST_CASE("a knob that goes on for 128 slow swings without a rest is led by no hand") {
  BoundBench bench;
  BoundState& state = bench.state;
  state.params.slow_ticks = 1500;
  std::uint32_t now = 0;
  const auto look = [&](int counts) {
    if (counts > 0) follow_swing(state, counts);
    now += kLookTicks;
    watch_hand(state, now);
  };
  for (int n = 0; n < 6; ++n) look(0);
  // A rest of less than a slow swing is none.
  while (now < 6 * kLookTicks + 128 * 1500) look(now % (4 * kLookTicks) == 0 ? 2 : 0);
  CHECK(state.trust == 1.0F);
  for (int n = 0; n < 4; ++n) look(2);
  CHECK(state.trust < 1.0F);
  CHECK_FALSE(state.spun);
  // It is driven back a little, which is no hand either.
  state.turned_tick = 0;
  CHECK(begin_touch(state, now, is_slow(state, now)));
  CHECK(state.trust < 1.0F);
  // What goes on all the same is led.
  BoundState led = state;
  led.rested_tick = led.moved_tick - 128 * 1500 - 1;
  const std::uint32_t stopped = led.moved_tick;
  for (std::uint32_t ticks = 0; ticks <= 47 * kLookTicks; ticks += kLookTicks) {
    CHECK(creeps(led, false, 2, stopped + ticks));
  }
  CHECK_FALSE(creeps(led, false, 2, stopped + 48 * kLookTicks));
  // So is what goes on quickly.
  state.params.spin_counts = 7;
  CHECK_FALSE(creeps(state, false, 2, now));
  state.params.spin_counts = 8;
  CHECK(creeps(state, false, 2, now));
  // What has rested is moved by another.
  for (int n = 0; n < 7; ++n) look(0);
  const float before = state.trust;
  look(2);
  CHECK(state.trust == before);
  CHECK(begin_touch(state, now, is_slow(state, now)));
  CHECK(state.trust == 1.0F);
}

TEST_CASE("what a shaking scene took comes back once it has stopped for a swing's time") {
  for (const bool shakes : {true, false}) {
    BoundBench bench;
    bench.now = 10'000;
    for (int n = 0; n < 8; ++n) {
      if (shakes) bench.state.timed_tick = static_cast<std::uint32_t>(bench.now);
      bench.swing(20, n % 2 == 0 ? 1 : -1);
    }
    const auto now = static_cast<std::uint32_t>(bench.now);
    bench.state.timed_tick = now;
    CHECK(bench.state.share < 1.0F);
    CHECK(bench.state.trust < 1.0F);
    CHECK(bench.state.shaken == shakes);
    forgive(bench.state, now + 150);
    CHECK(bench.state.share < 1.0F);
    BoundState soft = bench.state;  // a hand leans on less than is asked
    soft.bounded = true;
    forgive(soft, now + 151);
    CHECK(soft.trust < 1.0F);
    CHECK_FALSE(soft.shaken);
    if (shakes) {
      watch_hand(bench.state, now + 151);
    } else {
      forgive(bench.state, now + 151);
    }
    CHECK((bench.state.share == 1.0F) == shakes);
    CHECK((bench.state.trust == 1.0F) == shakes);
    CHECK_FALSE(bench.state.shaken);
  }
}

TEST_CASE("a sensor that rings in a knob that never turns back costs the trust") {
  for (const std::uint32_t step_counts : {1U, 20U}) {  // the first rings within what is certain
    ControllerParams params;
    params.motion = make_motion_params(make_resolution(8192, 100'000), 32, false, 100);
    params.brake.drag_nm = 1e-3F;
    params.shaft =
        make_shaft_params(2.9F, std::array<ShaftKnee, kMostKnees>{}, 4e-5F, 1e-4F, 6e-3F);
    params.partition = {Law::calibrated, 0.5F, 0.5F, 0.2F};
    params.bound = {8.0F * params.motion.resolution.rad_per_count, 1.0F / 64, 400, 1500};
    Plan plan = plan_of(params, {}, {});
    ControllerState state;
    std::uint32_t count = 0;
    for (int n = 0; n < 4000; ++n) {
      if (n % 234 == 0) count += step_counts;  // once in each of its periods
      (void)control(state, params, plan, count);
      plan.pipeline = Pipeline::bounded;
    }
    CHECK((state.bound.trust == 1.0F) == (step_counts == 1));
  }
}

TEST_CASE("a swing that is too slow to buzz costs the trust, and leaves the bound alone") {
  for (const float in_time_nm : {0.0F, 1e-3F}) {
    BoundBench bench;
    bench.state.in_time_nm = in_time_nm;
    for (int n = 0; n < 20; ++n) {
      for (int rest = 0; rest < 50; ++rest) bench.step(0.0, 0);
      bench.swing(20, n % 2 == 0 ? 1 : -1);
    }
    CHECK(bench.state.share == 1.0F);
    CHECK(bench.state.trust < 0.3F);
    CHECK(bench.state.unexpected_swings == 0);  // a hand may shake the knob
  }
}

TEST_CASE("swings that last are unexpected where the parts could render all that is asked") {
  const auto unexpected = [](double slope_nm, float in_time_nm, double first_nm = 0.0) {
    BoundBench bench;
    bench.state.in_time_nm = in_time_nm;
    bench.step(first_nm, 1);
    int place = -10;  // the torque pulls to both sides
    for (int n = 0; n < 8; ++n) {
      const int sign = n % 2 == 0 ? 1 : -1;
      for (int count = 0; count < 20; ++count) bench.step(-slope_nm * (place += sign), sign);
    }
    return bench.state.unexpected_swings;
  };
  // One of eight half swings still goes on, and the first three may come from a push.
  CHECK(unexpected(0.0, 0.0F) == 4);
  CHECK(unexpected(0.0004, 0.0F) == 4);
  CHECK(unexpected(0.0015, 0.0F) == 0);  // steeper than a third of what is stable
  CHECK(unexpected(0.02, 0.0F) == 0);
  CHECK(unexpected(0.0, 1e-3F) == 0);  // a game may shake the knob
  // What was bounded before the first turn is no reason afterwards.
  CHECK(unexpected(0.0, 0.0F, -0.05) == 4);
}

TEST_CASE("fifty slow turns take an unexpected swing back, where the parts can render the scene") {
  for (const double asked_nm : {0.0, 0.02}) {
    BoundBench bench;
    bench.state.in_time_nm = 0.0F;
    bench.state.unexpected_swings = 2;
    for (int turn = 0; turn <= 150; ++turn) {
      for (int rest = 0; rest < 200; ++rest) bench.step(0.0, 0);
      const int sign = turn % 2 == 0 ? 1 : -1;
      for (int count = 0; count < 20; ++count) bench.step(-asked_nm * sign * count, sign);
      const bool renders = asked_nm == 0.0;
      if (turn == 49) CHECK(bench.state.unexpected_swings == 2);
      if (turn == 50) CHECK(bench.state.unexpected_swings == (renders ? 1 : 2));
    }
    CHECK(bench.state.unexpected_swings == (asked_nm == 0.0 ? 0 : 2));  // and no less
  }
}

TEST_CASE("a knob that spins is led by no hand, beyond a quarter turn") {
  BoundBench bench;
  bench.state.params.turn_counts = 6000;
  bench.state.params.spin_counts = 100;
  set_share(bench.state, 0.5F);
  bench.state.last_nm = 0.01F;  // along its way, as where a hand lets off
  for (const double trust : {1.0, 0.6}) {
    follow_swing(bench.state, 1000);
    watch_hand(bench.state, 1000);
    CHECK(bench.state.trust == Approx(trust));
  }
  CHECK(bench.state.spun);
  set_share(bench.state, 0.5F);
  follow_swing(bench.state, 1000);
  watch_hand(bench.state, 1000);
  CHECK(bench.state.share == 0.5F);
  follow_swing(bench.state, 1000);
  bench.now = 1000;
  bench.step(0.01, -1);  // a count that flickers
  CHECK(bench.state.trust == Approx(0.36));
  CHECK(bench.state.share == 0.5F);
}

TEST_CASE("from its fifth turn on a knob spins at a quarter of the speed") {
  BoundBench bench;
  bench.state.params.turn_counts = 1000;
  bench.state.params.spin_counts = 400;
  for (int n = 0; n < 20; ++n) {
    follow_swing(bench.state, 200);
    watch_spin(bench.state, kLookTicks);
  }
  CHECK(bench.state.trust == 1.0F);
  follow_swing(bench.state, 210);  // beyond four turns
  watch_spin(bench.state, kLookTicks);
  CHECK(bench.state.trust == Approx(0.6));
  follow_swing(bench.state, 60);
  watch_spin(bench.state, kLookTicks);
  CHECK(bench.state.trust == Approx(0.6));
  watch_spin(bench.state, 2 * kLookTicks);  // no rest yet
  CHECK(bench.state.trust == Approx(0.6));
  watch_spin(bench.state, 2 * kLookTicks + 1);
  CHECK(bench.state.trust == Approx(0.6 + 1.0 / 16));
  // A slow turn back is no rest either.
  bench.now = 2 * kLookTicks + 1000;
  bench.step(0.0, -5);
  CHECK(bench.state.trust == Approx(0.6 + 1.0 / 16));
}

TEST_CASE(
    "a sensor that goes to and fro about what the brake holds, while a hand turns on, slides") {
  BoundBench bench;
  BoundState& state = bench.state;
  state.params.turn_counts = 240;
  state.swing_counts = 11;
  std::uint64_t tick = 0;
  float speed_counts = 1.0F;
  const auto swing = [&](std::uint32_t times, float asked_nm, float beyond_nm = 2e-3F) {
    state.last_nm = asked_nm;
    for (std::uint32_t n = 0; n < times; ++n) {
      judge_slide(state, n % 2 == 0 ? beyond_nm : -beyond_nm, speed_counts, tick += 100);
    }
    return state.slides >= kSlides;
  };
  SUBCASE("until the knob turns back") {
    CHECK_FALSE(swing(kSlides - 2, -0.03F));
    CHECK(swing(2, -0.03F));
    CHECK(swing(1, -0.05F));
    turn_round(state, 0);
    CHECK(state.slides == 0);
  }
  SUBCASE("until the knob is slow") {
    state.speed_counts = 1.0F;
    CHECK(swing(40, -0.03F));
    speed_counts = 0.7F;
    CHECK(swing(100, -0.03F));
    speed_counts = 0.5F;
    CHECK_FALSE(swing(30, -0.03F));
  }
  SUBCASE("until the scene asks for another torque") {
    CHECK(swing(40, -0.03F));
    for (const float other_nm : {0.0F, -0.07F, 0.03F}) {
      CHECK_FALSE(swing(1, other_nm));
      CHECK(swing(40, -0.03F));
    }
  }
  SUBCASE("not slowly, not in free air, not in a short press, and not by what nobody notices") {
    CHECK_FALSE(swing(40, 0.0F));
    CHECK_FALSE(swing(40, -0.03F, 0.9e-3F));
    state.params.slow_ticks = 99;
    CHECK_FALSE(swing(40, -0.03F));
    state.params.slow_ticks = 150;
    state.swing_counts = 10;
    CHECK_FALSE(swing(40, -0.03F));
  }
}

TEST_CASE("help in free air ends from the third turn without a rest to the fifth") {
  BoundBench bench;
  bench.state.params.turn_counts = 1000;
  CHECK(help_share(bench.state) == 1.0F);
  for (const double share : {1.0, 1.0, 0.5, 0.0, 0.0}) {
    follow_swing(bench.state, 1000);
    watch_spin(bench.state, kLookTicks);
    CHECK(help_share(bench.state) == Approx(share));
  }
  SUBCASE("a rest begins anew") {
    watch_spin(bench.state, kLookTicks);
    CHECK(help_share(bench.state) == 1.0F);
    follow_swing(bench.state, 3000);
    CHECK(help_share(bench.state) == Approx(0.5));
  }
  SUBCASE("it has the sensor's trust") {
    watch_spin(bench.state, kLookTicks);
    distrust(bench.state);
    CHECK(help_share(bench.state) == Approx(0.6));
  }
  SUBCASE("a way back does not, but a rest on it") {
    bench.now = 1000;
    bench.step(0.0, -5);
    CHECK(help_share(bench.state) == 0.0F);
    bench.state.looked_counts = bench.state.swing_counts;
    watch_spin(bench.state, 1001 + kLookTicks - 1);  // it has turned round since the last look
    CHECK(help_share(bench.state) == 0.0F);
    watch_spin(bench.state, 1001 + kLookTicks);
    CHECK(help_share(bench.state) == 1.0F);
  }
  SUBCASE("ways to and fro for hours are followed, too") {
    for (int n = 0; n < 100; ++n) {
      bench.step(0.0, n % 2 == 0 ? -kManyCounts / 2 : kManyCounts / 2);
      CHECK(help_share(bench.state) == 0.0F);
    }
  }
}

TEST_CASE("a knob that turns one way for hours is followed as in its first turn") {
  BoundBench bench;
  bench.state.params.turn_counts = 10;
  bench.state.params.spin_counts = 1000;
  for (const std::int32_t way : {kManyCounts - 10, 20}) {
    follow_swing(bench.state, way);
    watch_spin(bench.state, kLookTicks);
  }
  CHECK(bench.state.trust == Approx(0.6));
  for (int n = 0; n < 8; ++n) {
    follow_swing(bench.state, kManyCounts / 4);
    watch_spin(bench.state, kLookTicks);
    CHECK(bench.state.swing_counts < kManyCounts);
    CHECK(bench.state.swing_counts == bench.state.gone_counts);
    CHECK(bench.state.looked_counts == bench.state.swing_counts);
    CHECK(help_share(bench.state) == 0.0F);
    CHECK(bench.state.flicker_counts <= bench.state.swing_counts);
  }
  bench.step(0.0, -5);
  CHECK(bench.state.way == -1);
  CHECK(bench.state.swing_counts == 5);
}
