// The effect Impact against its closed form, and an energy balance of its own.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>

#include "core/scene.hpp"
#include "device/prepare.hpp"
#include "protocol/effects.hpp"

namespace core = torsio::core;
namespace wire = torsio::protocol;
using doctest::Approx;

namespace {

constexpr std::uint32_t kCounts = 32768;
constexpr std::uint32_t kPeriodNs = 50'000;
constexpr double kPeriodS = 50e-6;
constexpr double kRadPerCount = 2.0 * M_PI / kCounts;
constexpr std::uint64_t kRestTicks = 1000;  // 50 ms
const core::Resolution kResolution = core::make_resolution(kCounts, kPeriodNs);

/// A solid at angles above 0.
wire::Impact solid() {
  wire::Impact impact;
  impact.strength_nm_s_per_rad = 0.01F;
  impact.frequency_hz = 300.0F;
  impact.decay_s = 4e-3F;
  return impact;
}

/// One impact, evaluated where the test says; a tick goes by with each.
class Bench {
 public:
  explicit Bench(const wire::Impact& report) : scene_(std::make_unique<core::Scene>()) {
    REQUIRE(torsio::device::prepare(report, kResolution, scene_->effect[2]).ok());
    scene_->order[0] = 2;
    scene_->active = 1;
  }

  float at(std::int64_t counts, double speed_rad_s) {
    const auto delta = static_cast<std::int32_t>(counts - counts_);
    counts_ = counts;
    const core::Motion motion{counts, delta, static_cast<float>(delta * kRadPerCount),
                              static_cast<float>(speed_rad_s), 0.0F};
    const float torque_nm = core::add_impacts(*scene_, state_, motion, kResolution, tick_++,
                                              others_nm, 1.0F, range, lag);
    // Apart from the bound on torques that rise along the angle.
    if (core::evaluate_scene(*scene_, state_, motion, kResolution, tick_) != 0.0F) FAIL("twice");
    return torque_nm - others_nm;
  }

  /// The motor's other command, and its limit.
  float others_nm = 0.0F;
  core::MotorRange range{-100.0F, 100.0F};
  core::MotorLag lag;

  /// The largest torque in a second that it rests here.
  float largest_at_rest(std::int64_t counts) {
    float largest = 0.0F;
    for (int i = 0; i < 20'000; ++i) largest = std::max(largest, std::abs(at(counts, 0.0)));
    return largest;
  }

  void add(const wire::Impact& report) {
    REQUIRE(torsio::device::prepare(report, kResolution, scene_->effect[3]).ok());
    scene_->order[scene_->active++] = 3;
  }
  [[nodiscard]] float knock_nm() const { return state_.knock_nm; }
  void restart() { core::restart_effects(state_, 1U << 2U, tick_); }
  void pass(std::uint64_t ticks) { tick_ += ticks; }
  [[nodiscard]] const core::Scene& scene() const { return *scene_; }

 private:
  std::unique_ptr<core::Scene> scene_;
  core::SceneState state_;
  std::uint64_t tick_ = 0;
  std::int64_t counts_ = -100;
};

/// Comes in at 3 rad/s, a count in every other tick or so.
std::int64_t moving(int tick) {
  return static_cast<std::int64_t>(std::floor(3.0 * kPeriodS * tick / kRadPerCount));
}

}  // namespace

TEST_CASE("an impact is a decaying sine in proportion to the speed of the contact") {
  // The second has a motor with a lag.
  for (const bool above : {true, false}) {
    wire::Impact report = solid();
    if (!above) report.side = wire::Side::below;
    const int sign = above ? 1 : -1;
    Bench bench(report);
    if (!above) bench.lag = core::make_motor_lag(44e-6F, kResolution.period_s);
    CHECK_FALSE(core::plays_in_time(bench.scene()));
    CHECK(core::has_impacts(bench.scene()));
    for (int i = -20; i < 1; ++i) CHECK(bench.at(sign * (moving(i) - 1), sign * 3.0) == 0.0F);
    for (int i = 0; i < 1000; ++i) {
      const double time_s = i * kPeriodS;
      const double expected = i < 560  // seven times 4 ms
                                  ? -sign * 0.01 * 3.0 * std::exp(-time_s / 4e-3) *
                                        std::sin(2.0 * M_PI * 300.0 * time_s)
                                  : 0.0;
      // Afterwards only the direction of the speed matters.
      const float found = bench.at(sign * (moving(i) + 1), sign * (i == 0 ? 3.0 : 1.0));
      CHECK(found == Approx(expected).scale(0.03).epsilon(1e-4));
    }
  }
}

TEST_CASE("an impact's pulse lasts as long as it shall while the knob comes in") {
  wire::Impact report = solid();
  report.strength_nm_s_per_rad = 0.0F;
  report.pulse_nm_s_per_rad = 0.02F;
  report.pulse_s = 2e-3F;
  for (const int stops_at : {1000, 25}) {
    Bench bench(report);
    CHECK(bench.at(-10, 3.0) == 0.0F);
    for (int i = 0; i < 100; ++i) {
      const bool on = i < 40 && i < stops_at;
      CHECK(bench.at(1 + moving(std::min(i, stops_at)), i < stops_at ? 3.0 : 0.0) ==
            (on ? Approx(-0.06) : Approx(0.0)));
    }
  }
}

TEST_CASE("an impact stays within its torque, and is nothing outside or for whoever comes slowly") {
  wire::Impact report = solid();
  report.pulse_nm_s_per_rad = 100.0F;
  report.torque_limit_nm = 0.02F;
  {
    Bench bench(report);
    CHECK(bench.at(-10, 3.0) == 0.0F);
    CHECK(bench.at(1, 3.0) == -0.02F);
    CHECK(bench.at(2, 3.0) == -0.02F);
    CHECK(bench.at(0, -3.0) == 0.0F);
    CHECK(bench.at(1, 3.0) == 0.0F);  // it has not been away
  }
  for (const double slower : {0.99, 1.01}) {
    Bench bench(report);
    const double count_in_2_ms = kRadPerCount / 2e-3;
    CHECK(bench.at(-10, 0.0) == 0.0F);
    CHECK((bench.at(1, slower * count_in_2_ms) != 0.0F) == (slower > 1.0));
  }
  Bench inside(report);
  CHECK(inside.at(1, 3.0) == 0.0F);  // where it begins is no impact
  Bench anew(report);
  CHECK(anew.at(-10, 3.0) == 0.0F);
  CHECK(anew.at(1, 3.0) != 0.0F);
  anew.restart();
  CHECK(anew.at(2, 3.0) == 0.0F);
}

TEST_CASE("a knob that trembles at the surface knocks once") {
  const auto knocks = [](Bench& bench, std::int64_t away, std::uint64_t after_ticks) {
    CHECK(bench.largest_at_rest(-10) == 0.0F);
    bench.at(1, 3.0);
    CHECK(bench.at(2, 3.0) != 0.0F);
    bench.pass(after_ticks);
    bench.at(-away, -3.0);
    bench.at(-away, 3.0);
    bench.at(1, 3.0);
    return bench.at(2, 3.0) != 0.0F;
  };
  const auto fresh = [&](std::int64_t away, std::uint64_t after_ticks) {
    Bench bench(solid());
    return knocks(bench, away, after_ticks);
  };
  CHECK_FALSE(fresh(4, 10 * kRestTicks));
  CHECK(fresh(5, 10 * kRestTicks));
  CHECK_FALSE(fresh(5, kRestTicks - 10));
  CHECK(fresh(5, kRestTicks));
}

TEST_CASE("an impact gives no more than the motor has left, and nothing where nothing is left") {
  wire::Impact report = solid();
  report.pulse_nm_s_per_rad = 1.0F;
  for (const bool above : {true, false}) {
    report.side = above ? wire::Side::above : wire::Side::below;
    const float out = above ? -1.0F : 1.0F;
    Bench bench(report);
    bench.range = {-0.085F, 0.085F};
    bench.others_nm = out * 0.06F;
    const int sign = above ? 1 : -1;
    CHECK(bench.at(sign * -10, sign * 3.0) == 0.0F);
    CHECK(bench.at(sign * 1, sign * 3.0) == Approx(out * 0.025));
    bench.others_nm = out * 0.085F;
    CHECK(bench.at(sign * 2, sign * 3.0) == 0.0F);
    bench.others_nm = -out * 0.085F;
    CHECK(bench.at(sign * 3, sign * 3.0) == Approx(out * 0.17));
    // A tick may change less.
    bench.others_nm = 0.0F;
    bench.range = {-0.01F, 0.02F};
    CHECK(bench.at(sign * 4, sign * 3.0) == Approx(above ? -0.01 : 0.02));
  }
}

TEST_CASE("several impacts share the motor, and the sum of theirs is what it gives") {
  wire::Impact report = solid();
  report.pulse_nm_s_per_rad = 0.02F;  // 60 mN m
  Bench bench(report);
  bench.add(report);
  bench.range = {-0.085F, 0.085F};
  CHECK(bench.at(-10, 3.0) == 0.0F);
  CHECK(bench.at(1, 3.0) == Approx(-0.085));
  CHECK(bench.knock_nm() == Approx(-0.085));
  bench.range = {-1.0F, 1.0F};
  // The second gave 25 mN m while the knob came in by a count. It stays there.
  CHECK(bench.at(2, 3.0) == Approx(2.0 * (-0.06 - 0.03 * std::exp(-50e-6 / 4e-3) *
                                                      std::sin(2.0 * M_PI * 300.0 * 50e-6))));
}

TEST_CASE("an impact that was interrupted does not go on") {
  Bench bench(solid());
  CHECK(bench.at(-10, 3.0) == 0.0F);
  bench.at(1, 3.0);
  CHECK(bench.at(2, 3.0) != 0.0F);
  bench.pass(1);
  CHECK(bench.at(3, 3.0) == 0.0F);
}

TEST_CASE("where an impact is taken up again inside is no impact") {
  Bench bench(solid());
  CHECK(bench.at(-10, 3.0) == 0.0F);
  bench.pass(1);
  for (int i = 100; i < 200; ++i) CHECK(bench.at(i, 3.0) == 0.0F);
  // Outside it is ready at once.
  CHECK(bench.at(-10, 3.0) == 0.0F);
  bench.pass(1);
  CHECK(bench.at(-10, 3.0) == 0.0F);
  bench.at(1, 3.0);
  CHECK(bench.at(2, 3.0) != 0.0F);
}

TEST_CASE("an impact that has nothing left to give waits until the knob comes in again") {
  for (const int back : {1, 3}) {
    Bench bench(solid());
    bench.at(-10, 3.0);
    bench.at(5, 3.0);
    for (int i = 0; i < 15; ++i) bench.at(5, 0.0);  // a quarter of its period
    CHECK(bench.at(5 - back, -1.0) == 0.0F);
    CHECK(bench.at(5 - back, 0.0) == 0.0F);
    CHECK(bench.at(5, 1.0) < -0.01F);
  }
}

TEST_CASE("an impact never gives back more than it has taken, but for a tick's motion") {
  std::mt19937 random(20);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  int given_back = 0;
  for (int run = 0; run < 400; ++run) {
    wire::Impact report = solid();
    report.strength_nm_s_per_rad = static_cast<float>(between(0.0, 0.05));
    report.frequency_hz = static_cast<float>(between(1.0, 1000.0));
    report.decay_s = static_cast<float>(between(1e-3, 0.1));
    report.pulse_nm_s_per_rad = static_cast<float>(between(0.0, 0.05));
    report.pulse_s = static_cast<float>(between(0.0, 0.1));
    Bench bench(report);
    // A knob on a spring, pushed about at random: in, to and fro inside, and maybe out.
    core::MotionState tracked;
    const core::MotionParams params = core::make_motion_params(kResolution, 32, false, 100.0F);
    double angle = -0.01, speed = between(0.2, 15.0), push_nm = 0.0;
    const double stiffness = between(0.0, 40.0);
    // In every other run wall and knock are more than the motor has.
    const double motor_nm = run % 2 == 0 ? 100.0 : between(0.01, 0.2);
    bench.range = {static_cast<float>(-motor_nm), static_cast<float>(motor_nm)};
    double balance_j = 0.0, fastest_rad = 0.0, largest_nm = 0.0, worst_j = 0.0;
    for (int i = 0; i < 4000; ++i) {
      const double moved = speed * kPeriodS;
      angle += moved;
      const auto counts = static_cast<std::int64_t>(std::floor(angle / kRadPerCount));
      const core::Motion motion =
          core::track_motion(tracked, params, static_cast<std::uint32_t>(counts));
      // In counts, as a device sees it: the work of the torque held in this tick.
      const double moved_rad = motion.delta_counts * kRadPerCount;
      if (counts <= 0) balance_j = 0.0;  // outside, so that the next contact stands for itself
      balance_j -= push_nm * moved_rad;
      fastest_rad = std::max(fastest_rad, std::abs(moved_rad));
      const double depth_rad = std::max(0.0, static_cast<double>(counts) * kRadPerCount);
      const double wall_nm = -std::min(stiffness * depth_rad, motor_nm);
      bench.others_nm = static_cast<float>(wall_nm);
      push_nm = bench.at(counts, motion.speed_rad_s);
      largest_nm = std::max(largest_nm, std::abs(push_nm));
      worst_j = std::min(worst_j, balance_j);
      if (push_nm * motion.speed_rad_s > 0.0) ++given_back;
      CHECK(std::abs(wall_nm + push_nm) <= motor_nm * (1.0 + 1e-6));
      speed += (wall_nm + push_nm + between(-0.05, 0.05)) / 6e-5 * kPeriodS;
      if (i % 500 == 499) speed = between(-10.0, 10.0);
    }
    CAPTURE(run);
    CHECK(worst_j >= -largest_nm * (fastest_rad + kRadPerCount));
  }
  CHECK(given_back > 1000);  // the rule had something to do
}
