// The bound of the law calibrated, a step at a time, with numbers worked out by hand. Its effect is
// tested in tests/cpp/emulator/test_no_buzz.cpp.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "core/controller.hpp"
#include "core/stiffness_bound.hpp"

namespace {

using namespace torsio::core;
using doctest::Approx;

/// A bound of 0.01 N m for each count.
struct BoundBench {
  BoundState state;
  std::uint64_t now = 0;

  BoundBench() {
    state.params = {0.01F, 1.0F / 64, 40, 150};
    set_share(state, 1.0F);
  }
  double step(double asked_nm, std::int32_t delta_counts, double timed_nm = 0.0) {
    ++now;
    if (follow_swing(state, delta_counts)) judge_swing(state, now);
    return static_cast<double>(bound_stiffness(state, static_cast<float>(asked_nm),
                                               static_cast<float>(timed_nm), delta_counts));
  }
  /// Goes so far, a count in each tick.
  void swing(int counts, int sign) {
    for (int n = 0; n < counts; ++n) step(0.0, sign);
  }
};

}  // namespace

TEST_CASE("what rises no steeper than the bound is left alone, either way") {
  for (const int sign : {1, -1}) {
    BoundBench bench;
    for (int n = 1; n <= 5; ++n) {
      CHECK(bench.step(-sign * 0.009 * n, sign) == Approx(-sign * 0.009 * n));
    }
    CHECK_FALSE(bench.state.bounded);
  }
}

TEST_CASE("what is steeper gets the bound's slope in and out, and nothing more at rest") {
  for (const int sign : {1, -1}) {
    BoundBench bench;
    bench.state.params.buzz_ticks = 0;  // no swing is one
    CHECK(bench.step(-sign * 0.1, sign) == Approx(-sign * 0.01));
    CHECK(bench.step(-sign * 0.2, sign) == Approx(-sign * 0.02));
    CHECK(bench.state.bounded);
    CHECK(bench.step(-sign * 0.2, 0) == Approx(-sign * 0.02));
    CHECK(bench.step(-sign * 0.2, 1 * sign) == Approx(-sign * 0.03));
    CHECK(bench.step(-sign * 0.1, -sign) == Approx(-sign * 0.02));
    CHECK(bench.step(-sign * 0.05, -sign) == Approx(-sign * 0.01));
    // Never of the other sign, never more than asked.
    CHECK(bench.step(-sign * 0.05, -3 * sign) == 0.0);
    CHECK(bench.step(-sign * 0.3, 9 * sign) == Approx(-sign * 0.09));
    CHECK(bench.step(-sign * 0.005, -sign) == Approx(-sign * 0.005));
    CHECK_FALSE(bench.state.bounded);
  }
}

TEST_CASE("what is limited gives on the way back what it took on the way in, and no more") {
  for (const int sign : {1, -1}) {
    BoundBench bench;
    bench.state.params.buzz_ticks = 0;  // no swing is one
    const double in[] = {0.01, 0.02, 0.03, 0.04, 0.05, 0.05, 0.05, 0.05};
    for (const double torque_nm : in) {
      CHECK(bench.step(-sign * 0.05, sign) == Approx(-sign * torque_nm));
    }
    CHECK_FALSE(bench.state.bounded);
    CHECK(bench.step(-sign * 0.05, 0) == Approx(-sign * 0.05));
    const double out[] = {0.05, 0.05, 0.05, 0.04, 0.03, 0.02, 0.01};
    for (const double torque_nm : out) {
      CHECK(bench.step(-sign * 0.05, -sign) == Approx(-sign * torque_nm));
    }
    CHECK(bench.state.bounded);
    // Outside it is over, and the next visit is like the first one.
    CHECK(bench.step(0.0, -sign) == 0.0);
    CHECK_FALSE(bench.state.on_line);
    CHECK(bench.step(-sign * 0.05, sign) == Approx(-sign * 0.01));
  }
}

TEST_CASE(
    "the way out leads back to where the line began, though the bound came down on the way in") {
  for (const int sign : {1, -1}) {
    BoundBench bench;
    bench.state.params.buzz_ticks = bench.state.params.slow_ticks = 10'000;
    for (int n = 0; n < 5; ++n) bench.step(-sign * 0.02, 0, n == 0 ? -sign * 0.02 : 0.0);
    for (int n = 1; n <= 4; ++n) bench.step(-sign * (0.02 + n), sign);
    set_share(bench.state, 0.5F);
    for (int n = 5; n <= 8; ++n) bench.step(-sign * (0.02 + n), sign);
    CHECK(bench.state.line_nm == Approx(-sign * 0.08));
    CHECK(most_share(bench.state) == Approx(0.75));  // no stiffer, or it ended inside
    // As soft as the bound for two counts, then straight.
    CHECK(bench.step(-sign * 7.02, -sign) == Approx(-sign * 0.075));
    CHECK(bench.step(-sign * 6.02, -sign) == Approx(-sign * 0.07));
    for (int n = 5; n > 0; --n) {
      CHECK(bench.step(-sign * (0.02 + n), -sign) == Approx(-sign * (0.02 + 0.05 * n / 6)));
    }
    CHECK(bench.step(-sign * 0.02, -sign) == Approx(-sign * 0.02));
    // There it ends, and what is outside is as before.
    CHECK_FALSE(bench.state.on_line);
    CHECK(bench.step(-sign * 0.019, -sign) == Approx(-sign * 0.019));
  }
}

TEST_CASE("the next press after a hand has let off begins with the whole bound, and from there") {
  BoundBench bench;
  bench.state.params.held_nm = 0.009F;
  set_share(bench.state, 0.1F);
  for (int n = 1; n <= 30; ++n) bench.step(-n, 1);
  for (int n = 29; n >= 20; --n) bench.step(-n, -1);
  for (int n = 0; n < 60; ++n) bench.step(-20.0, 0);
  const auto now = static_cast<std::uint32_t>(bench.now);
  let_off(bench.state, now);
  CHECK(bench.state.share == 0.1F);  // it is held by more than friction yet
  for (int n = 19; n >= 8; --n) bench.step(-n, -1);
  REQUIRE(bench.state.line_nm == Approx(-0.008));
  let_off(bench.state, static_cast<std::uint32_t>(bench.now));
  CHECK(bench.state.share == 1.0F);
  CHECK(bench.step(-9.0, 1) == Approx(-0.018));
  CHECK(bench.step(-8.0, -1) == Approx(-0.008));
}

TEST_CASE("a hand that pushes on slowly renews the bound, though it never turns back") {
  BoundBench bench;
  set_share(bench.state, 0.5F);
  bench.swing(3, 1);
  for (int n = 0; n < 100; ++n) bench.step(0.0, 0);
  CHECK(goes_on(bench.state, static_cast<std::uint32_t>(bench.now)));
  CHECK(bench.state.share == 0.5F);  // a swing so narrow may hide its turns
  bench.swing(4, 1);
  CHECK(goes_on(bench.state, static_cast<std::uint32_t>(bench.now)));
  CHECK(bench.state.share == 1.0F);
}

TEST_CASE("what is steep again behind a plateau is bounded from there") {
  for (const int sign : {1, -1}) {
    BoundBench bench;
    bench.state.params.buzz_ticks = 0;
    for (int n = 0; n < 9; ++n) bench.step(-sign * 0.03, sign);
    REQUIRE(bench.state.on_line);
    REQUIRE_FALSE(bench.state.bounded);
    CHECK(bench.step(-sign * 0.09, sign) == Approx(-sign * 0.04));
    CHECK(bench.state.bounded);
  }
}

TEST_CASE("a scene with steps or grains behind an edge gives back no more work than it took") {
  std::mt19937 random(1);
  const auto pick = [&random](double least, double most) {
    return least + (most - least) * static_cast<double>(random()) / 4294967296.0;
  };
  for (int trial = 0; trial < 2000; ++trial) {
    constexpr int kDeep = 600;
    const double most_nm = pick(5e-3, 0.1);
    const double rough = pick(0.0, 1.0);
    const double grain = pick(5.0, 150.0);
    const bool steps = random() % 2 == 0;
    std::vector<double> heights(kDeep / 5 + 3);
    for (double& height : heights) height = pick(0.0, 1.0);
    std::vector<double> asked_nm(kDeep + 1, 0.0);
    for (int n = 1; n <= kDeep; ++n) {
      const auto place = static_cast<std::size_t>(n / grain);
      const double part = steps ? 0.0 : n / grain - static_cast<double>(place);
      const double height = (1.0 - part) * heights[place] + part * heights[place + 1];
      asked_nm[static_cast<std::size_t>(n)] = -most_nm * (1.0 - rough + rough * height) - 1e-4;
    }
    BoundBench bench;
    bench.state.params.buzz_ticks = 0;  // no swing is one
    const float shares[] = {1.0F / 64, 1.0F / 16, 0.25F, 1.0F};
    set_share(bench.state, shares[random() % 4]);
    int at = 0;
    double given_nm = 0.0;
    double work_nm_counts = 0.0;
    const auto go = [&](int to) {
      while (at != to) {
        const int way = to > at ? 1 : -1;
        at += way;
        const double now_nm =
            bench.step(at > 0 ? asked_nm[static_cast<std::size_t>(at)] : 0.0, way);
        work_nm_counts += 0.5 * (given_nm + now_nm) * way;
        given_nm = now_nm;
      }
    };
    for (int visit = 0; visit < 3; ++visit) {
      for (std::uint32_t turn = random() % 4 + 1; turn > 0; --turn) {
        go(1 + static_cast<int>(random() % (kDeep - 1)));
      }
      go(-1);
      CHECK(work_nm_counts < 1e-3 * most_nm * kDeep);
    }
  }
}

TEST_CASE("slow swings that go on evenly cost the trust, and an uneven one gives it back") {
  BoundBench bench;
  const auto slow_swing = [&bench](int counts, int sign) {
    for (int n = 0; n < 300; ++n) bench.step(0.0, 0);
    bench.swing(counts, sign);
  };
  int sign = 1;
  for (int n = 0; n < 16; ++n, sign = -sign) slow_swing(50, sign);
  CHECK(bench.state.trust == 1.0F);
  for (int n = 0; n < 4; ++n, sign = -sign) slow_swing(50, sign);
  CHECK(bench.state.trust < 0.4F);
  for (int n = 0; n < 3; ++n, sign = -sign) slow_swing(80, sign);
  CHECK(bench.state.trust == 1.0F);
}

TEST_CASE("virtual inertia that makes a creeping count flicker is taken back until a wide swing") {
  BoundBench bench;
  bench.state.params.flicker_ticks = 1000;
  for (int n = 0; n < 60; ++n) bench.step(0.0, n % 5 < 3 ? 1 : -1);  // two to and fro, one on
  CHECK(bench.state.calm < 1.0F);
  CHECK(bench.state.trust == 1.0F);
  bench.swing(20, 1);
  bench.swing(20, -1);
  CHECK(bench.state.calm == 1.0F);
}

TEST_CASE("what changes in time passes whole, bounded or not") {
  for (const int sign : {1, -1}) {
    BoundBench bench;
    CHECK(bench.step(-sign * 0.3, sign, -sign * 0.3) == Approx(-sign * 0.3));
    CHECK(bench.step(-sign * 0.4, sign) == Approx(-sign * 0.31));
    CHECK(bench.step(-sign * 0.5, 0, -sign * 0.1) == Approx(-sign * 0.41));
    BoundBench fading;
    CHECK(fading.step(-sign * 0.5, 0, -sign * 0.5) == Approx(-sign * 0.5));
    CHECK(fading.step(-sign * 0.2, -sign, sign * 0.3) == Approx(-sign * 0.2));
  }
}

TEST_CASE("swings that do not get smaller bring the bound down, by 0.6 from the second on") {
  BoundBench bench;
  double share = 1.0;
  bench.swing(20, 1);
  for (int n = 0; n < 12; ++n) {
    bench.swing(20, n % 2 == 0 ? -1 : 1);
    if (n > 0) share *= 0.6;  // the first may be anything
    CHECK(static_cast<double>(bench.state.share) == Approx(std::max(share, 1.0 / 64)));
    // So does the motor's limit on cancelling the spring.
    CHECK(bench.state.trust == bench.state.share);
  }
  CHECK(bench.state.share == 1.0F / 64);
  // And with it the slope.
  CHECK(bench.step(1.0, -1) == Approx(0.01 / 64));
}

TEST_CASE("swings that look a count wider and narrower by turns do not get smaller") {
  BoundBench bench;
  for (int n = 0; n < 6; ++n) {
    bench.swing(4, 1);
    bench.swing(3, -1);
  }
  CHECK(bench.state.share < 0.3F);
}

TEST_CASE("swings that get smaller, a hand's, and an encoder that flickers leave the bound alone") {
  BoundBench dying;
  int width = 30;
  for (int n = 0; n < 8; ++n, width = width * 3 / 4) dying.swing(width, n % 2 == 0 ? 1 : -1);
  CHECK(dying.state.share == 1.0F);

  BoundBench by_hand;
  for (int n = 0; n < 8; ++n) by_hand.swing(60, n % 2 == 0 ? 1 : -1);
  CHECK(by_hand.state.share == 1.0F);

  BoundBench flicker;
  for (int n = 0; n < 100; ++n) flicker.step(0.0, n % 2 == 0 ? 2 : -2);
  CHECK(flicker.state.share == 1.0F);
}

TEST_CASE("a flicker brings down what a count switches of the scene, and never the trust") {
  BoundBench bench;
  bench.state.params.quiet_share = 0.3F;
  bench.state.params.flicker_ticks = 32;
  bench.state.params.noise_ticks = 8;
  bench.swing(3, 1);
  double share = 1.0;
  for (int n = 1; n <= 54; ++n) {
    bench.step(0.0, n % 2 == 0 ? 1 : -1);
    // Eight ticks and more behind the first change, twice the longest pause between two.
    if (n % 9 == 0) share = std::max(0.6 * share, 0.3);
    CHECK(static_cast<double>(bench.state.share) == Approx(share));
    CHECK(bench.state.trust == 1.0F);
  }
  // A hand that pushes on slowly is a new touch, though it never turns round.
  for (int n = 0; n < 160; ++n) bench.step(0.0, 0);
  bench.swing(3, 1);
  bench.step(0.0, -1);  // not so near: a swing may begin like this, too
  CHECK(static_cast<double>(bench.state.share) == Approx(0.3));
  bench.swing(4, 1);
  bench.step(0.0, -1);
  CHECK(bench.state.share == 1.0F);
}

TEST_CASE("a count that flickers though it switches little is held until a hand turns on") {
  ControllerParams params;
  params.motion = make_motion_params(make_resolution(8192, 100'000), 32, false, 100);
  params.partition = {Law::calibrated, 0.5F, 0.5F, 0.2F};
  params.bound = {1e-3F, 1.0F / 64, 400, 1500, 0.3F, 10'000, 500};
  const Plan plan = plan_of(params, {}, {});
  ControllerState state;
  const auto flicker = [&](std::uint32_t ticks, std::uint32_t counts) {
    for (std::uint32_t n = 0; n < ticks; ++n)
      (void)control(state, params, plan, 10 + n % 2 * counts);
  };
  flicker(1900, 1);  // 500 for each of three steps: to 0.6, 0.36 and 0.3
  CHECK(state.motion.counting == Counting::usual);
  flicker(900, 1);
  CHECK(state.motion.counting == Counting::held);
  CHECK(state.bound.share == 0.3F);
  // Beyond the play no noise moves it: the device does, if it is no slow hand.
  for (std::uint32_t n = 0; n < 4000; ++n) {
    (void)control(state, params, plan, 10 + n / 250 % 2 * 5);
  }
  CHECK(state.bound.share == 0.3F);
  flicker(600, 5);
  CHECK(state.motion.counting == Counting::held);
  CHECK(static_cast<double>(state.bound.share) == Approx(0.18));
  CHECK(control(state, params, plan, 14).motion.delta_counts <= 2);
  CHECK(state.motion.counting == Counting::held);
  CHECK(control(state, params, plan, 18).motion.delta_counts >= 5);
  CHECK(state.motion.counting == Counting::usual);
}

TEST_CASE("a sensor that rings quickly and for long costs the trust, and leaves the bound alone") {
  const auto ring = [](BoundBench& bench, int times, std::uint64_t ticks) {
    for (int n = 0; n < times; ++n) {
      bench.now += ticks;
      judge_ringing(bench.state, n % 2 == 0 ? 1.0F : -1.0F, bench.now);
      judge_ringing(bench.state, n % 2 == 0 ? 2.0F : -2.0F, bench.now + 1);  // goes on, one way
    }
  };
  for (const bool soft : {true, false}) {
    BoundBench bench;
    for (int count = 0; count < 20; ++count) bench.step(soft ? 0.0 : -0.0004 * count, 1);
    bench.now = 1000;
    ring(bench, 8, 30);  // as a hard bounce may do
    CHECK(bench.state.trust == 1.0F);
    ring(bench, 40, 60);  // a hand's
    CHECK(bench.state.trust == 1.0F);
    ring(bench, 10, 30);
    CHECK(static_cast<double>(bench.state.trust) == Approx(0.6 * 0.6 * 0.6));
    CHECK(bench.state.unexpected_swings == 0);
    ring(bench, 20, 30);
    CHECK(bench.state.unexpected_swings == (soft ? 1 : 0));
    CHECK(bench.state.trust == bench.state.params.least_share);
    CHECK(bench.state.share == 1.0F);
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

TEST_CASE("a narrow swing that hides its turns from a coarse encoder is none of a hand") {
  BoundBench bench;
  for (int n = 0; n < 8; ++n) {
    bench.swing(4, n % 2 == 0 ? 1 : -1);
    // To and fro by two counts, then on: 60 ticks, too slow for a swing that buzzes.
    for (int part = 0; part < 7; ++part) {
      bench.swing(2, n % 2 == 0 ? -1 : 1);
      bench.step(0.0, 0);
      bench.step(0.0, 0);
      bench.swing(2, n % 2 == 0 ? 1 : -1);
      bench.step(0.0, 0);
      bench.step(0.0, 0);
    }
  }
  CHECK(bench.state.share < 0.2F);
  CHECK(bench.state.trust < 0.2F);
  // A hand that goes so far in four times the time is one.
  bench.swing(4, 1);
  for (int n = 0; n < 610; ++n) bench.step(0.0, 0);
  bench.swing(3, -1);
  CHECK(bench.state.trust == 1.0F);
}

TEST_CASE("counts that flicker for a moment only are the encoder's noise under a slow hand") {
  BoundBench bench;
  bench.state.params.quiet_share = 0.3F;
  bench.state.params.flicker_ticks = 80;
  bench.state.params.noise_ticks = 20;
  bench.swing(3, 1);
  for (int part = 0; part < 5; ++part) {
    for (int n = 0; n < 18; ++n) bench.step(0.0, n % 2 == 0 ? -1 : 1);
    CHECK(bench.state.share == 1.0F);
    bench.swing(3, 1);
  }
}

TEST_CASE("counts that change slowly are no flicker") {
  BoundBench bench;
  bench.state.params.quiet_share = 0.3F;
  bench.state.params.flicker_ticks = 5;
  bench.swing(3, 1);
  for (int n = 0; n < 40; ++n) {
    bench.step(0.0, n % 2 == 0 ? 1 : -1);
    for (int rest = 0; rest < 5; ++rest) bench.step(0.0, 0);
  }
  CHECK(bench.state.share == 1.0F);
}

TEST_CASE("a touch after a while begins anew with the whole bound") {
  BoundBench bench;
  for (int n = 0; n < 6; ++n) bench.swing(20, n % 2 == 0 ? 1 : -1);
  REQUIRE(bench.state.share < 0.5F);
  for (int n = 0; n < 160; ++n) bench.step(0.0, 0);
  bench.swing(4, 1);
  CHECK(bench.state.share == 1.0F);
  CHECK(bench.state.trust == 1.0F);

  // Also if it turns round within a tick.
  for (int n = 0; n < 6; ++n) bench.swing(20, n % 2 == 0 ? 1 : -1);
  REQUIRE(bench.state.share < 0.5F);
  for (int n = 0; n < 160; ++n) bench.step(0.0, 0);
  bench.step(0.0, 30);
  CHECK(bench.state.share == 1.0F);
  CHECK(bench.state.trust == 1.0F);
}

TEST_CASE("a swing that is too slow to buzz costs the trust, and leaves the bound alone") {
  BoundBench bench;
  for (int n = 0; n < 6; ++n) {
    for (int rest = 0; rest < 50; ++rest) bench.step(0.0, 0);
    bench.swing(20, n % 2 == 0 ? 1 : -1);
  }
  CHECK(bench.state.share == 1.0F);
  CHECK(bench.state.trust < 0.3F);
  CHECK(bench.state.unexpected_swings == 0);  // a hand may shake the knob
}

TEST_CASE("swings that are wide and narrow by turns last, too") {
  BoundBench bench;
  for (int n = 0; n < 8; ++n) {
    bench.swing(30, 1);
    bench.swing(15, -1);
    bench.swing(10, 1);
    bench.swing(25, -1);
  }
  CHECK(bench.state.share < 0.1F);

  BoundBench by_turns;
  for (int n = 0; n < 6; ++n) {
    by_turns.swing(30, 1);
    by_turns.swing(20, -1);
  }
  CHECK(by_turns.state.share < 0.3F);
}

TEST_CASE("a swing that got smaller once and lasts then is seen at the third") {
  for (const auto& [first, later] : {std::pair{30, 24}, std::pair{4, 3}}) {
    BoundBench bench;
    bench.swing(first, 1);
    for (int n = 0; n < 4; ++n) bench.swing(later, n % 2 == 0 ? -1 : 1);
    CHECK(bench.state.share < 1.0F);
  }
}

TEST_CASE("a knob that rests after a swing is not touched, though its encoder flickers") {
  BoundBench bench;
  for (int n = 0; n < 6; ++n) bench.swing(20, n % 2 == 0 ? 1 : -1);
  for (int n = 0; n < 60; ++n) bench.step(0.0, n % 2 == 0 ? 1 : -1);
  CHECK(bench.state.share < 0.5F);
}

TEST_CASE("a knob that rested between two counts is not moved by a hand when it leaves them") {
  BoundBench bench;
  bench.state.params.flicker_ticks = 32;
  bench.state.params.noise_ticks = 8;
  for (int n = 0; n < 12; ++n) {
    bench.swing(3, n % 2 == 0 ? 1 : -1);
    for (int flick = 0; flick < 200; ++flick) bench.step(0.0, flick % 2 == 0 ? -1 : 1);
  }
  CHECK(bench.state.trust == bench.state.params.least_share);
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

TEST_CASE("a knob that spins is led by no hand, from its second turn on") {
  BoundBench bench;
  bench.state.params.turn_counts = 1500;
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

TEST_CASE("a knob that turns one way for hours is followed as in its first turn") {
  BoundBench bench;
  bench.state.params.turn_counts = 10;
  bench.state.params.spin_counts = 1000;
  for (const std::int32_t way : {kManyCounts - 10, 20}) {
    follow_swing(bench.state, way);
    watch_spin(bench.state);
  }
  CHECK(bench.state.trust == Approx(0.6 + 1.0 / 16));  // it is slow again
  for (int n = 0; n < 8; ++n) {
    follow_swing(bench.state, kManyCounts / 4);
    watch_spin(bench.state);
    CHECK(bench.state.swing_counts < kManyCounts);
    CHECK(bench.state.swing_counts == bench.state.gone_counts);
    CHECK(bench.state.looked_counts == bench.state.swing_counts);
    CHECK(bench.state.flicker_counts <= bench.state.swing_counts);
  }
  bench.step(0.0, -5);
  CHECK(bench.state.way == -1);
  CHECK(bench.state.swing_counts == 5);
}

TEST_CASE("the bound begins at three times what is stable, and a hand's swing takes over 40 ms") {
  const BoundParams params =
      make_bound_params({12.0F, StabilityLimit::lag}, make_resolution(8192, 100'000), 0.1F, 6e-3F);
  CHECK(params.slope_nm_per_count == Approx(36.0 * 2.0 * 3.14159265358979 / 8192.0));
  CHECK(params.buzz_ticks == 400);
  CHECK(params.slow_ticks == 1500);
  CHECK(params.flicker_ticks == 10'000);
  CHECK(params.noise_ticks == 500);
  CHECK(params.quiet_share * params.slope_nm_per_count == Approx(6e-3));
}

TEST_CASE(
    "a bound that friction holds anyway, or no friction at all, leaves a share of 1/64 to 1") {
  const auto share = [](float friction_nm) {
    return make_bound_params({12.0F, StabilityLimit::lag}, make_resolution(8192, 100'000), 0.1F,
                             friction_nm)
        .quiet_share;
  };
  CHECK(share(1.0F) == 1.0F);
  CHECK(share(0.0F) == 1.0F / 64);
}

TEST_CASE("the bound begins no higher than where one count switches half the motor") {
  const BoundParams params =
      make_bound_params({12.0F, StabilityLimit::lag}, make_resolution(8192, 100'000), 0.05F, 6e-3F);
  CHECK(params.slope_nm_per_count == Approx(0.025));
}

TEST_CASE("a scene that is new comes up whole where the knob is; then its walls are bounded") {
  ControllerParams params;
  params.motion = make_motion_params(make_resolution(8192, 100'000), 32, false, 100);
  params.partition = {Law::motor_only, 0.0F, 10.0F, 0.0F};
  params.bound = {2.0F * params.motion.resolution.rad_per_count, 1.0F / 64, 400};
  Scene scene;
  scene.effect[0] = Wall{make_origin(0, 8192), -1.0F, 10.0F, 0.0F};
  scene.active = 1;
  ControllerState state;
  Plan plan;
  plan.pipeline = Pipeline::full;
  plan.bounds = true;
  std::uint32_t count = 100;
  (void)control(state, params, plan, count);
  state.motion.position_counts = 100;
  state.bound.new_scene = true;
  plan.scene = &scene;
  const double per_count = 2.0 * 3.14159265358979 / 8192.0;
  double wanted = 0.0;
  for (int n = 0; n < 4; ++n) {
    const auto out = control(state, params, plan, ++count);
    wanted = n == 0 ? -10.0 * 101 * per_count : wanted - 2.0 * per_count;
    CAPTURE(n);
    CHECK(static_cast<double>(out.desired_torque_nm) == Approx(wanted).scale(0).epsilon(1e-4));
  }
}

TEST_CASE("the ordinary tick bounds as the one with everything in it does, to the bit") {
  ControllerParams params;
  params.motion = make_motion_params(make_resolution(8192, 100'000), 32, false, 100);
  params.partition = {Law::calibrated, 0.5F, 0.5F, 0.2F};
  params.bound = {8.0F * params.motion.resolution.rad_per_count, 1.0F / 64, 400, 1500};
  params.assist = {2e-3F, 1e-3F};
  Scene scene;
  scene.effect[0] = Wall{make_origin(5LL << 19, 8192), -1.0F, 40.0F, 0.0F};  // five counts away
  scene.active = 1;
  CHECK_FALSE(plays_in_time(scene));
  const Plan all = plan_of(params, {}, {&scene});
  CHECK(all.pipeline == Pipeline::full);
  Plan ordinary = all;
  ordinary.pipeline = Pipeline::bounded;
  ControllerState one;
  ControllerState other;
  (void)control(one, params, all, 0);
  (void)control(other, params, all, 0);
  std::uint32_t count = 0;
  bool bounded = false;
  bool helped = false;  // in free air
  for (int n = 0; n < 4000; ++n) {
    // Fast swings from free air into the wall and out, with rests.
    const int phase = n % 60;
    count += phase < 25 ? 1U : phase < 50 ? 0xFFFFFFFFU : 0U;
    const auto a = control(one, params, all, count);
    const auto b = control(other, params, ordinary, count);
    bounded = bounded || other.bound.bounded;
    helped = helped || (a.desired_torque_nm == 0.0F && a.motor_command_nm != 0.0F);
    REQUIRE(a.desired_torque_nm == b.desired_torque_nm);
    REQUIRE(a.motor_command_nm == b.motor_command_nm);
    REQUIRE(a.brake_command_nm == b.brake_command_nm);
    REQUIRE(a.motor_saturated == b.motor_saturated);
    REQUIRE(a.brake_saturated == b.brake_saturated);
  }
  CHECK(bounded);
  CHECK(helped);
  CHECK(other.bound.share < 1.0F);
  CHECK(one.ledger.motor == other.ledger.motor);
  CHECK(one.ledger.spring_twice == other.ledger.spring_twice);
}

TEST_CASE(
    "a knob that is let off inside a wall gets no more than the bound's slope, at rest or "
    "pressed") {
  for (const int sign : {1, -1}) {
    BoundBench bench;
    BoundState& state = bench.state;
    state.params.held_nm = 0.009F;
    state.params.buzz_ticks = 800;
    set_share(state, 0.6F);
    state.on_line = true;
    state.asked_nm = 0.3F * static_cast<float>(sign);
    state.last_nm = kNoNumber;
    state.line_counts = 3.0F;
    state.rest_counts = 5.0F;
    state.way = sign;
    state.swing_counts = state.gone_counts = 20;
    let_off(state, 9000);
    CHECK(bench.step(0.3 * sign, 0) == 0.0);
    for (int n = 1; n <= 12; ++n) {
      CHECK(sign * bench.step(0.3 * sign, sign) == Approx(0.0));
    }
    for (int n = 1; n <= 12; ++n) {
      CHECK(sign * bench.step(0.3 * sign, -sign) <= 0.01 * n + 1e-6);
    }
  }
}

TEST_CASE("a torque that is none does not stay in the bound of an ordinary tick either") {
  for (const float none :
       {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
        std::numeric_limits<float>::quiet_NaN()}) {
    BoundBench bench;
    CHECK(bench.step(-0.1, 1) == Approx(-0.01));
    CHECK_FALSE(is_finite(static_cast<float>(bench.step(static_cast<double>(none), 1))));
    (void)bench.step(-0.005, 1);
    CHECK(bench.step(-0.005, 1) == Approx(-0.005));
  }
}

TEST_CASE("a scene whose torque is none gives nothing in an ordinary tick either") {
  ControllerParams params;
  params.motion = make_motion_params(make_resolution(8192, 100'000), 32, false, 100);
  params.partition = {Law::calibrated, 0.5F, 0.5F, 0.2F};
  Scene scene;
  scene.effect[0] = Wall{make_origin(0, 8192), -1.0F, std::numeric_limits<float>::infinity(), 0.0F};
  scene.active = 1;
  Plan ordinary = plan_of(params, {}, {&scene});
  ordinary.pipeline = Pipeline::bounded;
  ControllerState state;
  (void)control(state, params, ordinary, 0);
  const auto out = control(state, params, ordinary, 9);
  CHECK(out.numeric_error);
  CHECK(out.motor_command_nm == 0.0F);
  CHECK(out.brake_command_nm == 0.0F);
}

TEST_CASE("a torque that is none does not stay in the bound") {
  ControllerParams params;
  params.motion = make_motion_params(make_resolution(8192, 100'000), 32, false, 100);
  params.partition = {Law::motor_only, 0.0F, 10.0F, 0.0F};
  params.bound = {2.0F * params.motion.resolution.rad_per_count, 1.0F / 64, 400};
  ControllerState state;
  LocalModel broken;
  broken.torque_nm = std::numeric_limits<float>::infinity();
  Plan plan;
  plan.pipeline = Pipeline::full;
  plan.bounds = true;
  plan.local = &broken;
  CHECK(control(state, params, plan, 1).numeric_error);
  LocalModel sound;
  sound.torque_nm = 0.01F;
  plan.local = &sound;
  const auto out = control(state, params, plan, 2);
  CHECK_FALSE(out.numeric_error);
  CHECK(static_cast<double>(out.desired_torque_nm) == Approx(0.01));
}
