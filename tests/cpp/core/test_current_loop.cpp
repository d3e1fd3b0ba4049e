// The winding is computed here in double, exactly: i' = (v - R i - e) / L under a constant voltage.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <random>

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
    CHECK(winding.current_a ==
          doctest::Approx(0.5 * (1 - std::pow(1 - share, n))).scale(0.5).epsilon(1e-4));
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
  CHECK(winding.current_a == doctest::Approx(0.5).scale(0).epsilon(1e-3));
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
  CHECK(winding.current_a == doctest::Approx(-0.8).scale(0).epsilon(1e-3));
}

TEST_CASE("a target beyond the supply saturates at once and is forgotten at once") {
  Winding winding;
  CurrentLoopState state;
  for (int n = 0; n < 5000; ++n) {
    const float duty = hold_current(state, kParams, 50, static_cast<float>(winding.current_a));
    CHECK(duty <= 1.0F);
    winding.drive(12.0 * static_cast<double>(duty), 50e-6);
  }
  CHECK(winding.current_a == doctest::Approx(12 / 2.5).scale(0).epsilon(1e-3));
  double lowest = 10;
  for (int n = 0; n < 200; ++n) {
    const float duty = hold_current(state, kParams, 0.5F, static_cast<float>(winding.current_a));
    winding.drive(12.0 * static_cast<double>(duty), 50e-6);
    lowest = std::min(lowest, winding.current_a);
  }
  CHECK(winding.current_a == doctest::Approx(0.5).scale(0).epsilon(1e-2));
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

TEST_CASE("the predictive loop sends the current to its target as soon as its voltage acts") {
  // Share of the missing current that a period leaves, at 10 kHz and 25 us.
  const double left = std::exp(-2 * 3.14159265358979 * 10e3 * 25e-6);
  for (const double delay_s : {25e-6, 10e-6}) {
    const PredictiveParams params =
        make_predictive_loop(2.5F, 1.5e-3F, 10e3F, 25e-6F, static_cast<float>(delay_s), 12);
    Winding winding;
    PredictiveState state;
    double acting_v = 0;
    double missing = 1;
    for (int n = 0; n < 40; ++n) {
      const float share = hold_current(state, params, 0.1F, static_cast<float>(winding.current_a));
      winding.drive(acting_v, delay_s);
      const double begin_a = winding.current_a;
      CHECK(begin_a == doctest::Approx(0.1 * (1 - missing)).scale(0).epsilon(1e-3).scale(0.1));
      acting_v = 12.0 * static_cast<double>(share);
      // A period after the voltage began to act, a share of the way is gone.
      Winding later = winding;
      later.drive(acting_v, 25e-6);
      CHECK(0.1 - later.current_a ==
            doctest::Approx(left * (0.1 - begin_a)).scale(0).epsilon(1e-3).scale(0.1));
      missing = 1 - later.current_a / 0.1;
      winding.drive(acting_v, 25e-6 - delay_s);
    }
    CHECK(winding.current_a == doctest::Approx(0.1).scale(0).epsilon(1e-4));
  }
}

TEST_CASE("the predictive loop forgives a winding that is a third off in either way") {
  const PredictiveParams params = make_predictive_loop(2.5F, 1.5e-3F, 10e3F, 25e-6F, 25e-6F, 12);
  for (const double resistance : {0.7, 1.3}) {
    for (const double inductance : {0.7, 1.3}) {
      Winding winding;
      winding.resistance_ohm *= resistance;
      winding.inductance_h *= inductance;
      PredictiveState state;
      double acting_v = 0;
      double peak_a = 0;
      for (int n = 0; n < 80; ++n) {
        const float share =
            hold_current(state, params, 0.15F, static_cast<float>(winding.current_a));
        winding.drive(acting_v, 25e-6);
        acting_v = 12.0 * static_cast<double>(share);
        peak_a = std::max(peak_a, winding.current_a);
        if (n > 19) CHECK(winding.current_a == doctest::Approx(0.15).scale(0).epsilon(0.05));
      }
      CHECK(winding.current_a == doctest::Approx(0.15).scale(0).epsilon(1e-3));
      CHECK(peak_a < 1.4 * 0.15);
    }
  }
}

TEST_CASE("the predictive loop learns back EMF and a sagging supply") {
  const PredictiveParams params = make_predictive_loop(2.5F, 1.5e-3F, 10e3F, 25e-6F, 25e-6F, 12);
  Winding winding;
  PredictiveState state;
  double acting_v = 0;
  for (int n = 0; n < 400; ++n) {
    const float share = hold_current(state, params, 0.5F, static_cast<float>(winding.current_a));
    winding.drive(acting_v, 25e-6);
    acting_v = 10.0 * static_cast<double>(share);  // not 12
    winding.back_emf_v += 70 * 25e-6;              // 1400 rad/s^2 at 0.05 V s
    if (n > 80) CHECK(winding.current_a == doctest::Approx(0.5).scale(0).epsilon(0.004));
  }
}

TEST_CASE("the predictive loop learns as soon and keeps noise out, whatever the winding") {
  std::mt19937 random(1);
  std::normal_distribution<double> noise_a(0.0, 1e-3);
  // How fast a winding forgets its current, from hardly in a period of 25 us to within it.
  for (const double inductance_h : {1.5e-2, 1.5e-3, 3e-4, 6e-5, 1.2e-5}) {
    const PredictiveParams params =
        make_predictive_loop(2.5F, static_cast<float>(inductance_h), 10e3F, 25e-6F, 25e-6F, 12);
    Winding winding{.inductance_h = inductance_h};
    PredictiveState state;
    double acting_v = 0;
    double peak_a = 0;
    double square_a2 = 0;
    for (int n = 0; n < 4000; ++n) {
      if (n == 100) winding.back_emf_v = 1;
      const bool noisy = n >= 1000;
      const double measured_a = winding.current_a + (noisy ? noise_a(random) : 0.0);
      const float share = hold_current(state, params, 0.1F, static_cast<float>(measured_a));
      winding.drive(acting_v, 25e-6);
      acting_v = 12.0 * static_cast<double>(share);
      const double error_a = std::abs(winding.current_a - 0.1);
      if (n >= 100 && n < 1000) {
        peak_a = std::max(peak_a, error_a);
        if (n > 127) CHECK(error_a < 0.05 * peak_a);
      }
      if (noisy) square_a2 += error_a * error_a / 3000;
    }
    // A loop that believes each reading has 0.9 of its noise in a winding of 1.5 mH.
    CHECK(std::sqrt(square_a2) < (inductance_h > 2e-5 ? 0.6e-3 : 0.8e-3));
  }
}

TEST_CASE("the predictive loop saturates at once and is back at once") {
  const PredictiveParams params = make_predictive_loop(2.5F, 1.5e-3F, 10e3F, 25e-6F, 25e-6F, 12);
  Winding winding;
  PredictiveState state;
  double acting_v = 0;
  const auto run = [&](float target_a, int periods) {
    for (int n = 0; n < periods; ++n) {
      const float share =
          hold_current(state, params, target_a, static_cast<float>(winding.current_a));
      CHECK(std::abs(share) <= 1.0F);
      winding.drive(acting_v, 25e-6);
      acting_v = 12.0 * static_cast<double>(share);
    }
  };
  run(50, 2000);
  CHECK(winding.current_a == doctest::Approx(12 / 2.5).scale(0).epsilon(1e-3));
  // From there to 0.5 A with all of the supply: L/R ln((4.8 + 4.8) / (0.5 + 4.8)) = 0.36 ms.
  run(0.5F, 18);
  CHECK(winding.current_a == doctest::Approx(0.5).scale(0).epsilon(0.02));
  run(0.5F, 40);
  CHECK(winding.current_a == doctest::Approx(0.5).scale(0).epsilon(1e-3));
}

namespace {

/// A coil of 40 ohm and 2.4 H on 12 V, driven by its model for a while.
struct DrivenCoil {
  explicit DrivenCoil(float lag_s, float erase_a = 0)
      : params(make_coil(40, 2.4F, lag_s, 25e-6F, 12, erase_a)) {}

  void run(float target_a, double time_s) {
    for (int n = 0; n < static_cast<int>(std::lround(time_s / 25e-6)); ++n) {
      const double voltage_v = 12.0 * static_cast<double>(drive_coil(state, params, target_a));
      coil.drive(voltage_v, 25e-6);
      CHECK(std::abs(voltage_v) <= 12.0);
      lowest_a = std::min(lowest_a, coil.current_a);
    }
  }

  CoilParams params;
  CoilState state;
  Winding coil{.resistance_ohm = 40, .inductance_h = 2.4};
  double lowest_a = 0;
};

}  // namespace

TEST_CASE("a driven coil follows with the lag that is asked for, as far as the supply goes") {
  for (const double lag_s : {60e-3, 20e-3, 5e-3}) {
    DrivenCoil driven(static_cast<float>(lag_s));
    // Rates of 12 V / 2.4 H = 5 A/s are never asked for.
    const double target_a = 0.4 * 5.0 * std::min(lag_s, 20e-3);
    driven.run(static_cast<float>(target_a), lag_s);
    CHECK(driven.coil.current_a ==
          doctest::Approx(target_a * (1 - std::exp(-1.0))).scale(0).epsilon(2e-3));
    driven.run(static_cast<float>(target_a), 8 * lag_s);
    CHECK(driven.coil.current_a == doctest::Approx(target_a).scale(0).epsilon(2e-3));
  }
}

TEST_CASE("a driven coil rises and falls with the whole supply, and not below zero") {
  DrivenCoil driven(0);
  // 12 V / 40 ohm = 0.3 A: from 0 to 0.2 A in L/R ln(0.3 / 0.1) = 65.9 ms, and back in
  // L/R ln(0.5 / 0.3) = 30.6 ms.
  driven.run(0.2F, 64e-3);
  CHECK(driven.coil.current_a < 0.2);
  driven.run(0.2F, 4e-3);
  CHECK(driven.coil.current_a == doctest::Approx(0.2).scale(0).epsilon(1e-3));
  driven.run(0, 29e-3);
  CHECK(driven.coil.current_a > 0.0);
  driven.run(0, 4e-3);
  CHECK(std::abs(driven.coil.current_a) < 2e-4);
  driven.run(0, 100e-3);
  CHECK(driven.lowest_a > -2e-4);
}

TEST_CASE("a driven coil that lets go gets a little current backwards, once, and then none") {
  for (const float lag_s : {0.0F, 30e-3F}) {
    DrivenCoil driven(lag_s, 15e-3F);
    const auto let_go = [&](double time_s) {
      driven.lowest_a = 0;
      driven.run(0, time_s);
      return driven.lowest_a;
    };
    CHECK(let_go(0.3) == 0.0);  // nothing has flowed yet
    driven.run(0.2F, 0.3);
    // From 0.2 A it needs 31 ms with the whole supply; to 15 mA three lags at most. Then it rests
    // for twice its 60 ms.
    CHECK(let_go(0.12) > -2e-4);
    CHECK(let_go(0.12) == doctest::Approx(-15e-3).scale(0).epsilon(0.01));
    CHECK(std::abs(driven.coil.current_a) < 2e-4);
    CHECK(let_go(0.1) > -2e-4);
    // Backwards and back takes two times 3 ms: 15 mA at 5 A/s.
    driven.run(0.2F, 0.3);
    int backwards = 0;
    for (int n = 0; n < 12'000; ++n) {
      driven.run(0, 25e-6);
      if (driven.coil.current_a < -1e-4) ++backwards;
    }
    CHECK(25e-6 * backwards == doctest::Approx(6e-3).scale(0).epsilon(0.1));
    // A smaller current leaves nothing worth it.
    driven.run(0.01F, 0.5);
    CHECK(let_go(0.3) > -2e-4);
    // Until then it falls as it shall.
    driven.run(0.2F, 0.5);
    driven.run(0, static_cast<double>(lag_s));
    if (lag_s > 0.0F) {
      CHECK(driven.coil.current_a == doctest::Approx(0.2 * std::exp(-1.0)).scale(0).epsilon(0.01));
    }
    // Asked for again in the middle, it comes at once.
    driven.run(0.2F, 0.3);
    for (int n = 0; n < 12'000 && driven.coil.current_a > -5e-3; ++n) driven.run(0, 25e-6);
    REQUIRE(driven.coil.current_a <= -5e-3);
    driven.run(0.2F, 0.3);
    CHECK(driven.coil.current_a == doctest::Approx(0.2).scale(0).epsilon(0.01));
    // With the bridge off it ends at zero, and is not sent backwards later.
    for (int n = 0; n < 4000; ++n) release_coil(driven.state, driven.params);
    driven.coil.current_a = 0.0;
    CHECK(let_go(0.3) == 0.0);
    // A new current before the rest is over begins the rest anew.
    driven.run(0.2F, 0.3);
    driven.run(0, 0.14);
    driven.run(0.001F, 1e-3);
    CHECK(let_go(0.1) > -2e-4);
    CHECK(let_go(0.1) == doctest::Approx(-15e-3).scale(0).epsilon(0.01));
  }
}
