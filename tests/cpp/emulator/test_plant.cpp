#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <vector>

#include "emulator/plant.hpp"

using namespace torsio::emulator;

namespace {

struct Choice {
  const char* name;
  Method method;
  std::int64_t step_ns;
  double tolerance;  // relative
};

/// The methods whose friction truly holds.
const std::vector<Choice> kSetValued{{"exact", Method::exact, 1'000'000, 1e-12},
                                     {"trapezoid", Method::trapezoid, 10'000, 2e-3},
                                     {"semi-implicit", Method::semi_implicit, 10'000, 2e-3}};

PlantParams with(const Choice& choice) {
  PlantParams params;
  params.integration.method = choice.method;
  params.integration.step_ns = choice.step_ns;
  return params;
}

/// Equal to the last bit.
bool same(const PlantState& a, const PlantState& b) {
  return a.time_ns == b.time_ns && a.knob_angle.revolutions == b.knob_angle.revolutions &&
         a.knob_angle.fraction_rad == b.knob_angle.fraction_rad && a.speed_rad_s == b.speed_rad_s &&
         a.twist_rad == b.twist_rad && a.motor_torque_nm == b.motor_torque_nm &&
         a.brake_capacity_nm == b.brake_capacity_nm;
}

}  // namespace

TEST_CASE("rigid knob decays as viscous and Coulomb friction say, and stops in finite time") {
  for (const Choice& choice : kSetValued) {
    CAPTURE(choice.name);
    PlantParams params = with(choice);
    params.spring_and_brake = false;
    Plant plant(params);
    PlantState start;
    start.speed_rad_s[0] = 18.0;
    plant.set_state(start);

    const double inertia = params.knob_inertia_kg_m2 + params.brake_inertia_kg_m2;
    const double viscous = params.knob_viscous_nm_s_per_rad + params.brake_viscous_nm_s_per_rad;
    const double coulomb = params.knob_coulomb_nm + params.brake_drag_nm;
    const double tau = inertia / viscous;
    const double stop_s = tau * std::log(1.0 + viscous * 18.0 / coulomb);
    const double way_rad = tau * 18.0 - coulomb / viscous * stop_s;

    plant.advance(100'000'000);
    const double expected = (18.0 + coulomb / viscous) * std::exp(-0.1 / tau) - coulomb / viscous;
    CHECK(plant.state().knob_speed_rad_s() == doctest::Approx(expected).epsilon(choice.tolerance));
    plant.advance(static_cast<std::int64_t>(stop_s * 1e9) - 100'000'000 - 100'000);
    CHECK(plant.state().knob_speed_rad_s() > 0.0);
    plant.advance(200'000);
    CHECK(plant.state().knob_speed_rad_s() == 0.0);
    CHECK(plant.state().knob_angle_rad() == doctest::Approx(way_rad).epsilon(choice.tolerance));
    const PlantState rest = plant.state();
    plant.advance(10'000'000'000);
    CHECK(plant.state().knob_angle.fraction_rad == rest.knob_angle.fraction_rad);
    CHECK(plant.state().brake_angle_rad() == plant.state().knob_angle_rad());
  }
}

TEST_CASE("brake holds a torque below its capacity with no creep at all") {
  for (const Choice& choice : kSetValued) {
    CAPTURE(choice.name);
    Plant plant(with(choice), TorqueHand{Profile({{0, 0.0}, {500'000'000, 0.05}})});
    plant.set_command({0.0, 0.06});
    plant.advance(2'000'000'000);
    CHECK(plant.state().knob_speed_rad_s() == 0.0);
    CHECK(plant.state().brake_speed_rad_s() == 0.0);
    CHECK(plant.truth().brake_sticks);
    CHECK(plant.truth().knob_sticks);
    const PlantState before = plant.state();
    plant.advance(60'000'000'000);
    CHECK(plant.state().knob_angle.fraction_rad == before.knob_angle.fraction_rad);
    CHECK(plant.state().twist_rad == before.twist_rad);
    // The spring has what the knob's own friction leaves to it.
    const Truth truth = plant.truth();
    CHECK(truth.hand_torque_nm + truth.spring_torque_nm + truth.knob_friction_torque_nm ==
          doctest::Approx(0.0).epsilon(1e-12));
    CHECK(truth.brake_torque_nm == doctest::Approx(truth.spring_torque_nm).epsilon(1e-9));
  }
}

TEST_CASE("brake slips when the torque passes its capacity, and carries its capacity then") {
  for (const Choice& choice : kSetValued) {
    CAPTURE(choice.name);
    PlantParams params = with(choice);
    // Slowly, so that the spring's torque follows the hand's less the knob's friction.
    Plant plant(params, TorqueHand{Profile({{0, 0.0}, {10'000'000'000, 0.1}})});
    plant.set_command({0.0, 0.03});
    const double breakaway_nm = params.knob_coulomb_nm + params.brake_drag_nm + 0.03;
    while (plant.state().brake_speed_rad_s() == 0.0) plant.advance(1'000'000);
    CHECK(plant.truth().hand_torque_nm == doctest::Approx(breakaway_nm).epsilon(2e-3));
    CHECK(plant.truth().brake_torque_nm == doctest::Approx(-0.032).epsilon(1e-4));
    CHECK_FALSE(plant.truth().brake_sticks);
  }
}

TEST_CASE("motor and brake answer a step with their exponentials, even in one long step") {
  for (const Choice& choice : kSetValued) {
    for (const std::int64_t step_ns : {choice.step_ns, std::int64_t{1'000'000'000}}) {
      CAPTURE(choice.name);
      PlantParams params = with(choice);
      params.integration.step_ns = step_ns;
      Plant plant(params, PrescribedMotion{Profile::constant(0.0)});
      plant.set_command({0.04, 0.08});
      plant.advance(250'000);
      CHECK(plant.truth().motor_torque_nm ==
            doctest::Approx(0.04 * -std::expm1(-2.5)).epsilon(1e-12));
      CHECK(plant.truth().brake_capacity_nm ==
            doctest::Approx(2e-3 + 0.08 * -std::expm1(-0.25 / 60.0)).epsilon(1e-12));
    }
  }
}

TEST_CASE("actuators without a lag answer at once") {
  PlantParams params;
  params.motor_time_constant_s = 0.0;
  params.brake_time_constant_s = 0.0;
  Plant plant(params);
  plant.set_command({1e-3, 0.02});
  plant.advance(1'000);
  CHECK(plant.state().motor_torque_nm == 1e-3);
  CHECK(plant.state().brake_capacity_nm == 0.02);
}

TEST_CASE("commands are clipped to the actuators' limits and refused when not finite") {
  PlantParams params;
  params.motor_time_constant_s = 0.0;
  params.brake_time_constant_s = 0.0;
  Plant plant(params);
  plant.set_command({-1.0, 1.0});
  plant.advance(1'000);
  CHECK(plant.state().motor_torque_nm == -85e-3);
  CHECK(plant.state().brake_capacity_nm == 110e-3);
  plant.set_command({0.0, -1.0});
  plant.advance(1'000);
  CHECK(plant.state().brake_capacity_nm == 0.0);
  CHECK_THROWS_WITH_AS(plant.set_command({NAN, 0.0}), doctest::Contains("motor_torque_nm"),
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(plant.set_command({0.0, INFINITY}), doctest::Contains("brake_torque_nm"),
                       std::invalid_argument);
}

TEST_CASE("plant is in the same state, to the bit, however a span is cut into calls") {
  for (const Choice& choice : kSetValued) {
    CAPTURE(choice.name);
    std::mt19937 random(1);
    for (int repeat = 0; repeat < 5; ++repeat) {
      const PlantParams params = with(choice);
      const Hand hand = TorqueHand{Profile({{0, 0.0},
                                            {7'123'456, 0.06},
                                            {20'000'001, -0.05},
                                            {20'000'001, 0.02},
                                            {40'000'000, 0.0}})};
      Plant whole(params, hand);
      Plant cut(params, hand);
      for (const double torque_nm : {0.03, -0.06, 0.01}) {
        whole.set_command({torque_nm, std::abs(torque_nm)});
        cut.set_command({torque_nm, std::abs(torque_nm)});
        const std::int64_t span_ns = 11'111'111;
        whole.advance(span_ns);
        std::int64_t left_ns = span_ns;
        while (left_ns > 0) {
          const std::int64_t part_ns = std::min<std::int64_t>(left_ns, random() % 200'000);
          cut.advance(part_ns);
          left_ns -= part_ns;
        }
        CHECK(same(whole.state(), cut.state()));
      }
    }
  }
}

TEST_CASE("energy never grows in a knob that is left alone") {
  for (const Choice& choice : kSetValued) {
    CAPTURE(choice.name);
    PlantParams params = with(choice);
    Plant plant(params);
    PlantState start;
    start.speed_rad_s = {20.0, -5.0, -5.0};
    start.twist_rad[0] = 0.02;
    plant.set_state(start);
    const auto energy = [&] {
      const PlantState& s = plant.state();
      return 0.5 * (params.knob_inertia_kg_m2 * s.speed_rad_s[0] * s.speed_rad_s[0] +
                    params.brake_inertia_kg_m2 * s.speed_rad_s[1] * s.speed_rad_s[1] +
                    params.shaft_stiffness_nm_per_rad * s.twist_rad[0] * s.twist_rad[0]);
    };
    double last = energy();
    for (int i = 0; i < 3'000; ++i) {
      plant.advance(100'000);
      CHECK(energy() <= last * (1.0 + 1e-12));
      last = energy();
    }
  }
}

TEST_CASE("plant refuses parameters out of their range by name") {
  const auto refuses = [](const char* field, auto change) {
    PlantParams params;
    change(params);
    CAPTURE(field);
    CHECK_THROWS_WITH_AS(Plant{params}, doctest::Contains(field), std::invalid_argument);
  };
  refuses("knob_inertia_kg_m2", [](PlantParams& p) { p.knob_inertia_kg_m2 = -1e-5; });
  refuses("brake_inertia_kg_m2", [](PlantParams& p) { p.brake_inertia_kg_m2 = 0.0; });
  refuses("knob_coulomb_nm", [](PlantParams& p) { p.knob_coulomb_nm = NAN; });
  refuses("shaft_stiffness_nm_per_rad", [](PlantParams& p) { p.shaft_stiffness_nm_per_rad = -1; });
  refuses("brake_time_constant_s", [](PlantParams& p) { p.brake_time_constant_s = INFINITY; });
  refuses("step_ns", [](PlantParams& p) { p.integration.step_ns = 0; });
  refuses("belt.pulley_inertia_kg_m2", [](PlantParams& p) { p.belt = Belt{60.0, 0.0, 1.0}; });
  refuses("need spring_and_brake", [](PlantParams& p) {
    p.spring_and_brake = false;
    p.belt = Belt{};
  });
  refuses("cogging.torque_nm", [](PlantParams& p) { p.cogging = Cogging{10, {1e-3, NAN}}; });
  refuses("shaft_hardening.knee_rad", [](PlantParams& p) { p.shaft_hardening = {0.0, 2.0}; });
}

TEST_CASE("plant refuses to run backwards or past the end of time") {
  Plant plant;
  CHECK_THROWS_AS(plant.advance(-1), std::invalid_argument);
  CHECK_THROWS_AS(plant.advance(INT64_MAX), std::invalid_argument);
  PlantState state;
  state.speed_rad_s[0] = NAN;
  CHECK_THROWS_AS(plant.set_state(state), std::invalid_argument);
}

TEST_CASE("plant ends at exact zeros long before it becomes subnormal, by every method") {
  for (const Method method :
       {Method::exact, Method::trapezoid, Method::semi_implicit, Method::regularised}) {
    CAPTURE(static_cast<int>(method));
    PlantParams params;
    params.integration.method = method;
    params.motor_time_constant_s = 0.05;
    Plant plant(params);
    plant.set_command({0.02, 0.1});
    plant.advance(1'000'000'000);
    plant.set_command({});
    for (int second = 0; second < 60; ++second) {
      plant.advance(1'000'000'000);
      const PlantState& state = plant.state();
      for (const double value : {state.motor_torque_nm, state.brake_capacity_nm}) {
        CHECK(std::fpclassify(value) != FP_SUBNORMAL);
      }
    }
    CHECK(plant.state().motor_torque_nm == 0.0);
    CHECK(plant.state().brake_capacity_nm == 0.0);
  }
}
