#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "emulator/plant/profile.hpp"

using torsio::emulator::Profile;
using torsio::emulator::ProfileKnot;

TEST_CASE("profile is linear between knots and holds its ends outside") {
  const Profile profile({{1'000, 2.0}, {3'000, 6.0}, {4'000, 5.0}});
  CHECK(profile.value(-5) == 2.0);
  CHECK(profile.value(1'000) == 2.0);
  CHECK(profile.value(1'500) == doctest::Approx(3.0));
  CHECK(profile.value(3'000) == doctest::Approx(6.0));
  CHECK(profile.value(3'750) == doctest::Approx(5.25));
  CHECK(profile.value(1'000'000) == 5.0);
  CHECK(profile.slope_per_s(0) == 0.0);
  CHECK(profile.slope_per_s(1'000) == doctest::Approx(2e6));
  CHECK(profile.slope_per_s(3'000) == doctest::Approx(-1e6));
  CHECK(profile.slope_per_s(4'000) == 0.0);
}

TEST_CASE("profile names its next knot, which is forever away after the last one") {
  const Profile profile({{10, 0.0}, {20, 1.0}});
  CHECK(profile.next_knot_ns(9) == 10);
  CHECK(profile.next_knot_ns(10) == 20);
  CHECK(profile.next_knot_ns(20) == Profile::kForeverNs);
}

TEST_CASE("profile jumps where two knots share a time, and the later one holds there") {
  const Profile profile({{0, 1.0}, {10, 1.0}, {10, 0.0}, {20, 0.0}});
  CHECK(profile.value(9) == 1.0);
  CHECK(profile.value(10) == 0.0);
  CHECK_FALSE(profile.is_continuous());
  CHECK(Profile::constant(3.0).is_continuous());
}

TEST_CASE("profile refuses knots that make no function of time") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  using Knots = std::vector<ProfileKnot>;
  CHECK_THROWS_WITH_AS(Profile(Knots{}), "profile: needs at least one knot", std::invalid_argument);
  CHECK_THROWS_WITH_AS(Profile(Knots{{0, 1.0}, {-1, 1.0}}),
                       "profile: knot 1 is earlier than knot 0", std::invalid_argument);
  CHECK_THROWS_WITH_AS(Profile(Knots{{0, nan}}), "profile: knot 0 has a value that is not finite",
                       std::invalid_argument);
  CHECK_THROWS_AS(Profile(Knots{{0, 0.0}, {1, infinity}}), std::invalid_argument);
  CHECK_THROWS_AS(Profile(Knots{{0, 0.0}, {0, 1.0}, {0, 2.0}}), std::invalid_argument);
}
