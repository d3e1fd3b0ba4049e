// Every effect against its closed form in double precision.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>

#include "core/scene.hpp"

namespace core = torsio::core;
using doctest::Approx;

namespace {

constexpr std::uint32_t kCounts = 8192;
const core::Resolution kResolution = core::make_resolution(kCounts, 1'000'000);
constexpr double kRadPerCount = 2.0 * M_PI / kCounts;

core::Origin origin_at(double angle_rad) {
  return core::make_origin(std::llround(angle_rad / (2.0 * M_PI) * 4294967296.0), kCounts);
}

/// One effect in slot 3, evaluated where and when the test says.
class Bench {
 public:
  explicit Bench(const core::Effect& effect) : scene_(std::make_unique<core::Scene>()) {
    scene_->effect[3] = effect;
    scene_->order[0] = 3;
    scene_->active = 1;
  }
  core::Scene& scene() { return *scene_; }

  float at(std::int64_t counts, float speed = 0.0F, std::uint64_t tick = 0, std::int32_t delta = 0,
           float acceleration = 0.0F) {
    const core::Motion motion{counts, delta, static_cast<float>(delta * kRadPerCount), speed,
                              acceleration};
    return core::evaluate_scene(*scene_, state_, motion, kResolution, tick);
  }

 private:
  std::unique_ptr<core::Scene> scene_;
  core::SceneState state_;
};

}  // namespace

TEST_CASE("a wall above pushes down by stiffness times depth and never pulls") {
  Bench bench(core::Wall{origin_at(0.5), -1.0F, 1.43F, 0.01F});
  const double surface = 0.5 / kRadPerCount;
  CHECK(bench.at(static_cast<std::int64_t>(surface)) == 0.0F);
  const auto inside = static_cast<std::int64_t>(surface) + 40;
  const double depth = static_cast<double>(inside) * kRadPerCount - 0.5;
  CHECK(bench.at(inside) == Approx(-1.43 * depth).scale(0).epsilon(1e-5));
  CHECK(bench.at(inside, 2.0F) == Approx(-1.43 * depth - 0.01 * 2.0).scale(0).epsilon(1e-5));
  CHECK(bench.at(inside, -1.0F) == Approx(-1.43 * depth + 0.01).scale(0).epsilon(1e-5));
  CHECK(bench.at(inside, -100.0F) == 0.0F);
}

TEST_CASE("a wall below pushes up") {
  Bench bench(core::Wall{origin_at(-0.25), 1.0F, 2.0F, 0.0F});
  CHECK(bench.at(0) == 0.0F);
  const double angle = -400 * kRadPerCount;
  CHECK(bench.at(-400) == Approx(2.0 * (-0.25 - angle)).scale(0).epsilon(1e-5));
}

TEST_CASE("a wall is as exact after 1000 hours of turning as at the start") {
  const std::int64_t turns = 36'000'000;
  Bench near(core::Wall{core::make_origin(0, kCounts), -1.0F, 1.43F, 0.0F});
  Bench far(core::Wall{core::make_origin(turns << 32, kCounts), -1.0F, 1.43F, 0.0F});
  for (const int counts : {-5, 0, 1, 17, 900}) {
    CHECK(near.at(counts) == far.at(turns * kCounts + counts));
  }
}

TEST_CASE("end stops are two walls that face each other") {
  Bench bench(
      core::EndStops{{origin_at(-1.0), 1.0F, 3.0F, 0.0F}, {origin_at(1.0), -1.0F, 3.0F, 0.0F}});
  CHECK(bench.at(0) == 0.0F);
  CHECK(bench.at(1500) == Approx(-3.0 * (1500 * kRadPerCount - 1.0)).scale(0).epsilon(1e-5));
  CHECK(bench.at(-1500) == Approx(3.0 * (1500 * kRadPerCount - 1.0)).scale(0).epsilon(1e-5));
}

TEST_CASE("a spring has a dead band and a limit") {
  Bench bench(core::Spring{origin_at(0.0), 1.0F, 0.1F, 0.05F});
  CHECK(bench.at(100) == 0.0F);
  CHECK(bench.at(150) == Approx(-(150 * kRadPerCount - 0.1)).scale(0).epsilon(1e-4));
  CHECK(bench.at(-150) == Approx(150 * kRadPerCount - 0.1).scale(0).epsilon(1e-4));
  CHECK(bench.at(4000) == -0.05F);
  CHECK(bench.at(-4000) == 0.05F);
}

TEST_CASE("damper and inertia oppose speed and acceleration within their limits") {
  Bench damper(core::Damper{0.004F, 0.02F});
  CHECK(damper.at(0, 3.0F) == Approx(-0.012));
  CHECK(damper.at(0, -300.0F) == 0.02F);
  Bench inertia(core::Inertia{2e-5F, 0.02F});
  CHECK(inertia.at(0, 0.0F, 0, 0, 100.0F) == Approx(-2e-3));
  CHECK(inertia.at(0, 0.0F, 0, 0, -1e6F) == 0.02F);
}

TEST_CASE("friction sticks like a spring, slides at its torque and sticks again on reversal") {
  Bench bench(core::Friction{2.0F, 0.01F});  // 0.02 N m
  double truth = 0.0;
  std::int64_t counts = 0;
  for (int i = 0; i < 200; ++i) {
    const int delta = i < 60 ? 1 : i < 140 ? -2 : 1;
    counts += delta;
    // Elastic-plastic element, in doubles.
    truth = std::clamp(truth + delta * kRadPerCount, -0.01, 0.01);
    CHECK(bench.at(counts, 0.0F, 0, delta) == Approx(-2.0 * truth).scale(0).epsilon(1e-4));
  }
}

TEST_CASE("a timed torque waits, rises, holds, fades and ends") {
  core::Timing timing;
  timing.delay_ticks = 10;
  timing.duration_ticks = 100;
  timing.attack_ticks = 20;
  timing.fade_ticks = 40;
  timing.attack_level = 0.25F;
  timing.attack_rise_per_tick = 0.75F / 20;
  timing.fade_level = 0.5F;
  timing.fade_fall_per_tick = 0.5F / 40;
  Bench bench(core::Constant{0.04F, timing});
  for (std::uint64_t tick = 0; tick < 130; ++tick) {
    const double t = static_cast<double>(tick) - 10.0;
    double level = 1.0;
    if (t < 0 || t >= 100) {
      level = 0.0;
    } else if (t < 20) {
      level = 0.25 + 0.75 * t / 20.0;
    } else if (t > 60) {
      level = 0.5 + 0.5 * (100.0 - t) / 40.0;
    }
    CHECK(bench.at(0, 0.0F, tick) == Approx(0.04 * level).scale(0.04).epsilon(1e-5));
  }
}

TEST_CASE("a ramp goes from start to end over its duration") {
  core::Timing timing;
  timing.duration_ticks = 200;
  Bench bench(core::Ramp{-0.01F, 0.05F / 200, timing});
  for (std::uint64_t tick = 0; tick < 200; tick += 7) {
    CHECK(bench.at(0, 0.0F, tick) ==
          Approx(-0.01 + 0.05 * static_cast<double>(tick) / 200.0).scale(0).epsilon(1e-5));
  }
  CHECK(bench.at(0, 0.0F, 200) == 0.0F);
}

TEST_CASE("periodic effects follow their waveform in time") {
  const double frequency_hz = 7.0;
  const auto step = static_cast<std::uint32_t>(std::llround(frequency_hz * 1e-3 * 4294967296.0));
  const double start = 0.125;
  using Wave = std::function<double(double)>;  // phase in turns, [0, 1)
  const std::pair<core::Waveform, Wave> cases[] = {
      {core::Waveform::sine, [](double u) { return std::sin(2.0 * M_PI * u); }},
      {core::Waveform::square, [](double u) { return u < 0.5 ? 1.0 : -1.0; }},
      {core::Waveform::triangle,
       [](double u) { return u < 0.25   ? 4 * u
                             : u < 0.75 ? 2 - 4 * u
                                        : 4 * u - 4; }},
      {core::Waveform::sawtooth_up, [](double u) { return 2 * u - 1; }},
      {core::Waveform::sawtooth_down, [](double u) { return 1 - 2 * u; }},
  };
  for (const auto& [waveform, wave] : cases) {
    CAPTURE(static_cast<int>(waveform));
    Bench bench(core::Periodic{
        waveform, 0.03F, 0.01F, static_cast<std::uint32_t>(start * 4294967296.0), step, {}});
    for (std::uint64_t tick = 0; tick < 2000; tick += 3) {
      const double phase =
          start + static_cast<double>(step) * static_cast<double>(tick) / 4294967296.0;
      const double u = phase - std::floor(phase);
      CHECK(bench.at(0, 0.0F, tick) ==
            Approx(0.01 + 0.03 * wave(u)).scale(0).epsilon(1e-4).scale(0.03));
    }
  }
}

TEST_CASE("an endless periodic effect keeps its phase after a week at 20 kHz") {
  const std::uint32_t step = 1U << 20;  // a period of 4096 ticks
  Bench bench(core::Periodic{core::Waveform::sine, 1.0F, 0.0F, 0, step, {}});
  const std::uint64_t week = std::uint64_t{7} * 86'400 * 20'000 / 4096 * 4096;
  CHECK(bench.at(0, 0.0F, week + 1024) == bench.at(0, 0.0F, 1024));
}

TEST_CASE("detents pull into the notch with the chosen profile") {
  const auto pitch_counts = 8192 / 32;
  const core::Pattern pattern = core::make_pattern(0, std::uint64_t{32} << 32, kCounts);
  Bench sine(core::Detents{pattern, 0.02F, core::DetentProfile::sine, 4.0F});
  Bench linear(core::Detents{pattern, 0.02F, core::DetentProfile::linear, 4.0F});
  Bench click(core::Detents{pattern, 0.02F, core::DetentProfile::click, 4.0F});
  for (int counts = -1000; counts < 1000; ++counts) {
    double u = static_cast<double>(counts) / pitch_counts;
    u -= std::floor(u + 0.5);  // [-1/2, 1/2)
    CHECK(sine.at(counts) ==
          Approx(-0.02 * std::sin(2.0 * M_PI * u)).scale(0).epsilon(1e-4).scale(0.02));
    CHECK(linear.at(counts) == Approx(-0.04 * u).scale(0).epsilon(1e-5).scale(0.02));
    CHECK(click.at(counts) ==
          Approx(-0.02 * std::clamp(4.0 * u, -1.0, 1.0)).scale(0).epsilon(1e-5).scale(0.02));
  }
}

TEST_CASE("a texture repeats each turn, stays within its torque and depends on the seed") {
  const std::uint64_t turn_step =
      core::make_pattern(0, std::uint64_t{1} << 32, kCounts).cycles_per_count_q64;
  Bench one(core::Texture{turn_step, 100, 0.01F, core::Grain::noise, 1});
  Bench two(core::Texture{turn_step, 100, 0.01F, core::Grain::noise, 2});
  double difference = 0.0;
  double sum = 0.0;
  float last = one.at(-1);
  for (int counts = 0; counts < 8192; ++counts) {
    const float here = one.at(counts);
    CHECK(std::abs(here) <= 0.01F);
    CHECK(one.at(counts + 8192LL * 1'000'003) == Approx(here).scale(0).epsilon(1e-3).scale(0.01));
    // Smooth: the steepest slope of a smoothstep is 1.5 over a grain.
    CHECK(std::abs(here - last) <= 1.01 * 1.5 * 0.02 * 100.0 / 8192.0);
    last = here;
    difference += std::abs(here - two.at(counts));
    sum += here;
  }
  CHECK(difference / 8192 > 1e-3);
  CHECK(std::abs(sum / 8192) < 2e-3);  // no bias that would drive the knob

  Bench square(core::Texture{turn_step, 64, 0.01F, core::Grain::square, 0});
  CHECK(square.at(0) == 0.01F);
  CHECK(square.at(63) == 0.01F);
  CHECK(square.at(64) == -0.01F);
  CHECK(square.at(127) == -0.01F);
  CHECK(square.at(-1) == -0.01F);
}

TEST_CASE("a curve joins its points by lines, holds or repeats") {
  const std::uint64_t quarter = std::uint64_t{1} << 30;
  core::Curve curve;
  curve.pattern = core::make_pattern_of_span(0, quarter, kCounts);
  curve.intervals = 4;
  curve.first_point = 7;
  curve.intervals_per_rad = static_cast<float>(4.0 / (M_PI / 2.0));
  const double points[] = {0.01, 0.03, -0.02, 0.0, 0.05};
  for (const bool repeats : {false, true}) {
    curve.repeats = repeats;
    Bench bench(curve);
    for (int i = 0; i < 5; ++i) {
      bench.scene().curve_torque_nm[static_cast<std::size_t>(7 + i)] =
          static_cast<float>(points[i]);
    }
    for (int counts = -3000; counts < 5000; counts += 13) {
      double place = counts / 512.0;  // a quarter turn is 2048 counts, 4 intervals
      if (repeats) {
        place -= 4.0 * std::floor(place / 4.0);
      } else {
        place = std::clamp(place, 0.0, 4.0);
      }
      const int i = std::min(static_cast<int>(place), 3);
      const double exact = points[i] + (points[i + 1] - points[i]) * (place - i);
      CHECK(bench.at(counts) == Approx(exact).scale(0).epsilon(1e-4).scale(0.05));
    }
  }
}

TEST_CASE("sixteen effects add up, slots that do not play are not looked at") {
  auto scene = std::make_unique<core::Scene>();
  core::SceneState state;
  double sum = 0.0;
  for (std::uint8_t slot = 0; slot < core::kMaxEffects; ++slot) {
    const float torque = 0.001F * static_cast<float>(slot + 1);
    scene->effect[slot] = core::Constant{torque, {}};
    scene->order[slot] = slot;
    sum += 0.001 * (slot + 1);
  }
  scene->active = 16;
  const core::Motion still;
  CHECK(core::evaluate_scene(*scene, state, still, kResolution, 0) == Approx(sum));
  scene->active = 3;
  CHECK(core::evaluate_scene(*scene, state, still, kResolution, 0) == Approx(0.006));
}

TEST_CASE("effects begin when they are restarted") {
  auto scene = std::make_unique<core::Scene>();
  core::SceneState state;
  core::Timing timing;
  timing.duration_ticks = 10;
  scene->effect[2] = core::Constant{0.02F, timing};
  scene->order[0] = 2;
  scene->active = 1;
  const core::Motion still;
  CHECK(core::evaluate_scene(*scene, state, still, kResolution, 50) == 0.0F);
  core::restart_effects(state, 1U << 2, 50);
  CHECK(core::evaluate_scene(*scene, state, still, kResolution, 50) == 0.02F);
  CHECK(core::evaluate_scene(*scene, state, still, kResolution, 59) == 0.02F);
  CHECK(core::evaluate_scene(*scene, state, still, kResolution, 60) == 0.0F);
}

TEST_CASE("a local model is a torque, a spring and a damper about its reference") {
  const core::LocalModel model{0.01F, origin_at(0.2), 1.5F, 0.003F};
  const core::Motion motion{600, 0, 0.0F, 2.0F, 0.0F};
  CHECK(core::evaluate_local_model(model, core::SceneState{}, motion, kResolution) ==
        Approx(0.01 - 1.5 * (600 * kRadPerCount - 0.2) - 0.006).scale(0).epsilon(1e-5));
}

TEST_CASE("a damped wall that is not reached yet gives nothing, however fast it is approached") {
  core::SceneState state;
  auto scene = std::make_unique<core::Scene>();
  scene->effect[0] = core::Wall{{100, 0, 0.0F}, -1.0F, 1.0F, 0.01F};
  scene->active = 1;
  const core::Motion motion{99, 50, 0.04F, 40.0F, 0.0F};
  CHECK(core::evaluate_scene(*scene, state, motion, kResolution, 5) == 0.0F);
}

TEST_CASE("a torque without end is silent before its delay, and friction begins relaxed") {
  core::SceneState state;
  auto scene = std::make_unique<core::Scene>();
  core::Timing timing;
  timing.delay_ticks = 10;
  scene->effect[0] = core::Constant{0.02F, timing};
  scene->active = 1;
  for (std::uint64_t tick = 0; tick < 20; ++tick) {
    CHECK(core::evaluate_scene(*scene, state, {}, kResolution, tick) == (tick < 10 ? 0.0F : 0.02F));
  }
  state.twist_rad[3] = 0.1F;
  core::restart_effects(state, 1U << 3U, 5);
  CHECK(state.twist_rad[3] == 0.0F);
}
