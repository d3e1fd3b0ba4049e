// The choice of a method for a tolerance. The true error is against the same plant with exact
// steps, which are themselves tested against other solutions.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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

TEST_CASE("fidelity estimates an error that is not below the true one, nor far above it") {
  // Sums of what single steps add take no account of what cancels or dies away, so that they may be
  // 50 times too large; what is not sampled may make them a little too small.
  int compared = 0;
  for (const Scene& scene : scenes()) {
    for (const double tolerance : {0.5, 0.1, 1e-2, 1e-3}) {
      CAPTURE(scene.name);
      CAPTURE(tolerance);
      const Outcome outcome = play(scene, tolerance);
      if (outcome.true_error < 1e-9) continue;  // all steps were exact
      ++compared;
      CHECK(outcome.report.estimated_error >= 0.9 * outcome.true_error);
      CHECK(outcome.report.estimated_error <= 50.0 * outcome.true_error + 1e-9);
    }
  }
  CHECK(compared >= 8);
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
  // The belt's own swing makes exact steps dear.
  PlantParams params;
  params.belt = Belt{};
  const Scene belt{"belt", params, scenes()[0].hand, varied(2500)};
  const FidelityReport loose = play(belt, 0.5).report;
  CHECK(loose.steps[static_cast<std::size_t>(Method::exact)] < 2000);
  CHECK(loose.steps_checked < 400);
  CHECK(loose.relative_cost < 1.0);
}

TEST_CASE("fidelity decides alike however a span of time is cut into calls") {
  PlantParams params;
  params.belt = Belt{};
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
