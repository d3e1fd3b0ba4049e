// The oracle is the double precision library of the host.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math.hpp"

namespace core = torsio::core;

TEST_CASE("what is smaller than any torque is nothing, either way") {
  for (const float sign : {1.0F, -1.0F}) {
    CHECK(core::flush_tiny(sign * 9e-21F) == 0.0F);
    CHECK(core::flush_tiny(sign * 2e-20F) == sign * 2e-20F);
    CHECK(core::flush_tiny_number(sign * 9e-21F) == 0.0F);
    CHECK(core::flush_tiny_number(sign * 2e-20F) == sign * 2e-20F);
  }
}

TEST_CASE("sin_phase agrees with the library over the whole turn") {
  double worst = 0.0;
  for (std::uint64_t phase = 0; phase < (std::uint64_t{1} << 32); phase += 65'521) {
    const double exact = std::sin(2.0 * M_PI * static_cast<double>(phase) / 4294967296.0);
    worst = std::max(worst, std::abs(core::sin_phase(static_cast<std::uint32_t>(phase)) - exact));
  }
  CHECK(worst < 2e-7);
  CHECK(core::sin_phase(0) == 0.0F);
  CHECK(core::sin_phase(0x40000000U) == doctest::Approx(1.0));
  CHECK(core::sin_phase(0x80000000U) == 0.0F);
  CHECK(core::sin_phase(0xC0000000U) == doctest::Approx(-1.0));
}

TEST_CASE("exp_negative agrees with the library from 0 to underflow") {
  for (double x = 0.0; x < 86.0; x += 0.0137) {
    const auto argument = static_cast<float>(x);
    const double exact = std::exp(-static_cast<double>(argument));
    CHECK(std::abs(core::exp_negative(argument) / exact - 1.0) < 3e-7);
  }
  CHECK(core::exp_negative(0.0F) == 1.0F);
  CHECK(core::exp_negative(1e9F) == 0.0F);
  CHECK(core::exp_negative(std::numeric_limits<float>::infinity()) == 0.0F);
  CHECK(core::exp_negative(std::numeric_limits<float>::quiet_NaN()) == 0.0F);
}

TEST_CASE("is_finite refuses NaN and infinities only") {
  using Limits = std::numeric_limits<float>;
  CHECK(core::is_finite(0.0F));
  CHECK(core::is_finite(Limits::max()));
  CHECK(core::is_finite(Limits::denorm_min()));
  CHECK_FALSE(core::is_finite(Limits::infinity()));
  CHECK_FALSE(core::is_finite(-Limits::infinity()));
  CHECK_FALSE(core::is_finite(Limits::quiet_NaN()));
}

TEST_CASE("round_to_u32 rounds to nearest and holds at the ends") {
  CHECK(core::round_to_u32(-3.0F) == 0);
  CHECK(core::round_to_u32(0.4F) == 0);
  CHECK(core::round_to_u32(0.6F) == 1);
  CHECK(core::round_to_u32(1e6F) == 1'000'000);
  CHECK(core::round_to_u32(16'777'215.0F) == 16'777'215);
  CHECK(core::round_to_u32(1e12F) == 0xFFFFFFFFU);
  CHECK(core::round_to_u32(std::numeric_limits<float>::quiet_NaN()) == 0);
}
