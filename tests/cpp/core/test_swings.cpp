// What the bound learns from the knob's motion, with numbers worked out by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <utility>

#include "bound_bench.hpp"
#include "core/controller.hpp"

namespace {

using namespace torsio::core;
using doctest::Approx;

}  // namespace

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

TEST_CASE("virtual inertia that makes a creeping count flicker is taken back until a wide swing") {
  // For each count on, two to and fro or one.
  for (const int period : {5, 3}) {
    BoundBench bench;
    bench.state.params.flicker_ticks = 1000;
    for (int n = 0; n < 60; ++n) bench.step(0.0, n % period <= period / 2 ? 1 : -1);
    CHECK(bench.state.calm < 1.0F);
    CHECK(bench.state.trust == 1.0F);
    bench.swing(20, 1);
    bench.swing(20, -1);
    CHECK(bench.state.calm == 1.0F);
  }
}

TEST_CASE("a knob that goes on, or flickers now and then, keeps its virtual inertia") {
  BoundBench on;
  on.state.params.flicker_ticks = 1000;
  for (int n = 0; n < 600; ++n) on.step(0.0, n % 5 < 4 ? 1 : -1);  // one to and fro, three on
  CHECK(on.state.calm == 1.0F);

  BoundBench rests;
  rests.state.params.flicker_ticks = 5;
  for (int n = 0; n < 400; ++n) rests.step(0.0, n % 10 != 0 ? 0 : n % 20 != 0 ? 1 : -1);
  CHECK(rests.state.calm == 1.0F);
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

TEST_CASE("in a scene that is hardly steep the bound goes down from the sixteenth swing on") {
  struct Swings {
    float risen_nm;
    bool bounded;
    int first;
  };
  // A third of the bound over 20 counts is 0.067 N m.
  for (const Swings& of : {Swings{0.0F, false, 16}, Swings{0.06F, false, 16},
                           Swings{0.07F, false, 2}, Swings{0.0F, true, 2}}) {
    BoundBench bench;
    bench.state.in_time_nm = 0.0F;
    bench.swing(20, 1);
    double trust = 1.0;
    for (int n = 1; n <= 17; ++n) {
      bench.state.turned_nm = of.risen_nm;
      bench.state.was_bounded = of.bounded;
      bench.swing(20, n % 2 == 0 ? 1 : -1);
      if (n > 1) trust = std::max(0.6 * trust, 1.0 / 64);
      CHECK((bench.state.share == 1.0F) == (n < of.first));
      CHECK(static_cast<double>(bench.state.trust) == Approx(trust));
    }
  }
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
