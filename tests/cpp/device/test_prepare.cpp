// Effects prepared for the tick: cases that no report's range shows.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <variant>

#include "device/prepare.hpp"

using namespace torsio;

TEST_CASE("a curve's span keeps its precision beyond 32 bits of turns") {
  const core::Resolution resolution = core::make_resolution(8192, 50'000);
  // One turn is 2^32. The last are a count below 2^39, halves between two floats, and both sides.
  for (const std::uint64_t span :
       {std::uint64_t{1} << 31, (std::uint64_t{1} << 32) - 1, std::uint64_t{1} << 32,
        (std::uint64_t{1} << 32) + 1, (std::uint64_t{3} << 32) + 12345,
        (std::uint64_t{1} << 39) - 1, (std::uint64_t{1} << 33) + 512,
        (std::uint64_t{1} << 33) + 513, (std::uint64_t{1} << 33) + 1536,
        (std::uint64_t{1} << 33) + 1535}) {
    CAPTURE(span);
    protocol::Curve report;
    report.points = 9;
    report.span_turns_q32 = span;
    core::Effect effect;
    REQUIRE(device::prepare(report, resolution, effect).ok());
    // The nearest float to the span, as the host's processor converts it, and then as prepare does.
    const float span_rad = static_cast<float>(span) * (core::kTwoPi * 0x1p-32F);
    CHECK(std::get<core::Curve>(effect).intervals_per_rad == 8.0F / span_rad);
  }
}

TEST_CASE("a sine ends at its last frequency, also where that takes a single slow tick") {
  const core::Resolution resolution = core::make_resolution(8192, 1'000'000);
  for (const float duration_s : {0.001F, 0.002F, 0.1F}) {
    for (const auto& [begin_hz, end_hz] :
         {std::pair{1000.0F, 0.0F}, {0.0F, 1000.0F}, {900.0F, 100.0F}, {50.0F, 750.0F}}) {
      CAPTURE(duration_s);
      CAPTURE(begin_hz);
      CAPTURE(end_hz);
      protocol::Excitation report;
      report.duration_s = duration_s;
      report.sine_begin_hz = begin_hz;
      report.sine_end_hz = end_hz;
      const core::Excitation sine = device::prepare(report, resolution);
      // Steps of the phase are modulo a turn, which is 2^64.
      std::uint64_t step = sine.sine_step_q64;
      const auto ticks = static_cast<unsigned>(std::lround(1000.0 * duration_s));
      for (unsigned tick = 0; tick < ticks; ++tick) {
        step += static_cast<std::uint64_t>(sine.sine_growth_q64);
      }
      const double turns = std::remainder(std::ldexp(static_cast<double>(step), -64), 1.0);
      CHECK(std::abs(std::remainder(turns - end_hz * 0.001, 1.0)) < 1e-6);
    }
  }
}
