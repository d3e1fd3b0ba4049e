// The choice of a method for a tolerance. The true error is against the same plant with exact
// steps, which are themselves tested against other solutions.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "emulator/plant.hpp"

using namespace torsio::emulator;

namespace {

constexpr std::int64_t kMs = 1'000'000;

struct Scene {
  const char* name;
  PlantParams params;
  Hand hand;
  std::vector<Command> commands;  // one a millisecond
};

std::vector<Command> varied(int count) {
  std::vector<Command> commands;
  for (int i = 0; i < count; ++i) {
    commands.push_back({-0.01 - 0.005 * (i / 100 % 3), 0.03 + 0.01 * (i / 400 % 4)});
  }
  return commands;
}

std::vector<Scene> scenes() {
  const Hand held =
      ImpedanceHand{1e-4, 1.0, 10e-3,
                    Profile({{0, 0.0}, {1000 * kMs, 0.4}, {1200 * kMs, 0.4}, {2200 * kMs, 0.0}})};
  const Hand cut =
      TorqueHand{Profile({{0, 0.0}, {100 * kMs, 0.05}, {300 * kMs, 0.05}, {300 * kMs, 0.0}})};
  PlantParams plain;
  PlantParams rigid;
  rigid.spring_and_brake = false;
  PlantParams belt;
  belt.belt = Belt{};
  PlantParams cogging;
  cogging.cogging = Cogging::sine(36, 2e-3);
  std::vector<Command> let_go(1500, Command{});
  std::fill_n(let_go.begin(), 300, Command{-0.02, 0.05});
  return {{"held", plain, held, varied(2500)},
          {"string cut", plain, cut, let_go},
          {"rigid, string cut", rigid, cut, let_go},
          {"belt", belt, held, varied(2500)},
          {"cogging", cogging, held, varied(2500)}};
}

/// One of a wide family: every part, every hand, commands that jump now and then.
Scene random_scene(std::uint64_t seed) {
  std::mt19937_64 source(seed);  // not its distributions, which differ between libraries
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(source() >> 11) * 0x1p-53;
  };
  const auto whole = [&](int low, int high) {
    return low + static_cast<int>(source() % static_cast<std::uint64_t>(high - low));
  };
  Scene scene{"random", {}, NoHand{}, {}};
  const int kind = whole(0, 9);
  if (kind == 1 || kind >= 6) {
    scene.params.belt = Belt{std::pow(10.0, uniform(3.0, 4.5)), 1e-3, 1e-5};
  }
  if (kind == 2 || kind == 8) {
    scene.params.cogging = Cogging::sine(whole(5, 80), std::pow(10.0, uniform(-3.3, -2.2)));
  }
  if (kind == 3) scene.params.shaft_hardening = ShaftHardening{0.008, uniform(0.3, 4.0)};
  if (kind == 4) scene.params.brake_hysteresis = BrakeHysteresis{};
  if (kind == 5) scene.params.spring_and_brake = false;
  const int count = whole(500, 2000);
  const int hold = whole(1, 60);
  const double motor_nm = uniform(0.0, 0.08);
  const double brake_nm = uniform(0.0, 0.1);
  Command command;
  for (int i = 0; i < count; ++i) {
    if (i % hold == 0) {
      command.motor_torque_nm = uniform(-motor_nm, motor_nm);
      command.brake_torque_nm = uniform(0.0, brake_nm);
    }
    scene.commands.push_back(command);
  }
  const Profile path({{0, 0.0}, {1000 * kMs, 0.4}, {2000 * kMs, 0.0}});
  const int hand = whole(0, 6);
  if (hand == 1 || hand == 4) {
    scene.hand = ImpedanceHand{1e-4, std::pow(10.0, uniform(-1.0, 1.0)), 10e-3, path};
  }
  if (hand == 2) {
    scene.hand =
        TorqueHand{Profile({{0, 0.0}, {400 * kMs, 0.05}, {800 * kMs, 0.05}, {800 * kMs, 0.0}})};
  }
  if (hand == 3 || hand == 5) scene.hand = PrescribedMotion{path};
  return scene;
}

struct Outcome {
  double true_error;
  FidelityReport report;
};

Outcome play(const Scene& scene, double tolerance) {
  PlantParams params = scene.params;
  Plant exact(params, scene.hand);
  params.integration.tolerance = tolerance;
  Plant plant(params, scene.hand);
  double lowest = 0.0;
  double highest = 0.0;
  double peak = 1e-3;
  double angle = 0.0;
  double torque = 0.0;
  for (const Command& command : scene.commands) {
    for (Plant* each : {&exact, &plant}) {
      each->set_command(command);
      each->advance(kMs);
    }
    const double true_angle = exact.state().knob_angle_rad();
    const double true_torque = exact.truth().spring_torque_nm;
    lowest = std::min(lowest, true_angle);
    highest = std::max(highest, true_angle);
    peak = std::max(peak, std::abs(true_torque));
    angle = std::max(angle, std::abs(plant.state().knob_angle_rad() - true_angle));
    torque = std::max(torque, std::abs(plant.truth().spring_torque_nm - true_torque));
  }
  return {std::max(angle / std::max(highest - lowest, 1e-3), torque / peak), plant.fidelity()};
}

}  // namespace

TEST_CASE("fidelity keeps every tolerance asked for, in every scene, and says so") {
  for (const Scene& scene : scenes()) {
    for (const double tolerance : {0.5, 0.1, 1e-2, 1e-3, 1e-6, 1e-9}) {
      CAPTURE(scene.name);
      CAPTURE(tolerance);
      const Outcome outcome = play(scene, tolerance);
      CHECK(outcome.true_error <= tolerance);
      CHECK(outcome.report.estimated_error <= tolerance);
      CHECK(outcome.report.tolerance == tolerance);
    }
  }
}

TEST_CASE("fidelity keeps tolerances for random plants, hands and commands, and knows its error") {
  int cheap = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Scene scene = random_scene(seed);
    for (const double tolerance : {0.5, 0.1, 1e-2, 1e-3}) {
      CAPTURE(seed);
      CAPTURE(tolerance);
      const Outcome outcome = play(scene, tolerance);
      CHECK(outcome.true_error <= tolerance);
      CHECK(outcome.report.estimated_error <= tolerance);
      if (outcome.true_error < 1e-9) continue;  // all steps were exact
      ++cheap;
      // Small ones are known by few samples.
      const double least = outcome.true_error > 0.1 * tolerance ? 0.9 * outcome.true_error : 0.0;
      CHECK(outcome.report.estimated_error >= least);
      CHECK(outcome.report.estimated_error <= 50.0 * outcome.true_error + 0.1 * tolerance);
    }
  }
  CHECK(cheap >= 20);
}

TEST_CASE("fidelity takes no cheap steps for a knob that nothing holds") {
  // An error of speed would become one of angle, exact steps or not. The belt makes them tempting.
  for (const Hand& hand : {Hand{NoHand{}}, Hand{TorqueHand{Profile::constant(0.02)}}}) {
    PlantParams params;
    params.belt = Belt{1e4, 1e-3, 1e-5};
    const FidelityReport report = play({"free", params, hand, varied(500)}, 0.5).report;
    CHECK(report.steps[static_cast<std::size_t>(Method::exact)] == 500);
  }
}

TEST_CASE("fidelity lets an inherited error of speed drift until the knob rests") {
  FidelityAccount account(0.1);
  account.see(0.0, 0.0);
  account.see(2.0, 0.0);
  account.carry({0.01, 0.0, 0.5});  // rad, N m, rad/s
  CHECK(account.estimate() == doctest::Approx(0.005));
  account.drift(0.1);
  CHECK(account.estimate() == doctest::Approx(0.03));
  account.rest();
  account.drift(0.1);
  CHECK(account.estimate() == doctest::Approx(0.03));
  account.meet({0.01, 0.0, 0.0});  // for a moment
  account.meet({});
  CHECK(account.estimate() == doctest::Approx(0.035));
  CHECK(account.carried() == doctest::Approx(0.03));
}

TEST_CASE("fidelity takes cheap steps where they are good enough and exact ones where not") {
  for (const Scene& scene : scenes()) {
    CAPTURE(scene.name);
    const FidelityReport strict = play(scene, 1e-7).report;
    CHECK(strict.steps[static_cast<std::size_t>(Method::exact)] ==
          static_cast<std::int64_t>(scene.commands.size()));
    CHECK(strict.method == Method::exact);
    CHECK(strict.steps[static_cast<std::size_t>(Method::regularised)] == 0);
  }
  // The swing of a stiff belt makes exact steps dear.
  PlantParams params;
  params.belt = Belt{1e4, 1e-3, 1e-5};
  const FidelityReport loose =
      play({"stiff belt", params, scenes()[0].hand, varied(2500)}, 0.1).report;
  CHECK(loose.steps[static_cast<std::size_t>(Method::trapezoid)] > 1800);
  CHECK(loose.steps_checked < 500);
  CHECK(loose.relative_cost < 0.7);
}

TEST_CASE("fidelity costs hardly more than exact steps where these are the best") {
  for (const Scene& scene : scenes()) {
    for (const double tolerance : {0.5, 1e-2, 1e-4}) {
      CAPTURE(scene.name);
      CAPTURE(tolerance);
      CHECK(play(scene, tolerance).report.relative_cost <= 1.1);
    }
  }
}

TEST_CASE("fidelity decides alike however a span of time is cut into calls") {
  PlantParams params;
  params.belt = Belt{1e4, 1e-3, 1e-5};
  params.integration.tolerance = 0.1;
  const Hand hand = scenes()[0].hand;
  Plant whole(params, hand);
  Plant cut(params, hand);
  for (const Command& command : varied(1000)) {
    whole.set_command(command);
    cut.set_command(command);
    whole.advance(kMs);
    for (const std::int64_t part : {kMs / 3, kMs / 7, kMs - kMs / 3 - kMs / 7}) cut.advance(part);
  }
  CHECK(whole.state().knob_angle.fraction_rad == cut.state().knob_angle.fraction_rad);
  CHECK(whole.state().speed_rad_s == cut.state().speed_rad_s);
  CHECK(whole.fidelity().estimated_error == cut.fidelity().estimated_error);
  CHECK(whole.fidelity().steps == cut.fidelity().steps);
  CHECK(whole.fidelity().steps[static_cast<std::size_t>(Method::exact)] < 1000);
  CHECK(whole.fidelity().steps_checked == cut.fidelity().steps_checked);
}

TEST_CASE("fidelity goes on counting when another hand takes over") {
  PlantParams params;
  params.integration.tolerance = 0.1;
  Plant plant(params, scenes()[1].hand);
  plant.advance(100 * kMs);
  plant.set_hand(NoHand{});
  plant.advance(100 * kMs);
  std::int64_t steps = 0;
  for (const std::int64_t count : plant.fidelity().steps) steps += count;
  CHECK(steps == 200);
}

TEST_CASE("fidelity refuses a tolerance that nothing can keep, and says why") {
  for (const double tolerance : {0.0, -1.0, 1e-12, std::nan("")}) {
    CAPTURE(tolerance);
    PlantParams params;
    params.integration.tolerance = tolerance;
    CHECK_THROWS_WITH_AS(Plant{params}, doctest::Contains("integration.tolerance"),
                         std::invalid_argument);
  }
}

TEST_CASE("fidelity without a tolerance reports the method that was given") {
  PlantParams params;
  params.integration.method = Method::trapezoid;
  params.integration.step_ns = 50'000;
  const FidelityReport report = Plant(params).fidelity();
  CHECK(report.tolerance == 0.0);
  CHECK(report.method == Method::trapezoid);
  CHECK(report.step_ns == 50'000);
}
