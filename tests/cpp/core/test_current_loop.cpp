// The winding is computed here in double, exactly: i' = (v - R i - e) / L under a constant voltage.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "core/current_loop.hpp"

namespace {

using namespace torsio::core;

struct Winding {
  double resistance_ohm = 2.5;
  double inductance_h = 1.5e-3;
  double back_emf_v = 0;
  double current_a = 0;

  void drive(double voltage_v, double period_s) {
    const double end_a = (voltage_v - back_emf_v) / resistance_ohm;
    current_a = end_a + (current_a - end_a) * std::exp(-period_s * resistance_ohm / inductance_h);
  }
};

constexpr float kPeriod = 50e-6F;
constexpr CurrentLoopParams kParams = make_current_loop(2.5F, 1.5e-3F, 500, kPeriod, 12);

}  // namespace

TEST_CASE("the current approaches its target as a first order lag of the given bandwidth") {
  Winding winding;
  CurrentLoopState state;
  const double share = 1 - std::exp(-2 * 3.14159265358979 * 500 * 50e-6);
  for (int n = 0; n < 100; ++n) {
    CHECK(winding.current_a == doctest::Approx(0.5 * (1 - std::pow(1 - share, n))).epsilon(1e-4));
    const float duty = hold_current(state, kParams, 0.5F, static_cast<float>(winding.current_a));
    winding.drive(12.0 * static_cast<double>(duty), 50e-6);
  }
}

TEST_CASE("the current settles with the delay of a period, up to the highest bandwidth") {
  const CurrentLoopParams params = make_current_loop(2.5F, 1.5e-3F, 1e6F, kPeriod, 12);
  Winding winding;
  CurrentLoopState state;
  float waiting = 0;
  double peak = 0;
  for (int n = 0; n < 60; ++n) {
    const float next = hold_current(state, params, 0.5F, static_cast<float>(winding.current_a));
    winding.drive(12.0 * static_cast<double>(waiting), 50e-6);
    waiting = next;
    peak = std::max(peak, winding.current_a);
  }
  CHECK(winding.current_a == doctest::Approx(0.5).epsilon(1e-3));
  CHECK(peak < 1.25 * 0.5);
}

TEST_CASE("back EMF and a wrong resistance leave no error behind") {
  Winding winding;
  winding.back_emf_v = 4;
  winding.resistance_ohm = 3.5;
  CurrentLoopState state;
  for (int n = 0; n < 2000; ++n) {
    const float duty = hold_current(state, kParams, -0.8F, static_cast<float>(winding.current_a));
    winding.drive(12.0 * static_cast<double>(duty), 50e-6);
  }
  CHECK(winding.current_a == doctest::Approx(-0.8).epsilon(1e-3));
}

TEST_CASE("a target beyond the supply saturates at once and is forgotten at once") {
  Winding winding;
  CurrentLoopState state;
  for (int n = 0; n < 5000; ++n) {
    const float duty = hold_current(state, kParams, 50, static_cast<float>(winding.current_a));
    CHECK(duty <= 1.0F);
    winding.drive(12.0 * static_cast<double>(duty), 50e-6);
  }
  CHECK(winding.current_a == doctest::Approx(12 / 2.5).epsilon(1e-3));
  double lowest = 10;
  for (int n = 0; n < 200; ++n) {
    const float duty = hold_current(state, kParams, 0.5F, static_cast<float>(winding.current_a));
    winding.drive(12.0 * static_cast<double>(duty), 50e-6);
    lowest = std::min(lowest, winding.current_a);
  }
  CHECK(winding.current_a == doctest::Approx(0.5).epsilon(1e-2));
  CHECK(lowest > 0.4);
}

TEST_CASE("the voltage is within the supply, both ways") {
  for (const float sign : {1.0F, -1.0F}) {
    CurrentLoopState state;
    for (int n = 0; n < 100; ++n) {
      CHECK(sign * hold_current(state, kParams, sign * 50, 0) == doctest::Approx(1));
    }
  }
}

TEST_CASE("windings far faster and far slower than the period give finite gains") {
  for (const float inductance_h : {1e-6F, 1.0F, 1e3F}) {
    const CurrentLoopParams params = make_current_loop(1e-3F, inductance_h, 5e3F, kPeriod, 12);
    CHECK(is_finite(params.proportional_v_per_a));
    CHECK(params.proportional_v_per_a > 0.0F);
  }
}
