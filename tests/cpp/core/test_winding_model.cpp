// The winding's model beside a measured current: numbers worked out by hand.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

#include "core/winding_model.hpp"

using namespace torsio::core;

namespace {

/// Whether a measurement is believed beside 1 A of slack, for so many steps on end.
bool believed(float expected_a, float measured_a, int steps = 3) {
  WindingParams params;
  params.slack_a = 1.0F;
  params.patience_steps = 3;
  WindingState state;
  state.expected_a = expected_a;
  bool believes = true;
  for (int n = 0; n < steps; ++n) believes = believe_current(state, params, measured_a);
  return believes;
}

doctest::Approx near(double value) { return doctest::Approx(value).scale(0).epsilon(1e-4); }

}  // namespace

TEST_CASE("the slack grows with the larger of both currents, by 0.4 of it") {
  for (const float sign : {1.0F, -1.0F}) {
    CHECK(believed(sign * 4.0F, sign * 1.5F));
    CHECK(believed(sign * 1.5F, sign * 4.0F));
    CHECK_FALSE(believed(sign * 4.0F, sign * 1.3F));
    CHECK_FALSE(believed(sign * 1.3F, sign * 4.0F));
    CHECK_FALSE(believed(sign * 2.0F, sign * -2.0F));
  }
}

TEST_CASE("only doubts on end count") {
  CHECK(believed(4.0F, 0.0F, 2));
  CHECK_FALSE(believed(4.0F, 0.0F, 3));
  WindingParams params;
  params.slack_a = 1.0F;
  params.patience_steps = 3;
  WindingState state;
  for (const bool good : {false, false, true, false, false, true}) {
    state.expected_a = 4.0F;
    CHECK(believe_current(state, params, good ? 4.0F : 0.0F));
  }
}

TEST_CASE("the model's current goes its way towards voltage less back EMF over resistance") {
  const WindingParams params = make_winding(2.0F, 1e-3F, 0.05F, 2.0F, 1e-4F, 4e-3F, 6.4e-3F, 0.1F);
  CHECK(static_cast<double>(params.slack_a) == near(1.0));
  CHECK(params.patience_steps == 41);
  WindingState state;
  follow_winding(state, params, 0.0F, 6.0F);  // acts from the next period on
  CHECK(state.expected_a == 0.0F);
  for (int n = 1; n <= 20; ++n) {
    follow_winding(state, params, 40.0F, 6.0F);
    CHECK(static_cast<double>(state.expected_a) == near(2.0 * (1.0 - std::exp(-0.2 * n))));
  }
}
