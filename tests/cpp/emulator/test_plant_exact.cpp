#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <vector>

#include "emulator/plant/exact/ladder.hpp"
#include "emulator/plant/exact/taylor.hpp"
#include "emulator/plant/plant.hpp"
#include "plant_tracks.hpp"

using namespace torsio::emulator;
using namespace torsio::emulator::test;

TEST_CASE("rung of the ladder is the matrix exponential") {
  PlantParams params;
  params.motor_time_constant_s = 0.1e-3;  // as for the numbers below
  PlantModel model = make_model(params, ImpedanceHand{1e-4, 1.0, 0.01, Profile::constant(0.0)});
  const Chain<2> chain(model);
  Regime regime;
  regime.knob = Slip::forward;
  regime.brake = Slip::forward;
  std::vector<Rung<2>> rungs(10);
  build_ladder<2>(chain, regime, 1e-3 / 512, rungs);

  using C = Chain<2>;
  const std::size_t place[]{C::kTwist, C::kSpeed, C::kLast,    C::kTravel,   C::kMotorGap,
                            C::kForce, C::kSlope, C::kCoulomb, C::kBrakeGap, C::kCapacity};
  // exp(M 1 ms) of the same equations by mpmath 1.3 with 40 digits, and by SciPy's expm.
  const double expected[4][10] = {
      {0.9557242840539544, 0.0009506949527371166, -0.0009820667103553652, 0.0,
       0.0005378301085260511, 0.0030298710043969927, 1.0190331255541087e-06, -0.0030298710043969927,
       0.012312360156264636, 0.012381098694887948},
      {-17.07091624508585, 0.9265948339553054, 0.009893011406083957, 0.0, 0.5841302648619927,
       6.030183689607799, 0.003053356286132831, -6.030183689607799, -0.08795019017326715,
       -0.08834023500082203},
      {70.5369414712741, 0.039572045624335826, 0.9594694898818223, 0.0, 0.020587895515525867,
       0.08834023500082203, 2.3485281735838414e-05, -0.08834023500082203, -24.434411946452983,
       -24.640007993884947},
      {-0.008704819395632562, 0.0009648293903372481, 3.533609400032882e-06, 1.0,
       0.0005446053424745807, 0.003053356286132831, 1.024003167387765e-06, -0.003053356286132831,
       -2.3402689653293438e-05, -2.3485281735838414e-05}};
  CHECK(rungs[0].step_s == doctest::Approx(1e-3).scale(0).epsilon(1e-15));
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 10; ++column) {
      CAPTURE(row);
      CAPTURE(column);
      C::Vector unit{};
      unit[place[column]] = 1.0;
      const auto next = advanced<2>(chain, regime, rungs[0], unit, chain.drives(unit, regime));
      CHECK(next[place[row]] == doctest::Approx(expected[row][column]).scale(1).epsilon(1e-13));
    }
  }
}

TEST_CASE("Taylor series of the longest cell agrees with the exponential to 1e-11") {
  PlantModel model = make_model({}, ImpedanceHand{1e-4, 1.0, 0.01, Profile::constant(0.0)});
  const Chain<2> chain(model);
  const double cell_s = 0.7 / (chain.fastest_oscillation() + chain.fastest_decay());
  Regime regime;
  regime.knob = Slip::forward;
  regime.brake = Slip::backward;
  // The exponential's own series is over 1/64 of the cell, and doubled from there.
  std::vector<Rung<2>> rungs(7);
  build_ladder<2>(chain, regime, cell_s / 64, rungs);
  using C = Chain<2>;
  for (std::size_t column = 0; column < C::kSize; ++column) {
    CAPTURE(column);
    C::Vector z{};
    z[column] = 1.0;
    const auto expected = advanced<2>(chain, regime, rungs[0], z, chain.drives(z, regime));
    const auto got = value_at<2>(taylor_series(chain, z, regime, cell_s), 1.0);
    for (std::size_t row = 0; row < C::kSize; ++row) {
      CAPTURE(row);
      CHECK(std::abs(got[row] - expected[row]) <= 1e-11 * std::abs(expected[row]));
    }
  }
}

TEST_CASE("exact stepper gives the same at any step, for every part") {
  for (const Variant& variant : variants()) {
    CAPTURE(variant.name);
    const Track coarse = track(variant.params, variant.hand, 1'000'000);
    for (const std::int64_t step_ns : {std::int64_t{37'137}, std::int64_t{5'000'000}}) {
      const Track other = track(variant.params, variant.hand, step_ns);
      CHECK(relative_error(other, coarse) < 1e-10);
    }
  }
}

TEST_CASE("exact stepper works without any friction, stiffness or lag") {
  PlantParams params;
  params.knob_coulomb_nm = params.brake_drag_nm = 0.0;
  params.knob_viscous_nm_s_per_rad = params.brake_viscous_nm_s_per_rad = 0.0;
  params.shaft_damping_nm_s_per_rad = 0.0;
  params.motor_time_constant_s = params.brake_time_constant_s = 0.0;
  {
    // An undamped oscillation of the knob against the brake's shaft.
    Plant plant(params);
    PlantState start;
    start.twist_rad[0] = 0.01;
    plant.set_state(start);
    plant.advance(1'000'000'000);
    const double omega =
        std::sqrt(params.shaft_stiffness_nm_per_rad *
                  (1.0 / params.knob_inertia_kg_m2 + 1.0 / params.brake_inertia_kg_m2));
    CHECK(plant.state().twist_rad[0] ==
          doctest::Approx(0.01 * std::cos(omega)).scale(0).epsilon(1e-9));
  }
  params.shaft_stiffness_nm_per_rad = 0.0;
  {
    // A cut shaft: a free mass under a constant torque.
    Plant plant(params);
    plant.set_command({0.01, 0.0});
    plant.advance(100'000'000);
    CHECK(plant.state().knob_speed_rad_s() ==
          doctest::Approx(0.01 / params.knob_inertia_kg_m2 * 0.1).scale(0).epsilon(1e-12));
    CHECK(plant.state().brake_speed_rad_s() == 0.0);
  }
}

TEST_CASE("exact stepper refuses a plant too fast for its step") {
  PlantParams params;
  params.motor_time_constant_s = 1e-18;
  CHECK_THROWS_WITH_AS(Plant{params}, doctest::Contains("step_ns"), std::invalid_argument);
}
