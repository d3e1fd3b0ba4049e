#include <doctest/doctest.h>

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

Machine run(const MachineParams& params, const Hand& hand, const MachineCommand& command,
            double seconds) {
  Machine machine(params, hand, kStepNs);
  machine.set_command(command);
  for (int i = 0; i < static_cast<int>(std::lround(seconds * 1e9 / kStepNs)); ++i) machine.step();
  return machine;
}

TorqueHand steady(double torque_nm) { return {Profile::constant(torque_nm)}; }

}  // namespace

TEST_CASE("machine: a one-way brake holds one way and lets go the other") {
  auto params = one_shaft(1e-4, 0.0, 0.0);
  params.brake = Seat::knob;
  MachineCommand command;
  command.brake_forward_command_nm = 0.1;
  CHECK(run(params, steady(0.05), command, 0.1).state().angle_rad[0] == 0.0);
  const auto back = run(params, steady(-0.05), command, 0.1);
  CHECK(back.state().speed_rad_s[0] == doctest::Approx(-0.05 / 1e-4 * 0.1).scale(0).epsilon(1e-9));
}

TEST_CASE("machine: a slipping clutch drives the knob with its torque until both turn alike") {
  auto params = one_shaft(1e-4, 0.0, 0.0);
  params.brake = Seat::knob;
  params.source_acceleration_rad_s2 = 1e9;
  MachineCommand command;
  command.brake_forward_command_nm = command.brake_backward_command_nm = 0.01;
  command.source_speed_rad_s = 20.0;
  CHECK(run(params, NoHand{}, command, 0.1).state().speed_rad_s[0] ==
        doctest::Approx(10.0).scale(0).epsilon(1e-6));
  CHECK(run(params, NoHand{}, command, 0.3).state().speed_rad_s[0] == 20.0);
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

TEST_CASE("trial: periods that steps do not divide are refused") {
  TrialParams params;
  params.period_ns = 1'000'000;
  params.step_ns = 30'000;
  CHECK_THROWS_AS(static_cast<void>(run_trial(params)), std::invalid_argument);
}
