// The oracle is 128-bit integer arithmetic.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <random>

#include "core/angle.hpp"

namespace core = torsio::core;

__extension__ using Wide = __int128;
__extension__ using WideUnsigned = unsigned __int128;

TEST_CASE("make_origin is exact for any angle and encoder") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20'000; ++i) {
    const auto angle = static_cast<std::int64_t>(random()) >> 6;
    const auto counts_per_rev = static_cast<std::uint32_t>(4 + random() % (1U << 24));
    const core::Origin origin = core::make_origin(angle, counts_per_rev);
    const Wide exact = static_cast<Wide>(angle) * counts_per_rev;
    CHECK((static_cast<Wide>(origin.counts) << 32) + origin.fraction_q32 == exact);
  }
}

TEST_CASE("offset_rad is the distance in radians, near and after 1000 hours of turning") {
  const std::uint32_t counts_per_rev = 8192;
  const core::Resolution r = core::make_resolution(counts_per_rev, 1'000'000);
  for (const std::int64_t turns : {0LL, 1LL, -7LL, 36'000'000LL, -36'000'000LL}) {
    // A reference a third of a count past the turn, a position 100 counts past it.
    const std::int64_t third_of_count = (std::int64_t{1} << 32) / 3 / counts_per_rev;
    const core::Origin origin = core::make_origin((turns << 32) + third_of_count, counts_per_rev);
    const float offset = core::offset_rad(turns * counts_per_rev + 100, origin, r.rad_per_count);
    const double part = static_cast<double>(third_of_count) * counts_per_rev / 4294967296.0;
    CHECK(offset == doctest::Approx((100.0 - part) * 2.0 * M_PI / 8192.0).scale(0).epsilon(1e-6));
  }
}

TEST_CASE("offset_rad holds far away instead of wrapping") {
  const core::Resolution r = core::make_resolution(8192, 1'000'000);
  const core::Origin origin = core::make_origin(0, 8192);
  CHECK(core::offset_rad(std::int64_t{1} << 50, origin, r.rad_per_count) > 8e5F);
  CHECK(core::offset_rad(-(std::int64_t{1} << 50), origin, r.rad_per_count) < -8e5F);
}

TEST_CASE("divide_2_96 is the integer quotient") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20'000; ++i) {
    const std::uint64_t divisor =
        ((random() | 1) >> (1 + random() % 30)) + (std::uint64_t{1} << 32);
    const auto exact = static_cast<std::uint64_t>((static_cast<WideUnsigned>(1) << 96) / divisor);
    CHECK(core::divide_2_96(divisor) == exact);
  }
}

TEST_CASE("pattern_phase stays exact after any number of turns") {
  std::mt19937_64 random(3);
  for (int i = 0; i < 20'000; ++i) {
    const auto counts_per_rev = static_cast<std::uint32_t>(100 + random() % 100'000);
    const std::uint64_t per_turn = 1 + random() % (counts_per_rev / 2);
    const auto position =
        static_cast<std::int64_t>(random() % (std::uint64_t{1} << 39)) - (std::int64_t{1} << 38);
    const core::Pattern pattern = core::make_pattern(0, per_turn << 32, counts_per_rev);
    // (position * per_turn / counts_per_rev) modulo 1, in integers.
    Wide rest = (static_cast<Wide>(position) * static_cast<Wide>(per_turn)) %
                static_cast<Wide>(counts_per_rev);
    if (rest < 0) rest += counts_per_rev;
    const double exact = static_cast<double>(rest) / counts_per_rev;
    const double phase = core::pattern_phase(position, pattern) / 4294967296.0;
    const double error = std::remainder(phase - exact, 1.0);
    CHECK(std::abs(error) < 1e-7);  // 2^38 counts times 2^-64, and the rounding to 32 bits
  }
}

TEST_CASE("make_pattern_of_span repeats with the span") {
  const std::uint64_t third_of_turn = (std::uint64_t{1} << 32) / 3;
  const core::Pattern pattern = core::make_pattern_of_span(0, third_of_turn, 9000);
  CHECK(core::pattern_phase(1500, pattern) / 4294967296.0 == doctest::Approx(0.5));
  CHECK(core::pattern_phase(1500 + 3000 * 1000, pattern) / 4294967296.0 ==
        doctest::Approx(0.5).scale(0).epsilon(1e-5));
}

TEST_CASE("offset_rad holds from 2^30 counts on, either way") {
  constexpr std::int64_t most = std::int64_t{1} << 30;
  const float end = core::offset_rad(most, {}, 1.0F);
  for (const std::int64_t beyond : {most + 1000, 2 * most - 1, 2 * most, 40 * most}) {
    CHECK(core::offset_rad(beyond, {}, 1.0F) == end);
    CHECK(core::offset_rad(-beyond, {}, 1.0F) == -end);
  }
}
