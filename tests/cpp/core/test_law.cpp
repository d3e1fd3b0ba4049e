// Sensor, brake model, partition and limits against hand calculations and closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <random>

#include "core/brake_model.hpp"
#include "core/limits.hpp"
#include "core/partition.hpp"
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
  // The drag is part of what the floor stands for: a released brake holds its drag, not both.
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

TEST_CASE("a relaxed spring counts as helping: the brake takes hold at first contact") {
  for (const core::Law law : {core::Law::paper, core::Law::compensated}) {
    CHECK(share(law, -0.060F, 0.0F).motor_command_nm == Approx(-0.060));
    CHECK(share(law, -0.060F, 0.0F).brake_command_nm == Approx(0.030));
  }
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
  for (const core::Law law :
       {core::Law::paper, core::Law::compensated, core::Law::parallel, core::Law::motor_only}) {
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
  core::LimitState state;
  const core::LimitParams params{0.01F};
  CHECK(core::limit_motor(state, params, 1.0F) == Approx(0.01));
  CHECK(core::limit_motor(state, params, 1.0F) == Approx(0.02));
  CHECK(core::limit_motor(state, params, -1.0F) == Approx(0.01));
  for (int i = 0; i < 20; ++i) (void)core::limit_motor(state, params, 0.085F);
  CHECK(state.motor_command_nm == 0.085F);
  core::LimitState free;
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
