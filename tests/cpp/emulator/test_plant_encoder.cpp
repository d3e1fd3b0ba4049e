#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "emulator/encoder.hpp"

using namespace torsio::emulator;

namespace {
constexpr double kTurn = 2.0 * std::numbers::pi;
}

TEST_CASE("encoder floors towards negative angle, and counts wrap at 32 bits") {
  Encoder encoder;
  CHECK(encoder.sample(Angle::from_rad(0.0)) == 0u);
  CHECK(encoder.sample(Angle::from_rad(kTurn / 8192 * 1.999)) == 1u);
  CHECK(encoder.sample(Angle::from_rad(-kTurn / 8192 * 0.001)) == 0xffffffffu);
  CHECK(encoder.sample({1, 0.0}) == 8192u);
  CHECK(encoder.sample({-1, 0.0}) == 0u - 8192u);
  CHECK(encoder.sample({524'288, kTurn / 8192 * 1.5}) == 1u);
}

TEST_CASE("encoder rounds to the nearest count, with phase and direction") {
  EncoderParams params;
  params.rounding = EncoderRounding::nearest;
  CHECK(Encoder(params).sample(Angle::from_rad(kTurn / 8192 * 1.6)) == 2u);
  params.phase_counts = 0.25;
  CHECK(Encoder(params).sample(Angle::from_rad(kTurn / 8192 * 1.3)) == 2u);
  params.phase_counts = 0.0;
  params.direction = -1;
  CHECK(Encoder(params).sample(Angle::from_rad(kTurn / 8192 * 3.0)) == 0u - 3u);
  CHECK(Encoder(params).sample({2, 0.0}) == 0u - 16384u);
}

TEST_CASE("angle keeps a millionth of a count over 1,000 h at 10 rev/s") {
  // One addition per tick at 1 kHz would be 3.6e9 additions. The error of one is bounded, so fewer
  // additions far from zero show the same bound.
  Angle angle{36'000'000, 0.0};
  const double step_rad = kTurn * 10.0 * 1e-3;
  constexpr int kSteps = 10'000'000;
  for (int i = 0; i < kSteps; ++i) angle.add(step_rad);
  const double expected_turns = 0.01 * kSteps;
  const double turns =
      static_cast<double>(angle.revolutions - 36'000'000) + angle.fraction_rad / kTurn;
  const double error_per_step_rad = std::abs(turns - expected_turns) * kTurn / kSteps;
  CHECK(error_per_step_rad < 5e-16);
  CHECK(error_per_step_rad * 3.6e9 < kTurn / 8192 * 0.01);
}

TEST_CASE("angle stays within one turn at its edges") {
  Angle angle;
  angle.add(-1e-20);
  CHECK(angle.fraction_rad >= 0.0);
  CHECK(angle.fraction_rad < kTurn);
  CHECK(angle.rad() == doctest::Approx(0.0));
  CHECK(Angle::from_rad(-0.5).rad() == doctest::Approx(-0.5));
  CHECK(Angle::from_rad(1e4).rad() == doctest::Approx(1e4));
}

TEST_CASE("encoder noise is repeatable by its seed and has the variance that was asked for") {
  EncoderParams params;
  params.noise_counts = 2.0;
  params.seed = 7;
  Encoder first(params);
  Encoder second(params);
  params.seed = 8;
  Encoder other(params);
  double sum = 0.0;
  double sum_squares = 0.0;
  int differing = 0;
  constexpr int kSamples = 20'000;
  for (int i = 0; i < kSamples; ++i) {
    const auto count = static_cast<std::int32_t>(first.sample({0, 1.0}));
    CHECK(count == static_cast<std::int32_t>(second.sample({0, 1.0})));
    if (count != static_cast<std::int32_t>(other.sample({0, 1.0}))) ++differing;
    const double deviation = count - 8192.0 / kTurn + 0.5;
    sum += deviation;
    sum_squares += deviation * deviation;
  }
  CHECK(differing > kSamples / 2);
  CHECK(std::abs(sum / kSamples) < 0.06);  // 4 sigma
  // Rounding adds 1/12.
  CHECK(sum_squares / kSamples == doctest::Approx(4.0 + 1.0 / 12.0).scale(0).epsilon(0.04));
}

TEST_CASE("encoder refuses parameters out of their range") {
  EncoderParams params;
  params.counts_per_rev = 0;
  CHECK_THROWS_WITH_AS(Encoder{params}, doctest::Contains("counts_per_rev"), std::invalid_argument);
  params = {};
  params.direction = 0;
  CHECK_THROWS_WITH_AS(Encoder{params}, doctest::Contains("direction"), std::invalid_argument);
  params = {};
  params.noise_counts = -1.0;
  CHECK_THROWS_WITH_AS(Encoder{params}, doctest::Contains("noise_counts"), std::invalid_argument);
  params = {};
  params.phase_counts = NAN;
  CHECK_THROWS_WITH_AS(Encoder{params}, doctest::Contains("phase_counts"), std::invalid_argument);
}
