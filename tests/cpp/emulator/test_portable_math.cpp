#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "emulator/plant/portable_math.hpp"

using namespace torsio::emulator;

TEST_CASE("expm1_of agrees with the library from 0 to where nothing is left") {
  CHECK(expm1_of(0.0) == 0.0);
  CHECK(expm1_of(-std::numeric_limits<double>::infinity()) == -1.0);
  for (double x = -1e-12; x > -100.0; x *= 1.07) {
    CAPTURE(x);
    CHECK(std::abs(expm1_of(x) / std::expm1(x) - 1.0) < 4e-15);
  }
}

TEST_CASE("log_of agrees with the library") {
  CHECK(log_of(1.0) == 0.0);
  for (double x = 1e-300; x < 1e300; x *= 1.9) {
    CAPTURE(x);
    CHECK(std::abs(log_of(x) / std::log(x) - 1.0) < 1e-15);
  }
  for (double x = 0.5; x < 2.0; x += 0.0037) {
    CHECK(std::abs(log_of(x) - std::log(x)) < 3e-16);
  }
}

TEST_CASE("cos_of_turns agrees with the library over the whole turn") {
  CHECK(cos_of_turns(0.0) == 1.0);
  CHECK(cos_of_turns(0.5) == -1.0);
  for (int i = 0; i <= 4096; ++i) {
    const double turns = i / 4096.0;
    CHECK(std::abs(cos_of_turns(turns) - std::cos(2.0 * std::numbers::pi * turns)) < 1e-15);
  }
}
