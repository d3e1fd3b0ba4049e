// The steppers that the exact one is compared with.
#include <doctest/doctest.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "plant_cases.hpp"
#include "plant_tracks.hpp"
#include "steppers/steppers.hpp"

using namespace torsio::emulator;
using namespace torsio::studies;
using namespace torsio::emulator::test;

namespace torsio::emulator::test {

std::vector<Choice> steppers_that_hold() {
  return {{"trapezoid", stepper_by_name("trapezoid"), 10'000, 2e-3},
          {"semi-implicit", stepper_by_name("semi_implicit"), 10'000, 2e-3}};
}

std::vector<Choice> all_steppers() {
  std::vector<Choice> all = steppers_that_hold();
  all.push_back({"regularised", stepper_by_name("regularised"), 10'000, 1.0});
  return all;
}

}  // namespace torsio::emulator::test

TEST_CASE("trapezoid and semi-implicit converge to the exact stepper, for every part") {
  for (const Variant& variant : variants()) {
    CAPTURE(variant.name);
    const Track exact = track(variant.params, variant.hand, 1'000'000);
    const auto error = [&](const char* name, std::int64_t step_ns) {
      return relative_error(
          track(variant.params, variant.hand, step_ns, 0.085, 0.05, stepper_by_name(name)), exact);
    };
    CHECK(error("trapezoid", 5'000) < 2e-3);
    const double coarse = error("semi_implicit", 20'000);
    const double fine = error("semi_implicit", 2'500);
    CHECK(fine < 2e-2);
    CHECK(fine < 0.3 * coarse);
  }
}

TEST_CASE("stepper of an unknown name, or with a smoothing that is none, is refused") {
  CHECK_THROWS_WITH_AS((void)stepper_by_name("rk4"), doctest::Contains("not 'rk4'"),
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS((void)make_regularised_stepper(make_model({}, NoHand{}), 0.0),
                       doctest::Contains("smoothing_rad_s"), std::invalid_argument);
}
