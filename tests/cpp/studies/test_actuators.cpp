#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "actuators/actuator.hpp"
#include "actuators/machine.hpp"
#include "actuators/trial.hpp"

namespace {

using namespace torsio::emulator;
using namespace torsio::studies::actuators;

constexpr std::int64_t kStepNs = 20'000;

MachineParams one_shaft(double inertia, double viscous, double coulomb) {
  MachineParams params;
  params.knob = {inertia, viscous, coulomb};
  params.motor_limit_nm = 1.0;
  params.brake_limit_nm = 1.0;
  return params;
}

MachineState moving(double speed) {
  MachineState state;
  state.speed_rad_s = {speed, speed};
  return state;
}

Machine run(const MachineParams& params, const Hand& hand, const MachineState& start,
            const MachineCommand& command, double seconds) {
  Machine machine(params, hand, kStepNs);
  machine.set_state(start);
  machine.set_command(command);
  for (int i = 0; i < static_cast<int>(std::lround(seconds * 1e9 / kStepNs)); ++i) machine.step();
  return machine;
}

TorqueHand steady(double torque_nm) { return {Profile::constant(torque_nm)}; }

/// Slowly, so that a spring is not made to swing.
TorqueHand grown(double torque_nm) { return {Profile({{0, 0.0}, {400'000'000, torque_nm}})}; }

}  // namespace

TEST_CASE("machine: a shaft with viscous friction slows down exponentially") {
  const auto machine = run(one_shaft(6e-5, 6e-4, 0.0), NoHand{}, moving(10.0), {}, 0.1);
  CHECK(machine.state().speed_rad_s[0] ==
        doctest::Approx(10.0 * std::exp(-1.0)).scale(0).epsilon(1e-6));
}

TEST_CASE("machine: Coulomb friction stops a shaft after J w / f and then holds it") {
  const double stop_rad = 0.5 * 6e-5 * 10.0 * 10.0 / 6e-3;  // J w^2 / (2 f)
  const auto machine = run(one_shaft(6e-5, 0.0, 6e-3), NoHand{}, moving(10.0), {}, 0.2);
  CHECK(machine.state().speed_rad_s[0] == 0.0);
  CHECK(machine.state().angle_rad[0] == doctest::Approx(stop_rad).scale(0).epsilon(1e-6));
}

TEST_CASE("machine: a locked brake makes the knob a spring of the shaft's stiffness") {
  auto params = one_shaft(6e-5, 0.0, 0.0);
  params.has_far_shaft = true;
  params.far_shaft = {4e-5, 0.0, 0.0};
  params.stiffness_nm_per_rad = 2.873;
  params.damping_nm_s_per_rad = 2e-3;
  params.brake = Seat::far_shaft;
  MachineCommand command;
  command.brake_forward_command_nm = command.brake_backward_command_nm = 0.1;
  SUBCASE("up to what it can hold") {
    const auto machine = run(params, grown(0.09), {}, command, 0.6);
    CHECK(machine.state().angle_rad[0] == doctest::Approx(0.09 / 2.873).scale(0).epsilon(3e-4));
    CHECK(machine.state().angle_rad[1] == 0.0);
    CHECK(machine.rendered_torque_nm() == doctest::Approx(-0.09).scale(0).epsilon(3e-4));
  }
  SUBCASE("and slips beyond it") {
    const auto machine = run(params, grown(0.11), {}, command, 0.6);
    CHECK(machine.state().speed_rad_s[1] > 1.0);
    CHECK(machine.state().brake_torque_nm == doctest::Approx(-0.1));
  }
}

TEST_CASE("machine: a one-way brake holds one way and lets go the other") {
  auto params = one_shaft(1e-4, 0.0, 0.0);
  params.brake = Seat::knob;
  MachineCommand command;
  command.brake_forward_command_nm = 0.1;
  CHECK(run(params, steady(0.05), {}, command, 0.1).state().angle_rad[0] == 0.0);
  const auto back = run(params, steady(-0.05), {}, command, 0.1);
  CHECK(back.state().speed_rad_s[0] == doctest::Approx(-0.05 / 1e-4 * 0.1).scale(0).epsilon(1e-9));
}

TEST_CASE("machine: a slipping clutch drives the knob with its torque until both turn alike") {
  auto params = one_shaft(1e-4, 0.0, 0.0);
  params.brake = Seat::knob;
  params.source_acceleration_rad_s2 = 1e9;
  MachineCommand command;
  command.brake_forward_command_nm = command.brake_backward_command_nm = 0.01;
  command.source_speed_rad_s = 20.0;
  CHECK(run(params, NoHand{}, {}, command, 0.1).state().speed_rad_s[0] ==
        doctest::Approx(10.0).scale(0).epsilon(1e-6));
  CHECK(run(params, NoHand{}, {}, command, 0.3).state().speed_rad_s[0] == 20.0);
}

TEST_CASE("machine: motor and brake follow their commands with their time constants") {
  auto params = one_shaft(1e-4, 0.0, 0.0);
  params.motor = params.brake = Seat::knob;
  params.motor_time_constant_s = 0.02;
  params.brake_time_constant_s = 0.06;
  MachineCommand command;
  command.motor_command_nm = 0.05;
  command.brake_forward_command_nm = 0.1;
  const auto machine = run(params, NoHand{}, {}, command, 0.03);
  CHECK(machine.state().motor_torque_nm == doctest::Approx(0.05 * -std::expm1(-1.5)));
  CHECK(machine.state().brake_forward_capacity_nm == doctest::Approx(0.1 * -std::expm1(-0.5)));
}

TEST_CASE("machine: bad parameters are refused with their name") {
  CHECK_THROWS_AS(Machine(one_shaft(-1e-5, 0.0, 0.0), NoHand{}, kStepNs), std::invalid_argument);
  CHECK_THROWS_AS(Machine(one_shaft(1e-5, 0.0, NAN), NoHand{}, kStepNs), std::invalid_argument);
  CHECK_THROWS_AS(Machine(one_shaft(1e-5, 0.0, 0.0), NoHand{}, 0), std::invalid_argument);
  const PrescribedMotion path{Profile::constant(0.0)};
  CHECK_THROWS_AS(Machine(one_shaft(1e-5, 0.0, 0.0), path, kStepNs), std::invalid_argument);
}

TEST_CASE("actuator: every kind has a name of its own and is found by it") {
  for (int i = 0; i < kKinds; ++i) {
    const auto kind = static_cast<Kind>(i);
    CHECK(kind_from_name(name_of(kind)) == kind);
  }
  CHECK_THROWS_WITH_AS(static_cast<void>(kind_from_name("magic")),
                       doctest::Contains("soft_sensor_paper"), std::invalid_argument);
}

TEST_CASE("actuator: bodies that turn together carry the sum of their inertia and friction") {
  const Parts parts;
  const auto parallel = machine_params(Kind::parallel, parts);
  CHECK(parallel.knob.inertia_kg_m2 == doctest::Approx(2e-5 + 4e-5 + 4e-5));
  CHECK(parallel.knob.coulomb_nm == doctest::Approx(6e-3));
  CHECK_FALSE(parallel.has_far_shaft);
}

TEST_CASE("trial: periods that steps do not divide are refused") {
  TrialParams params;
  params.period_ns = 1'000'000;
  params.step_ns = 30'000;
  CHECK_THROWS_AS(static_cast<void>(run_trial(params)), std::invalid_argument);
}
