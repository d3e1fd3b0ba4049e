#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "emulator/plant/exact/first_crossing.hpp"

using namespace torsio::emulator;

namespace {

/// The polynomial with these roots, at most 12 of them.
Polynomial from_roots(double factor, const std::vector<double>& roots) {
  Polynomial polynomial{};
  polynomial[0] = factor;
  for (std::size_t n = 0; n < roots.size(); ++n) {
    for (std::size_t k = n + 2; k-- > 0;) {
      polynomial[k] = (k > 0 ? polynomial[k - 1] : 0.0) - roots[n] * polynomial[k];
    }
  }
  return polynomial;
}

constexpr double kTolerance = 1e-15;

}  // namespace

TEST_CASE("first crossing is the first root where the curve goes down") {
  const auto found = first_crossing(from_roots(-1.0, {0.625, 3.0, -2.0}), kTolerance);
  // -(s - 0.625)(s - 3)(s + 2) is negative before 0.625.
  REQUIRE(found);
  CHECK(*found == 0.0);
  const auto down = first_crossing(from_roots(1.0, {0.625, 3.0, -2.0}), kTolerance);
  REQUIRE(down);
  CHECK(*down == doctest::Approx(0.625).scale(0).epsilon(1e-15));
}

TEST_CASE("first crossing finds a dip however narrow, and no dip that is not there") {
  for (const double half_width : {1e-1, 1e-3, 1e-5, 1e-7}) {
    CAPTURE(half_width);
    const auto found = first_crossing(from_roots(1.0, {0.3 - half_width, 0.3 + half_width}), 1e-17);
    REQUIRE(found);
    CHECK(*found == doctest::Approx(0.3 - half_width).scale(0).epsilon(1e-8));
  }
  Polynomial above = from_roots(1.0, {0.3, 0.3});
  above[0] += 1e-14;
  CHECK_FALSE(first_crossing(above, kTolerance));
}

TEST_CASE("first crossing ignores a touch and sees a curve leave zero downwards") {
  CHECK_FALSE(first_crossing(from_roots(1.0, {0.5, 0.5}), kTolerance));
  CHECK_FALSE(first_crossing(Polynomial{}, kTolerance));
  CHECK_FALSE(first_crossing(from_roots(1.0, {0.0, 0.0}), kTolerance));
  const auto slope = first_crossing(from_roots(-1.0, {0.0}), kTolerance);
  REQUIRE(slope);
  CHECK(*slope < 1e-12);
  const auto curve = first_crossing(from_roots(-1.0, {0.0, 0.0}), kTolerance);
  REQUIRE(curve);
  CHECK(*curve < 1e-6);
}

TEST_CASE("first crossing after leaving zero upwards is where it comes back") {
  const auto found = first_crossing(from_roots(-1.0, {0.0, 0.75}), kTolerance);
  REQUIRE(found);
  CHECK(*found == doctest::Approx(0.75).scale(1).epsilon(1e-15));
}

TEST_CASE("first crossing agrees with a dense scan of random polynomials") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int repeat = 0; repeat < 2'000; ++repeat) {
    Polynomial polynomial;
    for (double& coefficient : polynomial) coefficient = uniform(random);
    polynomial[0] = std::abs(polynomial[0]) * 0.3;
    constexpr int kScan = 2'000;
    double expected = 2.0;
    for (int i = 0; i <= kScan && expected > 1.0; ++i) {
      const double s = static_cast<double>(i) / kScan;
      if (evaluate(polynomial, s) < 0.0) expected = s;
    }
    const auto found = first_crossing(polynomial, kTolerance);
    CAPTURE(repeat);
    if (expected > 1.0) {
      // The scan may pass over a dip between two of its points; then the curve is negative there.
      if (found) CHECK(evaluate(polynomial, *found + 1e-7) < 1e-12);
    } else {
      REQUIRE(found);
      CHECK(*found <= expected);
      CHECK(std::abs(evaluate(polynomial, *found)) < 1e-13);
    }
  }
}
