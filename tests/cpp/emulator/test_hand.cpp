#include <doctest/doctest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "emulator/plant/plant.hpp"

using namespace torsio::emulator;

TEST_CASE("hand refuses quantities out of their range and paths that jump") {
  CHECK_THROWS_WITH_AS(Plant({}, ImpedanceHand{-1.0, 0.0, 0.0, Profile::constant(0.0)}),
                       doctest::Contains("inertia_kg_m2"), std::invalid_argument);
  CHECK_THROWS_WITH_AS(Plant({}, ImpedanceHand{0.0, NAN, 0.0, Profile::constant(0.0)}),
                       doctest::Contains("stiffness_nm_per_rad"), std::invalid_argument);
  CHECK_THROWS_WITH_AS(Plant({}, PrescribedMotion{Profile({{0, 0.0}, {0, 1.0}})}),
                       doctest::Contains("angle_rad"), std::invalid_argument);
}

TEST_CASE("hand refuses what no hand can do, by name") {
  for (const double nm : {101.0, -1e9, 1e290, 1e308}) {
    CAPTURE(nm);
    CHECK_THROWS_WITH_AS(Plant({}, TorqueHand{Profile::constant(nm)}),
                         doctest::Contains("torque_nm"), std::invalid_argument);
  }
  for (const double rad : {1e10, -1e290, 1e308}) {
    CAPTURE(rad);
    CHECK_THROWS_WITH_AS(Plant({}, PrescribedMotion{Profile::constant(rad)}),
                         doctest::Contains("angle_rad"), std::invalid_argument);
    CHECK_THROWS_WITH_AS(Plant({}, ImpedanceHand{0.0, 1.0, 0.0, Profile::constant(rad)}),
                         doctest::Contains("intended_angle_rad"), std::invalid_argument);
  }
  CHECK_THROWS_WITH_AS(Plant({}, PrescribedMotion{Profile({{0, 0.0}, {1, 1.0}})}),
                       doctest::Contains("speed"), std::invalid_argument);
  for (const double much : {1e9, 1e308, double{INFINITY}}) {
    CHECK_THROWS_AS(Plant({}, ImpedanceHand{much, 1.0, 1.0, Profile::constant(0.0)}),
                    std::invalid_argument);
    CHECK_THROWS_AS(Plant({}, ImpedanceHand{0.0, much, 1.0, Profile::constant(0.0)}),
                    std::invalid_argument);
    CHECK_THROWS_AS(Plant({}, ImpedanceHand{0.0, 1.0, much, Profile::constant(0.0)}),
                    std::invalid_argument);
  }
}

TEST_CASE("what turns too fast ends with a sentence, not with nonsense and not for ever") {
  PlantParams params;
  params.knob_inertia_kg_m2 = 1e-9;
  params.knob_viscous_nm_s_per_rad = 0.0;
  Plant light(params, TorqueHand{Profile::constant(100.0)});
  CHECK_THROWS_AS(light.advance(1'000'000'000), std::runtime_error);

  params = {};
  params.knob_viscous_nm_s_per_rad = 0.0;
  Plant pushed(params, TorqueHand{Profile::constant(100.0)});
  CHECK_THROWS_WITH_AS(pushed.advance(10'000'000'000), doctest::Contains("turns faster"),
                       std::runtime_error);
}

TEST_CASE("prescribed motion at constant speed takes the hand's torque against all friction") {
  PlantParams params;
  Plant plant(params, PrescribedMotion{Profile({{0, 0.0}, {9'000'000'000, 18.0}})});
  plant.set_command({0.0, 0.03});
  plant.advance(8'000'000'000);
  const double friction_nm =
      params.knob_coulomb_nm + params.brake_drag_nm + 0.03 +
      2.0 * (params.knob_viscous_nm_s_per_rad + params.brake_viscous_nm_s_per_rad);
  CHECK(plant.truth().hand_torque_nm == doctest::Approx(friction_nm).scale(0).epsilon(1e-6));
  CHECK(plant.truth().brake_torque_nm == doctest::Approx(-0.032).scale(0).epsilon(1e-6));
}

TEST_CASE("hands change without a jump of the motion") {
  Plant plant({}, TorqueHand{Profile::constant(0.03)});
  plant.advance(20'000'000);
  const PlantState before = plant.state();
  plant.set_hand(ImpedanceHand{1e-4, 1.0, 0.01, Profile::constant(0.0)});
  CHECK(plant.state().knob_speed_rad_s() == before.knob_speed_rad_s());
  CHECK(plant.state().knob_angle_rad() == before.knob_angle_rad());
  CHECK(plant.state().time_ns == before.time_ns);
  CHECK_THROWS_AS(plant.set_hand(ImpedanceHand{NAN, 0, 0, Profile::constant(0)}),
                  std::invalid_argument);
  plant.advance(1'000'000);  // with the hand it has
}

TEST_CASE("a hand that is a function is asked once a period, however the time is cut") {
  std::vector<double> asked;
  const auto hand = take_hold(torsio::FeedbackHand{[&](double time_s, double, double) {
                                                     asked.push_back(time_s);
                                                     return 0.02;
                                                   },
                                                   2e-3},
                              0);
  Plant plant({}, hand);
  Plant constant({}, TorqueHand{Profile::constant(0.02)});
  for (int i = 0; i < 50; ++i) plant.advance(100'000);
  constant.advance(5'000'000);
  CHECK(asked == std::vector<double>{0.0, 2e-3, 4e-3});
  CHECK(plant.state().knob_angle_rad() == doctest::Approx(constant.state().knob_angle_rad()));
}

TEST_CASE("a hand's function that throws leaves a plant that can go on") {
  bool tired = false;
  const auto hand = take_hold(torsio::FeedbackHand{[&](double, double, double) {
                                                     if (tired) throw std::runtime_error("tired");
                                                     return 0.02;
                                                   },
                                                   1e-3},
                              0);
  Plant plant({}, hand);
  plant.advance(2'500'000);
  tired = true;
  CHECK_THROWS_WITH(plant.advance(1'000'000), "tired");
  tired = false;
  plant.advance(2'000'000);
  CHECK(plant.truth().hand_torque_nm == 0.02);
}

TEST_CASE("a hand that is a function refuses what makes no sense") {
  CHECK_THROWS_WITH_AS(Plant({}, take_hold(torsio::FeedbackHand{})),
                       doctest::Contains("torque_nm must be a function"), std::invalid_argument);
  const auto nothing = [](double, double, double) { return 0.0; };
  CHECK_THROWS_WITH_AS(static_cast<void>(take_hold(torsio::FeedbackHand{nothing, 2.0})),
                       doctest::Contains("period_s"), std::invalid_argument);
  CHECK_THROWS_WITH_AS(
      Plant({},
            take_hold(torsio::FeedbackHand{[](double, double, double) { return double{NAN}; }})),
      doctest::Contains("it must give -100 to 100 N m"), std::runtime_error);
}
