// Effects as they travel, made ready for the tick: what no report's range shows.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
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
