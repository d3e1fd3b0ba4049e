// Sensor, brake model, partition and limits against hand calculations and closed forms.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <random>

#include "core/brake_model.hpp"
#include "core/partition.hpp"
#include "core/shaft.hpp"
#include "core/slew_limit.hpp"
#include "core/soft_sensor.hpp"

namespace core = torsio::core;
using doctest::Approx;

TEST_CASE("the sensed torque winds up at the shaft's stiffness, against the motion") {
  core::SoftSensorState state;
  for (int i = 1; i <= 10; ++i) {
    CHECK(core::sense_spring(state, 2.873F, 0.001F, 1.0F) == Approx(-2.873e-3 * i));
  }
}

TEST_CASE("the sensed torque slips at the brake's capacity and unwinds at once on reversal") {
  core::SoftSensorState state;
  for (int i = 0; i < 100; ++i) (void)core::sense_spring(state, 2.873F, 0.001F, 0.02F);
  CHECK(state.spring_torque_nm == -0.02F);
  CHECK(core::sense_spring(state, 2.873F, -0.001F, 0.02F) == Approx(-0.02 + 2.873e-3));
  // A brake that lets go takes the torque with it.
  CHECK(core::sense_spring(state, 2.873F, 0.0F, 0.005F) == -0.005F);
}

TEST_CASE("the brake model follows the closed form of a first order lag for any period") {
  for (const double period_s : {1e-4, 1e-3, 0.06, 1.0, 30.0}) {
    CAPTURE(period_s);
    const double tau_s = 0.06;
    const core::BrakeParams params = core::make_brake_params(
        static_cast<float>(tau_s), static_cast<float>(period_s), 0.0F, 0.0F);
    core::BrakeState state;
    for (int i = 1; i <= 50; ++i) {
      const double exact = 0.1 * (1.0 - std::exp(-i * period_s / tau_s));
      CHECK(core::model_brake(state, params, 0.1F) == Approx(exact).scale(0).epsilon(2e-5));
    }
  }
}

TEST_CASE("a brake without a time constant follows at once") {
  const core::BrakeParams params = core::make_brake_params(0.0F, 1e-3F, 0.0F, 0.0F);
  core::BrakeState state;
  CHECK(core::model_brake(state, params, 0.07F) == 0.07F);
  CHECK(core::model_brake(state, params, 0.0F) == 0.0F);
}

TEST_CASE("floor and drag enter the capacity but not the lag") {
  const core::BrakeParams params = core::make_brake_params(0.0F, 1e-3F, 3.3e-3F, 2e-3F);
  core::BrakeState state;
  // The floor includes the drag: a released brake holds its drag, not both.
  CHECK(core::model_brake(state, params, 0.0F) == Approx(3.3e-3));
  CHECK(state.capacity_nm == 0.0F);
  CHECK(core::model_brake(state, params, 10e-3F) == Approx(12e-3));
  CHECK(state.capacity_nm == 10e-3F);
}

TEST_CASE("a released brake's model ends at exactly zero") {
  const core::BrakeParams params = core::make_brake_params(1e-3F, 1e-3F, 0.0F, 0.0F);
  core::BrakeState state{0.1F};
  for (int i = 0; i < 200; ++i) (void)core::model_brake(state, params, 0.0F);
  CHECK(state.capacity_nm == 0.0F);
}

TEST_CASE("while the brake holds, what turns with it changes nothing") {
  const core::BrakeSideParams side = core::make_brake_side_params(4e-5F, 2.873F, 50e-6F, 6e-3F);
  core::SoftSensorState plain;
  core::SoftSensorState driven;
  for (int i = 0; i < 200; ++i) {
    const float delta_rad = i < 120 ? 2e-4F : -3e-4F;
    const float expected_nm = core::sense_spring(plain, 2.873F, delta_rad, 0.1F);
    CHECK(core::sense_driven_spring(driven, side, 2.873F, delta_rad, 0.1F) == expected_nm);
  }
}

// A mass on a spring: the rest of a twist is a cosine of time. The method damps it by half a
// period's angle, 3e-4 here.
TEST_CASE("behind a brake that holds nothing the spring swings at its own frequency") {
  constexpr double kPeriodS = 2e-6;
  const double rate = std::sqrt(2.873 / 4e-5);
  const core::BrakeSideParams side = core::make_brake_side_params(4e-5F, 2.873F, 2e-6F, 6e-3F);
  core::SoftSensorState state;
  (void)core::sense_driven_spring(state, side, 2.873F, -0.01F, 1.0F);
  REQUIRE(state.spring_torque_nm == Approx(0.02873));
  for (int i = 1; i <= 20'000; ++i) {
    const float spring_nm = core::sense_driven_spring(state, side, 2.873F, 0.0F, 0.0F);
    CHECK(spring_nm ==
          Approx(0.02873 * std::cos(rate * kPeriodS * i)).scale(0.02873).epsilon(0.01));
  }
}

TEST_CASE(
    "a brake's side that is driven ever faster takes its inertia's torque beyond the brake's") {
  const core::BrakeSideParams side = core::make_brake_side_params(4e-5F, 2.873F, 1e-3F, 6e-3F);
  core::SoftSensorState state;
  float spring_nm = 0;
  // 100 rad/s^2, and at 1 kHz the method's own damping ends the swing.
  for (int i = 1; i <= 2000; ++i) {
    spring_nm =
        core::sense_driven_spring(state, side, 2.873F, 1e-4F * static_cast<float>(i), 0.01F);
  }
  CHECK(spring_nm == Approx(-(0.01 + 100.0 * 4e-5)).epsilon(0.01));
}

TEST_CASE("without inertia behind the brake, or without a spring, the bound is the brake's") {
  for (const auto& side : {core::make_brake_side_params(0.0F, 2.873F, 1e-3F, 6e-3F),
                           core::make_brake_side_params(4e-5F, 0.0F, 1e-3F, 6e-3F)}) {
    core::SoftSensorState plain;
    core::SoftSensorState driven;
    std::mt19937 random(7);
    std::uniform_real_distribution<float> way(-5e-3F, 5e-3F);
    std::uniform_real_distribution<float> holds(0.0F, 0.1F);
    for (int i = 0; i < 10'000; ++i) {
      const float delta_rad = way(random);
      const float capacity_nm = holds(random);
      const float expected_nm = core::sense_spring(plain, 2.873F, delta_rad, capacity_nm);
      CHECK(core::sense_driven_spring(driven, side, 2.873F, delta_rad, capacity_nm) ==
            Approx(expected_nm).scale(0.1).epsilon(1e-6));
    }
  }
}

namespace {

constexpr std::array<core::ShaftKnee, core::kMostKnees> kKnees{
    {{0.015F, 6.0F}, {0.02F, 1.5F}, {0.03F, 12.0F}, {0.035F, 20.0F}}};
constexpr double kMostRad = 0.05;

core::ShaftParams bent_shaft(float inertia_kg_m2 = 0.0F, float period_s = 1e-3F) {
  return core::make_shaft_params(2.873F, kKnees, inertia_kg_m2, period_s, 6e-3F);
}

/// Its torque over the twist, corner by corner.
double bent_torque_nm(double twist_rad) {
  constexpr double kCorners[][2] = {{0.0, 0.0},       {0.015, 0.043095}, {0.02, 0.073095},
                                    {0.03, 0.088095}, {0.035, 0.148095}, {1.0, 19.448095}};
  const double twist = std::abs(twist_rad);
  for (int i = 1;; ++i) {
    const auto& [from_rad, from_nm] = kCorners[i - 1];
    const auto& [to_rad, to_nm] = kCorners[i];
    if (twist > to_rad) continue;
    const double torque_nm = from_nm + (to_nm - from_nm) * (twist - from_rad) / (to_rad - from_rad);
    return std::copysign(torque_nm, twist_rad);
  }
}

/// By halving; the torque grows with the twist.
double bent_twist_rad(double torque_nm) {
  double low = -1.0;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (bent_torque_nm(middle) < torque_nm ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

TEST_CASE("a bent shaft is exact at its knees, in small steps and in one") {
  const core::ShaftParams shaft = bent_shaft();
  for (const core::ShaftKnee& knee : kKnees) {
    for (const int steps : {1, 7, 1000}) {
      for (const float way : {1.0F, -1.0F}) {
        CAPTURE(knee.twist_rad);
        CAPTURE(steps);
        core::SoftSensorState state;
        const float step_rad = way * knee.twist_rad / static_cast<float>(steps);
        for (int i = 0; i < steps; ++i) {
          (void)core::sense_bent_shaft<false>(state, shaft, step_rad, 1.0F);
        }
        const double expected_nm = -bent_torque_nm(static_cast<double>(way * knee.twist_rad));
        CHECK(static_cast<double>(state.spring_torque_nm) ==
              Approx(expected_nm).scale(0).epsilon(steps == 1 ? 2e-7 : 1e-4));
        // And back, past the other side.
        (void)core::sense_bent_shaft<false>(state, shaft, -3.0F * way * knee.twist_rad, 10.0F);
        CHECK(static_cast<double>(state.spring_torque_nm) ==
              Approx(-bent_torque_nm(-2.0 * static_cast<double>(way * knee.twist_rad)))
                  .scale(0)
                  .epsilon(1e-4));
      }
    }
  }
}

TEST_CASE("a bent shaft slips at what the brake holds and is wound on its own curve") {
  const core::ShaftParams shaft = bent_shaft();
  core::SoftSensorState state;
  double expected_nm = 0.0;
  std::mt19937 random(11);
  std::uniform_real_distribution<float> way(-8e-3F, 8e-3F);
  std::uniform_real_distribution<float> holds(0.0F, 0.2F);
  float capacity_nm = 0.1F;
  for (int i = 0; i < 20'000; ++i) {
    const float delta_rad = way(random);
    if (i % 10 == 0) capacity_nm = holds(random);
    const auto most_nm = static_cast<double>(capacity_nm);
    const double twist_rad = bent_twist_rad(expected_nm) - static_cast<double>(delta_rad);
    expected_nm = std::clamp(bent_torque_nm(twist_rad), -most_nm, most_nm);
    (void)core::sense_bent_shaft<false>(state, shaft, delta_rad, capacity_nm);
    CHECK(static_cast<double>(state.spring_torque_nm) ==
          Approx(expected_nm).scale(0.1).epsilon(1e-5));
  }
}

TEST_CASE("a shaft with knees beyond reach, or none, is the straight one to the bit") {
  std::array<core::ShaftKnee, core::kMostKnees> far{};
  far[0] = {50.0F, 9.0F};
  for (const auto& knees : {far, std::array<core::ShaftKnee, core::kMostKnees>{}}) {
    const core::ShaftParams shaft = core::make_shaft_params(2.873F, knees, 4e-5F, 1e-3F, 6e-3F);
    core::SoftSensorState bent;
    core::SoftSensorState straight;
    straight.piece = shaft.middle();
    std::mt19937 random(12);
    std::uniform_real_distribution<float> way(-5e-3F, 5e-3F);
    std::uniform_real_distribution<float> holds(0.0F, 0.1F);
    for (int i = 0; i < 10'000; ++i) {
      const float delta_rad = way(random);
      const float capacity_nm = holds(random);
      const float expected_nm =
          core::sense_piece<true>(straight, shaft.middle(), delta_rad, capacity_nm);
      CHECK(core::sense_bent_shaft<true>(bent, shaft, delta_rad, capacity_nm) == expected_nm);
    }
  }
}

// The same mass on the same curve, followed by steps of a tenth of the period.
TEST_CASE("behind a brake that slips the brake's side swings on the bent curve") {
  constexpr double kStepS = 2e-7;
  const core::ShaftParams shaft = bent_shaft(4e-5F, 2e-6F);
  core::SoftSensorState state;
  (void)core::sense_bent_shaft<true>(state, shaft, -static_cast<float>(kMostRad), 10.0F);
  double twist_rad = kMostRad;
  double slide_rad_s = 0.0;
  double most_nm = 0.0;
  for (int i = 1; i <= 8000; ++i) {
    for (int k = 0; k < 10; ++k) {
      slide_rad_s += kStepS * bent_torque_nm(twist_rad) / 4e-5;
      twist_rad -= kStepS * slide_rad_s;
    }
    const float spring_nm = core::sense_bent_shaft<true>(state, shaft, 0.0F, 0.0F);
    most_nm = std::max(most_nm, -static_cast<double>(spring_nm));
    CHECK(static_cast<double>(spring_nm) ==
          Approx(bent_torque_nm(twist_rad)).scale(0.45).epsilon(0.02));
  }
  CHECK(most_nm > 0.4);  // it came to the other side
}

// The speed at the end of a tick fits the torque then: friction holds B at rest, or the torque left
// turns its mass. Solved by halving.
TEST_CASE("a tick across knees ends where curve, friction and mass agree") {
  constexpr double kMass = 4e-5 / (1e-3 * 1e-3);
  const core::ShaftParams shaft = bent_shaft(4e-5F, 1e-3F);
  core::SoftSensorState state;
  double wind_rad = 0.0;  // twist behind the spring's torque
  double slid_rad = 0.0;  // in the last tick
  std::mt19937 random(13);
  std::uniform_real_distribution<float> way(-8e-3F, 8e-3F);
  std::uniform_real_distribution<float> holds(0.0F, 0.05F);
  for (int i = 0; i < 20'000; ++i) {
    const float delta_rad = way(random);
    const float capacity_nm = holds(random);
    const auto most_nm = static_cast<double>(capacity_nm);
    wind_rad -= static_cast<double>(delta_rad);
    const double drive_nm = bent_torque_nm(wind_rad) + kMass * slid_rad;
    double low = -1.0;
    double high = 1.0;
    for (int k = 0; k < 60 && std::abs(drive_nm) > most_nm; ++k) {
      const double slides = 0.5 * (low + high);
      const double left_nm = bent_torque_nm(wind_rad - slides) - std::copysign(most_nm, drive_nm) -
                             kMass * (slides - slid_rad);
      (left_nm > 0.0 ? low : high) = slides;
    }
    slid_rad = std::abs(drive_nm) > most_nm ? 0.5 * (low + high) : 0.0;
    wind_rad -= slid_rad;
    (void)core::sense_bent_shaft<true>(state, shaft, delta_rad, capacity_nm);
    REQUIRE(static_cast<double>(state.spring_torque_nm) ==
            Approx(bent_torque_nm(wind_rad)).scale(0.1).epsilon(1e-3));
  }
}

TEST_CASE("what a bent shaft has stored is the work that wound it") {
  const core::ShaftParams shaft = bent_shaft();
  for (const double twist_rad : {0.0, 0.01, 0.015, 0.018, 0.025, 0.033, 0.05}) {
    double work_j = 0.0;
    for (int i = 0; i < 10'000; ++i) {
      work_j += bent_torque_nm(twist_rad * (i + 0.5) / 10'000) * twist_rad / 10'000;
    }
    const auto torque_nm = static_cast<float>(bent_torque_nm(twist_rad));
    CHECK(core::stored_energy_j(shaft, torque_nm) == Approx(work_j).epsilon(1e-4));
    CHECK(core::stored_energy_j(shaft, -torque_nm) == Approx(work_j).epsilon(1e-4));
  }
  const core::ShaftParams none = core::make_shaft_params(0.0F, kKnees, 4e-5F, 1e-3F, 6e-3F);
  CHECK(core::stored_energy_j(none, 0.01F) == 0.0F);
}

TEST_CASE(
    "a brake with neither hysteresis nor a lag of its own on release is the plain one, to the "
    "bit") {
  const core::BrakeParams params = core::make_brake_params(0.06F, 1e-3F, 3.3e-3F, 2e-3F);
  core::BrakeState plain;
  core::BrakeState real;
  std::mt19937 random(8);
  std::uniform_real_distribution<float> command(0.0F, 0.1F);
  float held_nm = 0;
  for (int i = 0; i < 10'000; ++i) {
    if (i % 50 == 0) held_nm = i % 150 == 0 ? 0.0F : command(random);
    const float expected_nm = core::model_brake(plain, params, held_nm);
    CHECK(core::model_real_brake(real, params, held_nm) == expected_nm);
    CHECK(real.capacity_nm == plain.capacity_nm);
  }
}

TEST_CASE("a brake rises and lets go with lags of their own") {
  core::BrakeParams params = core::make_brake_params(0.06F, 1e-3F, 0.0F, 0.0F);
  params.release_decay = core::decay_of(0.02F, 1e-3F);
  core::BrakeState state;
  for (int i = 1; i <= 60; ++i) (void)core::model_real_brake(state, params, 0.1F);
  const double risen_nm = 0.1 * (1.0 - std::exp(-1.0));
  CHECK(state.capacity_nm == Approx(risen_nm).epsilon(1e-4));
  for (int i = 1; i <= 40; ++i) (void)core::model_real_brake(state, params, 0.0F);
  CHECK(state.capacity_nm == Approx(risen_nm * std::exp(-2.0)).epsilon(1e-4));
}

// By hand: up, the torque trails the command by half the loop's width; down, it leads by as much.
TEST_CASE("hysteresis is a loop of torque over command, and leaves half its width") {
  core::BrakeParams params = core::make_brake_params(0.0F, 1e-3F, 0.0F, 2e-3F);
  params.play_nm = 0.01F;
  core::BrakeState state;
  const struct {
    float command_nm;
    double held_nm;
  } way[] = {{0.005F, 0.0}, {0.03F, 0.02},   {0.06F, 0.05}, {0.05F, 0.05}, {0.03F, 0.04},
             {0.04F, 0.04}, {0.055F, 0.045}, {0.0F, 0.01},  {0.0F, 0.01}};
  for (const auto& step : way) {
    CAPTURE(step.command_nm);
    CHECK(core::model_real_brake(state, params, step.command_nm) ==
          Approx(step.held_nm + 2e-3).scale(0).epsilon(1e-5));
    CHECK(state.capacity_nm == Approx(step.held_nm).scale(0.05).epsilon(1e-6));
  }
}

TEST_CASE("what helps along in free air grows with the speed, and stays below the friction") {
  const auto params = [](float wanted, float coulomb, float drag) {
    return core::make_assist_params(wanted, coulomb, drag, 0.1F, 1e-3F, 0.0F, 0.0F);
  };
  const core::AssistParams assist = params(4e-3F, 6e-3F, 2e-3F);
  CHECK(core::assist_torque(assist, 0.0F) == 0.0F);
  CHECK(core::assist_torque(assist, 0.05F) == Approx(2e-3));
  CHECK(core::assist_torque(assist, -0.05F) == Approx(-2e-3));
  CHECK(core::assist_torque(assist, 50.0F) == Approx(4e-3));
  CHECK(params(1.0F, 6.5e-3F, 1.5e-3F).most_nm == Approx(6e-3));
  CHECK(params(1.0F, 2e-3F, 10e-3F).most_nm == Approx(2e-3));
}

TEST_CASE(
    "the motor takes the drag off with the way: what the scene asks for and half the friction") {
  // 1.2 N m/rad, or a quarter of the friction in a count
  const core::AssistParams fine =
      core::make_assist_params(0.0F, 6e-3F, 2e-3F, 0.1F, 0.25e-3F, 0.0F, 0.0F);
  CHECK(fine.drag_nm_per_rad == Approx(1.2));
  const core::AssistParams coarse =
      core::make_assist_params(0.0F, 6e-3F, 4e-3F, 0.1F, 3e-3F, 5e-3F, 1e-3F);
  CHECK(coarse.drag_nm_per_rad == Approx(0.5));

  CHECK(core::follow_drag(0.0F, coarse, 50e-3F, 0.0F) == 0.0F);
  CHECK(core::follow_drag(0.0F, coarse, -50e-3F, 6e-3F) == Approx(3e-3));
  CHECK(core::follow_drag(3e-3F, coarse, 50e-3F, -3e-3F) == Approx(4.5e-3));
  CHECK(core::follow_drag(3e-3F, coarse, 4e-3F, 1.0F) == Approx(7e-3));
  // Three fifths of drag, hysteresis and friction, and what the inertia adds.
  CHECK(core::follow_drag(3e-3F, coarse, 50e-3F, 1.0F) == Approx(10e-3));
  CHECK(core::end_drag(4e-3F, coarse, 3e-3F) == Approx(2.5e-3));
  CHECK(core::end_drag(1e-3F, coarse, -3e-3F) == 0.0F);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(core::follow_drag(1e-3F, coarse, nan, 6e-3F) == Approx(4e-3));
  CHECK(core::follow_drag(1e-3F, coarse, std::numeric_limits<float>::infinity(), 6e-3F) ==
        Approx(4e-3));
}

namespace {

core::Shares share(core::Law law, float desired, float spring, float beta = 0.5F) {
  return core::partition({law, beta, 0.085F, 0.110F}, desired, spring);
}

}  // namespace

TEST_CASE("paper's law: the motor fills up what the spring lacks while the spring helps") {
  const core::Shares into = share(core::Law::paper, -0.060F, -0.020F);
  CHECK(into.motor_command_nm == Approx(-0.040));
  CHECK(into.brake_command_nm == Approx(0.030));
  const core::Shares other_side = share(core::Law::paper, 0.060F, 0.020F);
  CHECK(other_side.motor_command_nm == Approx(0.040));
  CHECK(other_side.brake_command_nm == Approx(0.030));
}

TEST_CASE("paper's law: the motor works against a spring that gives too much") {
  CHECK(share(core::Law::paper, -0.010F, -0.030F).motor_command_nm == Approx(0.020));
}

TEST_CASE("paper's law: the brake lets go and the motor gives all when the spring opposes") {
  const core::Shares out = share(core::Law::paper, -0.060F, 0.001F);
  CHECK(out.motor_command_nm == Approx(-0.060));
  CHECK(out.brake_command_nm == 0.0F);
}

TEST_CASE("compensated law: the motor cancels the spring on both sides") {
  CHECK(share(core::Law::compensated, -0.060F, 0.004F).motor_command_nm == Approx(-0.064));
  CHECK(share(core::Law::compensated, -0.060F, 0.004F).brake_command_nm == 0.0F);
  CHECK(share(core::Law::compensated, -0.060F, -0.020F).motor_command_nm == Approx(-0.040));
}

TEST_CASE("parallel law ignores the sensor; motor_only ignores the brake") {
  for (const float spring : {-0.02F, 0.0F, 0.02F}) {
    CHECK(share(core::Law::parallel, -0.060F, spring, 0.25F).motor_command_nm == Approx(-0.045));
    CHECK(share(core::Law::parallel, -0.060F, spring, 0.25F).brake_command_nm == Approx(0.015));
    CHECK(share(core::Law::motor_only, -0.060F, spring).motor_command_nm == Approx(-0.060));
    CHECK(share(core::Law::motor_only, -0.060F, spring).brake_command_nm == 0.0F);
  }
}

TEST_CASE("no law moves the knob in free space") {
  for (const core::Law law : {core::Law::paper, core::Law::compensated, core::Law::parallel,
                              core::Law::motor_only, core::Law::calibrated}) {
    const core::Shares free = share(law, 0.0F, -0.0033F);
    CHECK(free.motor_command_nm == 0.0F);
    CHECK(free.brake_command_nm == 0.0F);
  }
}

TEST_CASE("shares stay within the actuators, saturation is told, for any torque") {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> torque(-1.0F, 1.0F);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  for (int i = 0; i < 100'000; ++i) {
    const auto law = static_cast<core::Law>(random() % 4);
    const core::Shares s = share(law, torque(random), 0.1F * torque(random), unit(random));
    CHECK(std::abs(s.motor_command_nm) <= 0.085F);
    CHECK(s.brake_command_nm >= 0.0F);
    CHECK(s.brake_command_nm <= 0.110F);
    if (s.motor_saturated) CHECK(std::abs(s.motor_command_nm) == 0.085F);
    if (s.brake_saturated) CHECK(s.brake_command_nm == 0.110F);
  }
}

TEST_CASE("limit_motor holds the rate, and holds nothing without one") {
  core::SlewState state;
  const core::SlewParams params{0.01F};
  CHECK(core::limit_motor(state, params, 1.0F) == Approx(0.01));
  CHECK(core::limit_motor(state, params, 1.0F) == Approx(0.02));
  CHECK(core::limit_motor(state, params, -1.0F) == Approx(0.01));
  for (int i = 0; i < 20; ++i) (void)core::limit_motor(state, params, 0.085F);
  CHECK(state.motor_command_nm == 0.085F);
  core::SlewState free;
  CHECK(core::limit_motor(free, {}, -0.085F) == -0.085F);
}

TEST_CASE("saturation is told when more is wanted than there is, and not before") {
  const core::Shares motor = share(core::Law::motor_only, 0.2F, 0.0F, 0.5F);
  CHECK(motor.motor_saturated);
  const core::Shares brake = share(core::Law::paper, 0.25F, 0.0F, 1.0F);
  CHECK(brake.brake_saturated);
  const core::Shares neither = share(core::Law::paper, 0.05F, 0.0F, 0.5F);
  CHECK_FALSE(neither.motor_saturated);
  CHECK_FALSE(neither.brake_saturated);
}
