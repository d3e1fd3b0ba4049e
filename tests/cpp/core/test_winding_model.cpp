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
  const WindingParams params = make_winding(2.0F, 1e-3F, 0.05F, 2.0F, 12.0F, 1e-4F, 4e-3F, 6.4e-3F);
  CHECK(static_cast<double>(params.slack_a) == near(1.0));
  CHECK(params.patience_steps == 41);
  CHECK(static_cast<double>(params.mean_share) == near(1.0 / 64));
  CHECK(static_cast<double>(params.mean_slack_a) == near(0.12));  // 0.24 of 12 V over 2 ohm
  CHECK(static_cast<double>(params.mean_patience_a) == near(1.25));
  CHECK(static_cast<double>(params.own_decay) == near(std::exp(-0.64)));
  const WindingParams strong = make_winding(2.0F, 1e-3F, 0.05F, 4.0F, 12.0F, 1e-4F, 4e-3F, 6.4e-3F);
  CHECK(static_cast<double>(strong.mean_slack_a) == near(0.2));
  WindingState state;
  follow_winding(state, params, 0.0F, 6.0F);  // acts from the next period on
  CHECK(state.expected_a == 0.0F);
  for (int n = 1; n <= 20; ++n) {
    follow_winding(state, params, 40.0F, 6.0F);
    CHECK(static_cast<double>(state.expected_a) == near(2.0 * (1.0 - std::exp(-0.2 * n))));
  }
}

namespace {

/// The means of one look beside 0.1 A of slack, with two comparisons.
struct Means {
  Means() {
    params.slack_a = 100.0F;
    params.patience_steps = 1000;
    params.a_per_v = 0.5F;
    params.emf_v_s = 0.1F;
    params.mean_share = 0.5F;
    params.mean_slack_a = 0.1F;
    params.mean_patience_a = 1.0F;
    params.own_decay = 0.25F;
    params.steady_share = 0.5F;
  }
  bool look(float expected_a, float measured_a, float speed_rad_s = 0.0F) {
    for (const float wave : {0.5F, -0.5F}) {
      state.expected_a = expected_a + wave;
      (void)believe_current(state, params, measured_a - wave);
    }
    return believe_means(state, params, speed_rad_s);
  }
  double above() const { return static_cast<double>(state.above_a); }
  double below() const { return static_cast<double>(state.below_a); }

  WindingParams params;
  WindingState state;
};

}  // namespace

TEST_CASE("means that differ add up, each way for itself, less what is never doubted") {
  Means zero;
  CHECK(zero.look(0.5F, 0.0F));
  CHECK(zero.above() == near(0.4));
  CHECK(zero.below() == 0.0);
  CHECK(zero.look(0.5F, 0.0F));
  CHECK_FALSE(zero.look(0.5F, 0.0F));
  CHECK(zero.above() == near(1.2));
  CHECK(zero.look(-0.5F, 0.0F));
  CHECK(zero.above() == near(0.6));
  CHECK(zero.below() == near(0.4));
  // Much takes one look.
  CHECK_FALSE(Means().look(1.2F, 0.0F));
  CHECK_FALSE(Means().look(-1.2F, 0.0F));
}

TEST_CASE("what is never doubted of the means grows with current and speed") {
  for (const float sign : {1.0F, -1.0F}) {
    const auto doubt = [&](float expected_a, float measured_a, float speed_rad_s = 0.0F) {
      Means means;
      means.look(sign * expected_a, sign * measured_a, speed_rad_s);
      return sign > 0.0F ? means.above() - means.below() : means.below() - means.above();
    };
    CHECK(doubt(4.0F, 2.0F) == near(2.0 - 0.85 * 2.0));
    CHECK(doubt(0.4F, 0.2F) == near(0.2 - (0.1 + 0.4 * 0.2)));
    CHECK(doubt(1.0F, 2.0F) == near(-(1.0 - 0.41 * 2.0)));
    CHECK(doubt(0.0F, 0.2F) == near(-(0.2 - (0.1 + 0.2 * 0.2))));
    // 8 rad/s make 0.8 V, which is 0.4 A; 0.35 of it may be wrong.
    for (const float speed : {8.0F, -8.0F}) {
      CHECK(doubt(4.0F, 2.0F, speed) == near(2.0 - 0.85 * 2.0 - 0.14));
      CHECK(doubt(0.5F, 0.0F, speed) == near(0.4 - 0.14));
      CHECK(doubt(0.5F, 2.0F, speed) == near(-(1.5 - 0.41 * 2.0 - 0.14)));
    }
  }
  // A speed is remembered, less and less.
  Means means;
  means.look(0.0F, 0.0F, 16.0F);
  means.look(0.5F, 0.0F);
  CHECK(means.above() == near(0.4 - 0.35 * 0.8 / 4));
}

TEST_CASE("a change is doubted that no current brought about") {
  Means means;
  // A winding of 1.5 times the resistance: long since so.
  for (int n = 0; n < 30; ++n) {
    means.look(3.0F, 2.0F);
    CHECK(believe_change(means.state, means.params));
  }
  CHECK(means.state.rise_a == 0.0F);
  // 1 A more than before: 0.1 A and a fifth of the current are never doubted.
  means.look(4.0F, 2.0F);
  CHECK(believe_change(means.state, means.params));
  CHECK(static_cast<double>(means.state.rise_a) == near(1.0 - 0.5));
  // A lasting difference becomes the new normal.
  means.look(4.0F, 2.0F);
  CHECK(believe_change(means.state, means.params));
  CHECK(static_cast<double>(means.state.rise_a) == near(0.5 + 0.5 - 0.5));
  means.look(4.9F, 2.0F);
  CHECK_FALSE(believe_change(means.state, means.params));
}

TEST_CASE("a change that a current or a speed may have brought about is none") {
  for (const float sign : {1.0F, -1.0F}) {
    Means pushed;
    pushed.look(sign * 3.0F, sign * 2.0F);
    CHECK(believe_change(pushed.state, pushed.params));
    CHECK(pushed.state.rise_a == 0.0F);
    CHECK(pushed.state.fall_a == 0.0F);
    Means zero;
    zero.look(sign * 0.7F, 0.0F);
    CHECK(believe_change(zero.state, zero.params));
    CHECK(static_cast<double>(sign > 0.0F ? zero.state.rise_a : zero.state.fall_a) == near(0.6));
    Means turned;
    turned.look(sign * 0.7F, 0.0F, 8.0F);
    CHECK(believe_change(turned.state, turned.params));
    CHECK(static_cast<double>(sign > 0.0F ? turned.state.rise_a : turned.state.fall_a) ==
          near(0.6 - 0.14));
    // A current that vanishes with the speed is no fault either. Limit: half of 0.7 A less 0.1 A,
    // half of the 0.1 A remembered, half of the 0.2 A from its own voltage.
    turned.state.rise_a = turned.state.fall_a = 0.0F;
    turned.look(0.0F, 0.0F);
    CHECK(believe_change(turned.state, turned.params));
    CHECK(static_cast<double>(sign > 0.0F ? turned.state.fall_a : turned.state.rise_a) ==
          near(0.35 - 0.1 - 0.035 - 0.07));
  }
}
