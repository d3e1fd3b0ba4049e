// How warm a winding is, against closed forms of a winding that loses heat in proportion to its
// warmth.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

#include "core/heat_model.hpp"

using namespace torsio::core;

namespace {

constexpr double kCopper = 3.93e-3;         // a degree
constexpr double kHot = 1 + kCopper * 100;  // at 125 degrees, over 25

/// The final temperature with a current, in air of a temperature: the heat of a current is its
/// square times the resistance, and the continuous current makes 100 degrees of it in air of 25.
double settled_k(double ratio, double air_k) {
  const double rise_k = 100 / kHot * ratio * ratio;
  return (air_k + rise_k) / (1 - kCopper * rise_k);
}

}  // namespace

TEST_CASE("a winding warms towards what its current makes in warm copper, in its time") {
  for (const double air_c : {0.0, 25.0, 60.0}) {
    for (const double ratio : {0.0, 0.5, 0.8, 1.0}) {
      CAPTURE(air_c);
      CAPTURE(ratio);
      const HeatParams params = make_heat(5.0F, 2.0F, static_cast<float>(air_c), 10.0F, 0.01F);
      HeatState state = cold_winding(params);
      const double air_k = air_c - 25;
      const double end_k = settled_k(ratio, air_k);
      // Warm copper makes more heat, so that it takes longer by as much.
      const double rate = (1 - kCopper * 100 / kHot * ratio * ratio) / 10.0;
      for (int n = 1; n <= 6000; ++n) {
        warm_up(state, params, static_cast<float>((n % 2 == 0 ? -2.0 : 2.0) * ratio));
        if (n % 500 != 0) continue;
        const double expected = end_k + (air_k - end_k) * std::exp(-rate * 0.01 * n);
        CHECK(static_cast<double>(state.rise_k) ==
              doctest::Approx(expected).scale(100).epsilon(1e-3));
      }
    }
  }
}

TEST_CASE("what is allowed for ever makes 125 degrees in any air, and never more than the peak") {
  for (const double air_c : {0.0, 25.0, 45.0, 100.0}) {
    const HeatParams params = make_heat(5.0F, 2.0F, static_cast<float>(air_c), 10.0F, 0.01F);
    const double ratio = static_cast<double>(params.continuous_a) / 2.0;
    CHECK(settled_k(ratio, air_c - 25) == doctest::Approx(100).scale(0).epsilon(1e-4));
    CHECK(static_cast<double>(continuous_in_air(2.0F, static_cast<float>(air_c))) ==
          doctest::Approx(2 * ratio).scale(0).epsilon(1e-6));
  }
  const HeatParams strong = make_heat(1.0F, 2.0F, 25.0F, 10.0F, 0.01F);
  for (const float rise_k : {0.0F, 90.0F, 300.0F}) {
    CHECK(allow_current({rise_k, false}, strong) <= 1.0F);
  }
}

TEST_CASE(
    "the peak is given until the last quarter of the way to 125 degrees, then less in a line") {
  const HeatParams params = make_heat(2.0F, 1.0F, 45.0F, 10.0F, 0.01F);  // 80 degrees of way
  const double last_a = std::sqrt(0.8);
  const auto allowed = [&](float rise_k) {
    return static_cast<double>(allow_current({rise_k, false}, params));
  };
  CHECK(allowed(20.0F) == doctest::Approx(2.0));
  CHECK(allowed(79.9F) == doctest::Approx(2.0));
  CHECK(allowed(90.0F) == doctest::Approx(0.5 * (2.0 + last_a)).scale(0).epsilon(1e-5));
  CHECK(allowed(100.0F) == doctest::Approx(last_a).scale(0).epsilon(1e-5));
  CHECK(allowed(150.0F) == doctest::Approx(last_a).scale(0).epsilon(1e-5));
}

TEST_CASE("a winding is too hot at 145 degrees, until it has cooled down to 125") {
  const HeatParams params = make_heat(5.0F, 1.0F, 25.0F, 10.0F, 0.01F);
  HeatState state = cold_winding(params);
  for (int n = 0; n < 10'000 && !state.too_hot; ++n) {
    CHECK(state.rise_k <= 120.0F);
    warm_up(state, params, 1.5F);
  }
  CHECK(state.rise_k > 120.0F);
  for (int n = 0; n < 10'000 && state.too_hot; ++n) {
    CHECK(state.rise_k > 100.0F);
    warm_up(state, params, 0.0F);
  }
  CHECK(state.rise_k == doctest::Approx(100).epsilon(0.01));
}

TEST_CASE("currents without measure leave a number, and a continuous current of none allows none") {
  const HeatParams params = make_heat(100.0F, 0.0F, 100.0F, 10.0F, 0.01F);
  HeatState state = cold_winding(params);
  for (int n = 0; n < 10'000; ++n) warm_up(state, params, 100.0F);
  CHECK(std::isfinite(state.rise_k));
  CHECK(state.too_hot);
  CHECK(allow_current(state, params) == 0.0F);
  for (int n = 0; n < 10'000; ++n) warm_up(state, params, 0.0F);
  CHECK_FALSE(state.too_hot);
}
