#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "core/motion.hpp"

namespace core = torsio::core;

namespace {

core::MotionParams params(std::uint32_t bits = 32, bool reversed = false, float hz = 50.0F) {
  return core::make_motion_params(core::make_resolution(8192, 1'000'000), bits, reversed, hz);
}

}  // namespace

TEST_CASE("motion starts without a jump wherever the counter is") {
  core::MotionState state;
  const core::Motion motion = core::track_motion(state, params(), 0xDEADBEEF);
  CHECK(motion.delta_counts == 0);
  CHECK(motion.position_counts == 0);
}

TEST_CASE("a held knob leads a play of two counts to either side, until a hand leads it on") {
  for (const std::int32_t sign : {1, -1}) {
    core::MotionState state;
    std::int32_t count = 7;
    const auto step = [&](std::int32_t more) {
      count += sign * more;
      const auto counter = static_cast<std::uint32_t>(count) & 0xFFFF;
      return sign * core::track_motion(state, params(16), counter).delta_counts;
    };
    CHECK(step(0) == 0);
    CHECK(step(1) == 1);
    CHECK_FALSE(core::hold_count(state));
    for (const std::int32_t more : {1, 1, -3, -1, 2, 2}) CHECK(step(more) == 0);
    CHECK(core::hold_count(state));  // it is held already
    CHECK(step(1) == 1);
    for (const std::int32_t more : {-4, 1, 3}) CHECK(step(more) == 0);
    CHECK(step(3) == 3);
    CHECK(step(1) == 3);  // it was two counts behind
    CHECK(step(-1) == -1);
    core::hold_count(state);
    CHECK(step(2) == 0);
    core::release_count(state);
    CHECK(step(0) == 2);
    CHECK(state.position_counts == sign * 9);
  }
}

TEST_CASE("motion counts through the counter's wrap in both directions") {
  for (const std::uint32_t bits : {8U, 12U, 16U, 24U, 32U}) {
    CAPTURE(bits);
    const std::uint32_t mask = bits == 32 ? 0xFFFFFFFFU : (1U << bits) - 1;
    core::MotionState state;
    std::int64_t truth = 0;
    (void)core::track_motion(state, params(bits), 0);
    for (int i = 0; i < 5000; ++i) {
      truth += i < 2000 ? 97 : -61;
      const auto count = static_cast<std::uint32_t>(truth) & mask;
      const core::Motion motion = core::track_motion(state, params(bits), count);
      REQUIRE(motion.position_counts == truth);
      REQUIRE(motion.delta_counts == (i < 2000 ? 97 : -61));
    }
  }
}

TEST_CASE("a reversed encoder turns the sign") {
  core::MotionState state;
  (void)core::track_motion(state, params(32, true), 10);
  CHECK(core::track_motion(state, params(32, true), 15).position_counts == -5);
}

TEST_CASE("delta_rad is counts times the angle of a count") {
  core::MotionState state;
  (void)core::track_motion(state, params(), 0);
  CHECK(core::track_motion(state, params(), 3).delta_rad ==
        doctest::Approx(3.0 * 2.0 * M_PI / 8192.0));
}

TEST_CASE("the speed estimate answers to a step as a double pole does") {
  // Continuous double pole at w: v(t) = v (1 - (1 + w t) exp(-w t)) for a step of speed.
  const double bandwidth_hz = 20.0;
  const double w = 2.0 * M_PI * bandwidth_hz;
  const core::MotionParams p = params(32, false, static_cast<float>(bandwidth_hz));
  core::MotionState state;
  (void)core::track_motion(state, p, 0);
  const double rate = 40.0 * 2.0 * M_PI / 8192.0 * 1000.0;
  for (std::uint32_t i = 1; i <= 200; ++i) {
    const core::Motion motion = core::track_motion(state, p, 40 * i);
    const double t = (i - 0.5) * 1e-3;  // the sampled filter is centred half a period earlier
    const double exact = rate * (1.0 - (1.0 + w * t) * std::exp(-w * t));
    CHECK(std::abs(motion.speed_rad_s - exact) < 0.08 * rate);
    if (i == 200) CHECK(motion.speed_rad_s == doctest::Approx(rate).scale(0).epsilon(1e-5));
  }
}

TEST_CASE("the acceleration estimate settles on a constant acceleration") {
  const core::MotionParams p = params();
  core::MotionState state;
  core::Motion motion;
  for (std::uint32_t i = 0; i < 400; ++i) motion = core::track_motion(state, p, 3 * i * i);
  // 3 i^2 counts: second difference 6 counts per tick^2.
  CHECK(motion.acceleration_rad_s2 ==
        doctest::Approx(6.0 * 2.0 * M_PI / 8192.0 * 1e6).scale(0).epsilon(1e-3));
}

TEST_CASE("a knob at rest ends at exactly zero speed, without subnormals") {
  core::MotionState state;
  (void)core::track_motion(state, params(), 0);
  for (std::uint32_t i = 1; i < 50; ++i) (void)core::track_motion(state, params(), 17 * i);
  core::Motion motion;
  for (int i = 0; i < 2000; ++i) motion = core::track_motion(state, params(), 17 * 49);
  CHECK(motion.speed_rad_s == 0.0F);
  CHECK(motion.acceleration_rad_s2 == 0.0F);
}
