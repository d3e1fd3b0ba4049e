// Currents of motor and brake for a while and for ever, by the heat in their windings.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "power_motor.hpp"

namespace fault = torsio::protocol::fault;
using torsio::device::PowerLogic;
using torsio::device::TickOutputs;
using torsio::protocol::BoardConfig;
using torsio::tests::kSlow;
using torsio::tests::Motor;

TEST_CASE("warm air leaves less for ever") {
  BoardConfig config;
  config.ambient_c = 65;
  Motor motor(kSlow, config);
  CHECK(motor.push(0.085, 100.0) < 0.0);
  // 60 of the 100 degrees that 1 A makes.
  CHECK(motor.amperes == doctest::Approx(std::sqrt(0.6)).scale(0).epsilon(0.03));
}

TEST_CASE("a current that warms more than was allowed is a fault until the winding has cooled") {
  Motor motor(kSlow);
  std::mt19937 random(1);
  // 1 A in the mean and 0.8 A of ripple, which nobody asked for: 1.64 times the heat.
  motor.sensor = [&](const Motor& of) {
    return of.honest_steps() + (random() % 2 == 0 ? -1.0 : 1.0) * 0.8 * 0.2 / 3.3 * 4096.0;
  };
  const double found_s = motor.push(0.085, 100.0);
  CHECK(found_s > 5.0);
  CHECK(motor.logic.find_faults(false) == fault::temperature);
  motor.sensor = nullptr;
  // From 145 to 125 degrees in air of 25, with a time constant of 10 s.
  double cooled_s = 0.0;
  while (motor.logic.find_faults(false) != 0 && cooled_s < 5.0) {
    motor.run(0.0, 1e-3);
    cooled_s += motor.period_s();
  }
  CHECK(cooled_s == doctest::Approx(10.0 * std::log(120.0 / 100.0)).scale(0).epsilon(0.05));
  CHECK(motor.push(0.0, 0.1) < 0.0);
}

TEST_CASE("a coil gets more than its continuous current for a while, driven or not") {
  for (const float inductance_h : {0.0F, 2.4F}) {
    CAPTURE(inductance_h);
    BoardConfig config;
    config.brake_continuous_percent = 50;
    config.brake_inductance_h = inductance_h;
    PowerLogic logic(config, kSlow, 0.06F);
    const TickOutputs full{0.0F, 0.132F, true};  // 0.3 A
    const auto mean_a = [&](double time_s) {
      double sum = 0.0;
      const int n = static_cast<int>(time_s / 100e-6);
      for (int i = 0; i < n; ++i) {
        sum += static_cast<double>(logic.step(full, 2048).brake_share) * 12.0 / 40.0;
        REQUIRE(logic.find_faults(false) == 0);
      }
      return sum / n;
    };
    mean_a(0.5);  // so long a driven coil rises
    CHECK(mean_a(10.0) == doctest::Approx(0.3).scale(0).epsilon(0.01));
    mean_a(400.0);
    CHECK(mean_a(1.0) == doctest::Approx(0.15).scale(0).epsilon(0.03));
  }
}

TEST_CASE("the peak current is for seconds, the continuous one for ever") {
  Motor motor(kSlow);
  const double wanted_nm = 1.7 * 0.05;
  CHECK(motor.push(wanted_nm, 1.0) < 0.0);
  CHECK(motor.amperes == doctest::Approx(1.7).scale(0).epsilon(0.02));
  CHECK(motor.push(wanted_nm, 100.0) < 0.0);
  // The square of the current is what warms: 1 A is the default.
  CHECK(motor.amperes == doctest::Approx(1.0).scale(0).epsilon(0.03));
  motor.run(0.0, 60.0);  // cools down, let go
  CHECK(motor.push(wanted_nm, 0.2) < 0.0);
  CHECK(motor.amperes == doctest::Approx(1.7).scale(0).epsilon(0.02));
}
