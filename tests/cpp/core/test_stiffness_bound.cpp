// The bound of the law calibrated, a step at a time, with numbers worked out by hand. Its effect is
// tested in tests/cpp/emulator/test_no_buzz.cpp.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <random>
#include <vector>

#include "bound_bench.hpp"
#include "core/controller.hpp"

namespace {

using namespace torsio::core;
using doctest::Approx;

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

TEST_CASE("the bound begins at three times what is stable, and a hand's swing takes over 40 ms") {
  const BoundParams params = make_bound_params({12.0F, StabilityLimit::lag}, 0.02F,
                                               make_resolution(8192, 100'000), 0.1F, 1e-4F, 6e-3F);
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
    return make_bound_params({12.0F, StabilityLimit::lag}, 0.02F, make_resolution(8192, 100'000),
                             0.1F, 1e-4F, friction_nm)
        .quiet_share;
  };
  CHECK(share(1.0F) == 1.0F);
  CHECK(share(0.0F) == 1.0F / 64);
}

TEST_CASE("the bound begins no higher than where one count switches half the motor") {
  const BoundParams params = make_bound_params({12.0F, StabilityLimit::lag}, 0.02F,
                                               make_resolution(8192, 100'000), 0.05F, 1e-4F, 6e-3F);
  CHECK(params.slope_nm_per_count == Approx(0.025));
}

TEST_CASE("a motor that is too weak to move the knob bounds nothing") {
  for (const float motor_nm : {0.0F, 5e-3F}) {
    Parts parts{5e-5F, 2e-4F, 1e-4F, 0.0F, 1e-4F, 6e-3F};
    parts.motor_torque_max_nm = motor_nm;
    const StableStiffness stable = stable_stiffness(parts);
    CHECK(stable.limited_by != StabilityLimit::counts);
    CHECK(stable.stiffness_nm_per_rad > 1000.0F);
    const BoundParams params =
        make_bound_params(stable, 0.02F, make_resolution(8192, 100'000), motor_nm, 1e-4F, 6e-3F);
    CHECK(params.slope_nm_per_count > 1.0F);
  }
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

TEST_CASE("a scene that is new ends the line of the one before, unless it asks nearly the same") {
  for (const float asked_nm : {-0.03F, -0.51F, 0.2F, 0.0F}) {
    BoundBench bench;
    bench.step(0.0, 1);
    bench.step(-0.4, 1);  // a line begins
    CHECK(bench.state.bounded);
    begin_scene(bench.state, asked_nm);
    CHECK(asked_torque(bench.state) == asked_nm);
    CHECK_FALSE(bench.state.bounded);
    CHECK_FALSE(bench.state.new_scene);
    const auto asked = static_cast<double>(asked_nm);
    CHECK(bench.step(asked, 0) == Approx(asked));
    CHECK(bench.step(asked, -1) == Approx(asked));
    CHECK(bench.step(asked, 1) == Approx(asked));
  }
  BoundBench bench;
  bench.step(0.0, 1);
  const double given_nm = bench.step(-0.4, 1);
  begin_scene(bench.state, -0.45F);
  CHECK(bench.step(-0.45, 0) == given_nm);
  CHECK(bench.state.bounded);
  BoundBench soft;
  soft.step(-0.1, 0, -0.1);
  begin_scene(soft.state, -0.12F);
  CHECK(soft.step(-0.12, -1) == Approx(-0.12));
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
