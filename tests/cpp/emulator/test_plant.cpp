#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "emulator/plant/plant.hpp"
#include "plant_cases.hpp"

using namespace torsio::emulator;

namespace torsio::emulator::test {

std::vector<Choice> steppers_that_hold() {
  return {{"exact", make_exact_stepper, 1'000'000, 1e-12}};
}
std::vector<Choice> all_steppers() { return steppers_that_hold(); }

}  // namespace torsio::emulator::test

TEST_CASE("commands are clipped to the actuators' limits and refused when not finite") {
  PlantParams params;
  params.motor_time_constant_s = 0.0;
  params.brake_time_constant_s = 0.0;
  Plant plant(params);
  plant.set_command({-1.0, 1.0});
  plant.advance(1'000);
  CHECK(plant.state().motor_torque_nm == -85e-3);
  CHECK(plant.state().brake_magnetic_nm == 110e-3);
  plant.set_command({0.0, -1.0});
  plant.advance(1'000);
  CHECK(plant.state().brake_magnetic_nm == 0.0);
  CHECK_THROWS_WITH_AS(plant.set_command({NAN, 0.0}), doctest::Contains("motor_command_nm"),
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(plant.set_command({0.0, INFINITY}), doctest::Contains("brake_command_nm"),
                       std::invalid_argument);
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
  refuses("belt.pulley_inertia_kg_m2", [](PlantParams& p) { p.belt = Belt{60.0, 0.0, 1.0}; });
  refuses("need spring_and_brake", [](PlantParams& p) {
    p.spring_and_brake = false;
    p.belt = Belt{};
  });
  refuses("cogging.torque_nm", [](PlantParams& p) { p.cogging = Cogging{10, {1e-3, NAN}}; });
  refuses("shaft_hardening.knee_rad", [](PlantParams& p) { p.shaft_hardening = {0.0, 2.0}; });
  CHECK_THROWS_WITH_AS(Plant({}, NoHand{}, 0), doctest::Contains("step_ns"), std::invalid_argument);
}

TEST_CASE("plant refuses to run backwards or past the end of time") {
  Plant plant;
  CHECK_THROWS_AS(plant.advance(-1), std::invalid_argument);
  CHECK_THROWS_AS(plant.advance(INT64_MAX), std::invalid_argument);
  PlantState state;
  state.speed_rad_s[0] = NAN;
  CHECK_THROWS_AS(plant.set_state(state), std::invalid_argument);
}
