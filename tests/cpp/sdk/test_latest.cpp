// A program's own loop: the newest sample, how old it is, and steps at equal distances.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "torsio/knob.hpp"

using namespace torsio;

namespace {

Knob open_at(double control_rate_hz) {
  EmulatorOptions emulator;
  emulator.control_rate_hz = control_rate_hz;
  return Knob::open("emulated", {.emulator = emulator});
}

/// The oldest that the newest sample is in 99 of 100 steps of a loop at 1 kHz.
double age_s(Knob& knob) {
  std::vector<double> ages;
  for (const Step step : knob.every(0.001)) {
    ages.push_back(knob.emulator().time_s() - knob.latest().time_s);
    if (step.index == 999) break;
  }
  std::ranges::sort(ages);
  return ages[989];
}

}  // namespace

TEST_CASE("the newest sample is one frame and one tick old at most, at any rate") {
  for (const double control_rate_hz : {1000.0, 10'000.0, 20'000.0}) {
    for (const double sample_rate_hz : {1000.0, 2000.0, 4000.0, control_rate_hz}) {
      if (sample_rate_hz > control_rate_hz) continue;
      CAPTURE(control_rate_hz);
      CAPTURE(sample_rate_hz);
      Knob knob = open_at(control_rate_hz);
      // With fewer samples than ticks a sample's distance.
      const double true_rate_hz = knob.start_telemetry(sample_rate_hz, true);
      CHECK(age_s(knob) <= 0.001 + 1.0 / true_rate_hz + 1e-9);
    }
  }
}

TEST_CASE("prompt telemetry recovers from acknowledgements that take its frames") {
  Knob knob = open_at(20'000.0);
  knob.start_telemetry(4000.0, true);
  for (int i = 0; i < 50; ++i) knob.play(Constant{.torque_nm = 1e-4 * i});
  CHECK(age_s(knob) <= 0.001 + 1.0 / 4000.0 + 1e-9);
}

TEST_CASE("without prompt the newest sample is older: full reports come later") {
  Knob knob = open_at(1000.0);
  knob.start_telemetry(1000.0);
  CHECK(age_s(knob) > 0.002);
}

TEST_CASE("prompt telemetry loses nothing that a report has room for") {
  Knob knob = open_at(10'000.0);
  CHECK(knob.start_telemetry({}, true) == doctest::Approx(2000.0));
  CHECK(knob.record(0.5).size() == 1000);
  for (int i = 0; i < 50; ++i) knob.play(Constant{.torque_nm = 1e-4 * i});
  knob.sleep(0.01);
  CHECK(knob.statistics().samples_lost == 0);
}

TEST_CASE("prompt telemetry of every tick leaves out what is older, and counts it") {
  Knob knob = open_at(10'000.0);
  CHECK(knob.start_telemetry(10'000.0, true) == doctest::Approx(10'000.0));
  CHECK_THROWS_AS(knob.start_telemetry(10'001.0, true), InvalidArgument);
  CHECK_THROWS_AS(knob.start_telemetry(10'000.0), InvalidArgument);
  knob.sleep(0.1);
  // The newest four of ten in a frame.
  CHECK(knob.statistics().samples_lost == doctest::Approx(600.0).epsilon(0.05));
  CHECK(knob.read(4096, 0.0).size() == doctest::Approx(400.0).epsilon(0.05));
}

TEST_CASE("the newest sample can still be read, and needs telemetry") {
  Knob knob = open_at(1000.0);
  CHECK_THROWS_AS((void)knob.latest(), Error);
  knob.start_telemetry({}, true);
  const TelemetrySample first = knob.latest();  // waits for it
  CHECK(knob.read(4, 0.0).back() == first);
  knob.sleep(0.01);
  CHECK(knob.latest().tick > first.tick);
  // An earlier stream's sample is not the newest of the next stream.
  knob.stop_telemetry();
  knob.sleep(0.01);
  const std::uint64_t restart_tick = knob.clock().tick;
  knob.start_telemetry({}, true);
  CHECK(knob.latest().tick > restart_tick);
}

TEST_CASE("steps lie at equal distances, and late ones are left out and counted") {
  Knob knob = open_at(1000.0);
  knob.sleep(0.05);
  Steps steps = knob.every(0.002);
  const double begin_s = knob.emulator().time_s();
  CHECK(steps.wait().time_s == 0.0);
  CHECK(steps.wait().time_s == doctest::Approx(0.002));
  CHECK(knob.emulator().time_s() - begin_s == doctest::Approx(0.002));
  knob.sleep(0.0071);
  // Due were 4, 6 and 8 ms; at 9.1 ms the last of them is the one to take.
  const Step late = steps.wait();
  CHECK(late.index == 2);
  CHECK(late.time_s == doctest::Approx(0.008));
  CHECK(late.late_steps == 2);
  CHECK(steps.wait().time_s == doctest::Approx(0.010));
  for (const double period_s : {0.0, 1e-5, 1e5, -1.0, std::nan("")}) {
    CHECK_THROWS_AS((void)knob.every(period_s), InvalidArgument);
  }
}
