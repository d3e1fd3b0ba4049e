/// @file Cases for a plant, whichever stepper it has. A test program includes this once, and names
/// its steppers.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "emulator/plant/plant.hpp"

namespace torsio::emulator::test {

struct Choice {
  const char* name;
  MakeStepper make;
  std::int64_t step_ns;
  double tolerance;  // relative

  [[nodiscard]] Plant plant(const PlantParams& params, Hand hand = NoHand{}) const {
    return Plant(params, std::move(hand), step_ns, make);
  }
};

/// Those whose friction truly holds.
[[nodiscard]] std::vector<Choice> steppers_that_hold();
[[nodiscard]] std::vector<Choice> all_steppers();

/// Equal to the last bit.
inline bool same(const PlantState& a, const PlantState& b) {
  return a.time_ns == b.time_ns && a.knob_angle.revolutions == b.knob_angle.revolutions &&
         a.knob_angle.fraction_rad == b.knob_angle.fraction_rad && a.speed_rad_s == b.speed_rad_s &&
         a.twist_rad == b.twist_rad && a.motor_torque_nm == b.motor_torque_nm &&
         a.brake_magnetic_nm == b.brake_magnetic_nm;
}

TEST_CASE("rigid knob decays as viscous and Coulomb friction say, and stops in finite time") {
  for (const Choice& choice : steppers_that_hold()) {
    CAPTURE(choice.name);
    PlantParams params;
    params.spring_and_brake = false;
    Plant plant = choice.plant(params);
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
    CHECK(plant.state().knob_speed_rad_s() ==
          doctest::Approx(expected).scale(0).epsilon(choice.tolerance));
    plant.advance(static_cast<std::int64_t>(stop_s * 1e9) - 100'000'000 - 100'000);
    CHECK(plant.state().knob_speed_rad_s() > 0.0);
    plant.advance(200'000);
    CHECK(plant.state().knob_speed_rad_s() == 0.0);
    CHECK(plant.state().knob_angle_rad() ==
          doctest::Approx(way_rad).scale(0).epsilon(choice.tolerance));
    const PlantState rest = plant.state();
    plant.advance(10'000'000'000);
    CHECK(plant.state().knob_angle.fraction_rad == rest.knob_angle.fraction_rad);
    CHECK(plant.state().brake_angle_rad() == plant.state().knob_angle_rad());
  }
}

TEST_CASE("brake holds a torque below its capacity with no creep at all") {
  for (const Choice& choice : steppers_that_hold()) {
    CAPTURE(choice.name);
    Plant plant = choice.plant({}, TorqueHand{Profile({{0, 0.0}, {500'000'000, 0.05}})});
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
    // The spring has the rest behind the knob's own friction.
    const Truth truth = plant.truth();
    CHECK(truth.hand_torque_nm + truth.spring_torque_nm + truth.knob_friction_torque_nm ==
          doctest::Approx(0.0).scale(1).epsilon(1e-12));
    CHECK(truth.brake_torque_nm == doctest::Approx(truth.spring_torque_nm).scale(0).epsilon(1e-9));
  }
}

TEST_CASE("plant is in the same state, to the bit, however a span is cut into calls") {
  for (const Choice& choice : steppers_that_hold()) {
    CAPTURE(choice.name);
    std::mt19937 random(1);
    for (int repeat = 0; repeat < 5; ++repeat) {
      const Hand hand = TorqueHand{Profile({{0, 0.0},
                                            {7'123'456, 0.06},
                                            {20'000'001, -0.05},
                                            {20'000'001, 0.02},
                                            {40'000'000, 0.0}})};
      Plant whole = choice.plant({}, hand);
      Plant cut = choice.plant({}, hand);
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
  for (const Choice& choice : steppers_that_hold()) {
    CAPTURE(choice.name);
    const PlantParams params;
    Plant plant = choice.plant(params);
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

TEST_CASE("plant ends at exact zeros long before it becomes subnormal, by every method") {
  for (const Choice& choice : all_steppers()) {
    CAPTURE(choice.name);
    PlantParams params;
    params.motor_time_constant_s = 0.05;
    Plant plant(params, NoHand{}, Plant::kStepNs, choice.make);
    plant.set_command({0.02, 0.1});
    plant.advance(1'000'000'000);
    plant.set_command({});
    for (int second = 0; second < 60; ++second) {
      plant.advance(1'000'000'000);
      const PlantState& state = plant.state();
      for (const double value : {state.motor_torque_nm, state.brake_magnetic_nm}) {
        CHECK(std::fpclassify(value) != FP_SUBNORMAL);
      }
    }
    CHECK(plant.state().motor_torque_nm == 0.0);
    CHECK(plant.state().brake_magnetic_nm == 0.0);
  }
}

}  // namespace torsio::emulator::test
