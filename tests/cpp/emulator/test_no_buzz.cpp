// Bounded stiffness: stiffness, speed, hand, delay and rate, each against a knob at rest.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "emulator/closed_loop.hpp"

namespace {

using torsio::LoopRow;
using torsio::emulator::ClosedLoop;
using torsio::emulator::ClosedLoopOptions;
namespace protocol = torsio::protocol;
namespace emulator = torsio::emulator;

enum class Held { off, stiff, soft, weight };

struct Trial {
  protocol::Law law = protocol::Law::calibrated;
  bool two_sided = false;  // a spring instead of a wall
  double stiffness_nm_per_rad = 0;
  double speed_rad_s = 1;
  Held held = Held::off;
  std::uint32_t delay_ticks = 0;
  std::int64_t rate_hz = 10'000;
  bool knocks = false;  // a hard Impact at the surface
};

constexpr double kStartRad = -0.02;
constexpr double kPushNm = 0.04;
constexpr auto kWayTurnsQ32 =
    static_cast<std::int64_t>(-kStartRad / (2.0 * std::numbers::pi) * 0x1p32);

ClosedLoopOptions options_of(const Trial& trial, double& contact_s) {
  ClosedLoopOptions options;
  options.control_period_ns = 1'000'000'000 / trial.rate_hz;
  options.delay_ticks = trial.delay_ticks;
  options.control.law = trial.law;
  if (trial.two_sided) {
    protocol::Spring spring;
    spring.stiffness_nm_per_rad = static_cast<float>(trial.stiffness_nm_per_rad);
    spring.torque_limit_nm = 1.0F;
    options.scene.emplace_back(spring);
  } else {
    protocol::Wall wall;
    wall.side = protocol::Side::above;
    wall.stiffness_nm_per_rad = static_cast<float>(trial.stiffness_nm_per_rad);
    options.scene.emplace_back(wall);
  }
  if (trial.knocks) {
    protocol::Impact impact;
    impact.strength_nm_s_per_rad = impact.pulse_nm_s_per_rad = 0.03F;
    impact.decay_s = 0.02F;
    impact.pulse_s = 0.02F;
    // Counted from where the knob begins, which must be outside.
    impact.angle_turns_q32 = kWayTurnsQ32;
    std::get<protocol::Wall>(options.scene.front()).angle_turns_q32 = kWayTurnsQ32;
    options.scene.emplace_back(impact);
  }
  emulator::PlantState state;
  state.knob_angle = emulator::Angle::from_rad(kStartRad);
  contact_s = -kStartRad / trial.speed_rad_s;
  const bool thrown = trial.held == Held::off || trial.held == Held::weight;
  if (thrown) state.speed_rad_s = {trial.speed_rad_s, trial.speed_rad_s, 0.0};
  if (trial.held == Held::weight) {
    options.hand = emulator::TorqueHand{emulator::Profile::constant(kPushNm)};
  } else if (!thrown) {
    const bool stiff = trial.held == Held::stiff;
    const double stiffness = stiff ? 30.0 : 0.7;
    const double depth_rad = kPushNm / stiffness;
    const double arrival_s = (depth_rad - kStartRad) / trial.speed_rad_s;
    emulator::ImpedanceHand hand;
    hand.stiffness_nm_per_rad = stiffness;
    hand.damping_nm_s_per_rad = stiff ? 0.1 : 0.005;
    hand.inertia_kg_m2 = stiff ? 5e-5 : 1e-5;
    hand.intended_angle_rad = emulator::Profile(std::vector<emulator::ProfileKnot>{
        {0, kStartRad}, {static_cast<std::int64_t>(1e9 * arrival_s), depth_rad}});
    options.hand = hand;
    contact_s = arrival_s;
  }
  options.initial = state;
  return options;
}

/// From 0.8 s after contact on.
struct Rest {
  std::int64_t moves_counts = 0;
  double vibration_nm = 0;  // the motor's torque above 20 Hz, root of the mean square
};

constexpr double kFeltNm = 1e-3;

double vibration_nm(const std::vector<LoopRow>& rows, std::int64_t rate_hz) {
  const auto block = static_cast<std::size_t>(rate_hz / 20);
  double sum = 0.0;
  for (std::size_t from = 0; from < rows.size(); from += block) {
    double mean_nm = 0.0;
    for (std::size_t i = from; i < from + block; ++i) mean_nm += rows[i].motor_torque_nm;
    mean_nm /= static_cast<double>(block);
    for (std::size_t i = from; i < from + block; ++i) {
      sum += std::pow(rows[i].motor_torque_nm - mean_nm, 2);
    }
  }
  return std::sqrt(sum / static_cast<double>(rows.size()));
}

Rest rest_of(const Trial& trial) {
  double contact_s = 0.0;
  ClosedLoop loop(options_of(trial, contact_s));
  loop.run(static_cast<std::uint64_t>((contact_s + 0.8) * static_cast<double>(trial.rate_hz)), {});
  std::vector<LoopRow> rows(static_cast<std::size_t>(trial.rate_hz / 5));
  loop.run(rows.size(), rows);
  const auto [least, most] = std::ranges::minmax_element(rows, {}, &LoopRow::position_counts);
  return {most->position_counts - least->position_counts, vibration_nm(rows, trial.rate_hz)};
}

void check_at_rest(const Trial& trial) {
  const Rest rest = rest_of(trial);
  CHECK(rest.moves_counts <= (trial.held == Held::weight ? 3 : 2));
  CHECK(rest.vibration_nm < kFeltNm);
}

// tests/python/test_no_buzz.py has more stiffnesses and speeds, on the boards' own loops.
void check_at_rest(bool two_sided, std::int64_t rate_hz) {
  for (const double stiffness : {0.0, 8.0, 200.0, 1e6}) {
    for (const double speed : {0.5, 5.0, 18.0}) {
      for (const Held held : {Held::off, Held::stiff, Held::soft, Held::weight}) {
        // Nothing holds a weight where there is no wall.
        if (held == Held::weight && stiffness == 0.0) continue;
        for (const std::uint32_t delay : {0U, 1U}) {
          CAPTURE(stiffness);
          CAPTURE(speed);
          CAPTURE(static_cast<int>(held));
          CAPTURE(delay);
          // A weight damps nothing at all, which no hand does.
          check_at_rest({.two_sided = two_sided,
                         .stiffness_nm_per_rad = stiffness,
                         .speed_rad_s = speed,
                         .held = held,
                         .delay_ticks = delay,
                         .rate_hz = rate_hz});
        }
      }
    }
  }
}

TEST_CASE("calibrated_law_wall_of_any_stiffness_comes_to_rest_at_10_khz") {
  check_at_rest(false, 10'000);
}
TEST_CASE("calibrated_law_wall_of_any_stiffness_comes_to_rest_at_20_khz") {
  check_at_rest(false, 20'000);
}
TEST_CASE("calibrated_law_spring_of_any_stiffness_comes_to_rest_at_10_khz") {
  check_at_rest(true, 10'000);
}
TEST_CASE("calibrated_law_spring_of_any_stiffness_comes_to_rest_at_20_khz") {
  check_at_rest(true, 20'000);
}

TEST_CASE("calibrated_law_wall_that_knocks_comes_to_rest") {
  for (const double stiffness : {1.0, 20.0, 200.0, 1e6}) {
    for (const double speed : {0.5, 5.0, 18.0}) {
      for (const Held held : {Held::off, Held::stiff, Held::soft, Held::weight}) {
        for (const std::int64_t rate_hz : {10'000, 20'000}) {
          CAPTURE(stiffness);
          CAPTURE(speed);
          CAPTURE(static_cast<int>(held));
          CAPTURE(rate_hz);
          check_at_rest({.stiffness_nm_per_rad = stiffness,
                         .speed_rad_s = speed,
                         .held = held,
                         .delay_ticks = 1,
                         .rate_hz = rate_hz,
                         .knocks = true});
        }
      }
    }
  }
}

// The trials can tell: without the bound the same spring swings for ever, ten times as wide.
TEST_CASE("compensated_law_stiff_spring_with_a_tick_of_delay_buzzes") {
  const Rest rest = rest_of({.law = protocol::Law::compensated,
                             .two_sided = true,
                             .stiffness_nm_per_rad = 1e6,
                             .speed_rad_s = 5.0,
                             .delay_ticks = 1});
  CHECK(rest.moves_counts > 30);
  CHECK(rest.vibration_nm > 20.0 * kFeltNm);
}

/// A slow hand's way into a wall and out again.
std::vector<LoopRow> visit(protocol::Law law, double stiffness) {
  Trial trial{.law = law, .stiffness_nm_per_rad = stiffness};
  double contact_s = 0.0;
  ClosedLoopOptions options = options_of(trial, contact_s);
  options.hand = emulator::PrescribedMotion{emulator::Profile(std::vector<emulator::ProfileKnot>{
      {0, kStartRad}, {1'000'000'000, 0.04}, {1'200'000'000, 0.04}, {2'200'000'000, kStartRad}})};
  options.initial->speed_rad_s = {};
  // Facts of the brake that the law calibrated knows and the other does not.
  options.actuator.brake_inertia_kg_m2 = 0.0F;
  options.actuator.brake_torque_min_nm = options.actuator.brake_drag_nm;
  ClosedLoop loop(options);
  std::vector<LoopRow> rows(static_cast<std::size_t>(22 * trial.rate_hz / 10));
  loop.run(rows.size(), rows);
  // Near the wall's edge the motor cancels less of the drag.
  const auto inside = [](const LoopRow& row) { return row.desired_torque_nm < -20e-3F; };
  const auto begin = std::ranges::find_if(rows, inside);
  const auto end = std::find_if_not(begin, rows.end(), inside);
  REQUIRE(end - begin > trial.rate_hz / 2);
  return {begin, end};
}

TEST_CASE("calibrated_law_clean_wall_is_the_compensated_law_s_to_the_bit") {
  for (const double stiffness : {0.5, 2.0, 5.0, 10.0}) {
    CAPTURE(stiffness);
    const auto bounded = visit(protocol::Law::calibrated, stiffness);
    const auto free = visit(protocol::Law::compensated, stiffness);
    CHECK(std::ranges::equal(bounded, free, {}, &LoopRow::motor_command_nm,
                             &LoopRow::motor_command_nm));
    CHECK(std::ranges::equal(bounded, free, {}, &LoopRow::brake_command_nm,
                             &LoopRow::brake_command_nm));
  }
}

}  // namespace
