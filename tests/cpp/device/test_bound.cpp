// The law calibrated on the device: its bound, its energies, and changes that are no motion of the
// knob. tests/cpp/core/test_stiffness_bound.cpp tests the bound itself.
#include <algorithm>
#include <cmath>

#include "device/played.hpp"

using namespace torsio::protocol;
using torsio::test::at_once;
using torsio::test::play;
using torsio::test::Rig;

namespace {

/// Armed, with a scene of 0.01 N m and no soft start.
void arm(Rig& rig) {
  REQUIRE(rig.set(at_once(Law::calibrated)).ok());
  play(rig, 0.01F);
}

/// Takes a wall at 0 into the first slot; it plays once it is committed.
void send_wall(Rig& rig, float stiffness_nm_per_rad) {
  Wall wall;
  wall.target = {1, 0, 0};
  wall.stiffness_nm_per_rad = stiffness_nm_per_rad;
  REQUIRE(rig.send_status(wall) == Status::ok);
}

void turn(Rig& rig, int ticks) {
  for (int n = 0; n < ticks; ++n) {
    rig.inputs.encoder_count += 1;
    rig.tick();
  }
}

/// Whether less was given than asked, in any report since the last were cleared.
bool was_bounded(const Rig& rig) {
  REQUIRE(rig.telemetry.size() > 3);
  return std::ranges::any_of(
      rig.telemetry, [](const Telemetry& told) { return (told.flags & flag::bounded) != 0; });
}

}  // namespace

TEST_CASE("telemetry of the law calibrated tells what is asked, and that less is given") {
  Rig rig;
  arm(rig);
  send_wall(rig, 1000.0F);
  REQUIRE(rig.send_status(Commit{2, 0, 1}) == Status::ok);
  REQUIRE(rig.send_status(Stream{3, 0, 1}) == Status::ok);
  const auto last = [&] {
    rig.telemetry.clear();
    rig.tick(8);
    REQUIRE_FALSE(rig.telemetry.empty());
    return rig.telemetry.back();
  };
  CHECK((last().flags & flag::bounded) == 0);
  rig.inputs.encoder_count += 1;
  const Telemetry told = last();
  CHECK((told.flags & flag::bounded) != 0);
  const double step_nm = static_cast<double>(rig.get<Identity>().torque_step_nm);
  const double asked_nm = -1000.0 * 2.0 * 3.14159265358979 / 8192.0;
  // A sample holds at the end of its range.
  CHECK(told.sample[0].desired_torque * step_nm ==
        doctest::Approx(std::max(asked_nm, -32767 * step_nm)).scale(0).epsilon(0.01));
  CHECK(std::abs(rig.outputs.motor_command_nm) < 0.05F);
}

TEST_CASE("a count that is held follows again once nothing plays") {
  Rig rig;
  arm(rig);
  const auto moved = [&] {
    const auto before = rig.get<Clock>().position_counts;
    rig.inputs.encoder_count += 1;
    rig.tick();
    return rig.get<Clock>().position_counts - before;
  };
  for (int n = 0; n < 4000; ++n) {
    rig.inputs.encoder_count ^= 1U;
    rig.tick();
  }
  CHECK(moved() == 0);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  rig.tick(500);
  CHECK(moved() == 1);
}

TEST_CASE(
    "a scene that begins while the knob turns is whole at once, with the law calibrated too") {
  Rig rig;
  arm(rig);
  send_wall(rig, 0.5F);
  turn(rig, 100);
  REQUIRE(rig.device->receive(encode(Commit{2, 0, 1})));
  turn(rig, 3);
  REQUIRE(rig.send_status(Stream{3, 0, 1}) == Status::ok);
  rig.telemetry.clear();
  rig.tick(8);
  REQUIRE_FALSE(rig.telemetry.empty());
  CHECK((rig.telemetry.back().flags & flag::bounded) == 0);
}

TEST_CASE("a new configuration forgets what buzzed with the old one") {
  Rig rig;
  arm(rig);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  Spring spring;
  spring.target = {1, 0, 0};
  spring.stiffness_nm_per_rad = 1000.0F;
  spring.torque_limit_nm = 10.0F;
  const auto begin = [&] {
    rig.tick(200);  // the law makes up for the shaft's spring: while a current holds it, and here
    REQUIRE(rig.command(Op::relax) == Status::ok);
    spring.angle_turns_q32 = rig.get<Clock>().position_counts * (std::int64_t{1} << 32) / 8192;
    REQUIRE(rig.send_status(spring) == Status::ok);
    REQUIRE(rig.send_status(Commit{2, 0, 1}) == Status::ok);
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.tick(2);
  };
  // Its push a count beside the spring's middle.
  const auto push_nm = [&] {
    begin();
    rig.inputs.encoder_count -= 1;  // in the last direction: a turn back would be a swing
    rig.tick();
    const double pushes_nm = std::abs(static_cast<double>(rig.outputs.motor_command_nm));
    REQUIRE(rig.command(Op::disarm) == Status::ok);
    return pushes_nm;
  };
  const auto buzz = [&] {
    begin();
    for (int swing = 0; swing < 12; ++swing) {
      for (int n = 0; n < 8; ++n) {
        rig.inputs.encoder_count += swing % 2 == 0 ? 1U : 0xFFFFFFFFU;
        rig.tick();
      }
    }
    REQUIRE(rig.command(Op::disarm) == Status::ok);
  };
  const double whole_nm = push_nm();
  buzz();
  CHECK(push_nm() < 0.7 * whole_nm);
  buzz();
  REQUIRE(rig.set(rig.get<ControlConfig>()).ok());
  CHECK(push_nm() == doctest::Approx(whole_nm).scale(0).epsilon(0.01));
}

TEST_CASE("energies are counted anew with each configuration") {
  Rig rig;
  arm(rig);
  turn(rig, 20);
  REQUIRE(rig.get<Ledger>().motor != 0);
  REQUIRE(rig.get<Ledger>().spring_twice != 0);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  REQUIRE(rig.set(rig.get<ControlConfig>()).ok());
  CHECK(rig.get<Ledger>().motor == 0);
  CHECK(rig.get<Ledger>().spring_twice == 0);
}

TEST_CASE("a torque that plays in time is none of the knob's motion, also beside a soft wall") {
  Rig rig;
  arm(rig);
  send_wall(rig, 0.5F);
  Periodic wave;
  wave.target = {1, 0, 1};
  wave.amplitude_nm = 0.2F;
  wave.frequency_hz = 100.0F;
  REQUIRE(rig.send_status(wave) == Status::ok);
  REQUIRE(rig.send_status(Commit{2, 0, 3}) == Status::ok);
  REQUIRE(rig.send_status(Stream{3, 0, 1}) == Status::ok);
  rig.telemetry.clear();
  turn(rig, 60);
  CHECK_FALSE(was_bounded(rig));
}

TEST_CASE("no drag is cancelled in free air because of a wall before the knob was armed") {
  Rig rig;
  ActuatorConfig actuator = rig.get<ActuatorConfig>();
  actuator.brake_drag_nm = 4e-3F;
  REQUIRE(rig.set(actuator).ok());
  REQUIRE(rig.set(at_once(Law::calibrated)).ok());
  send_wall(rig, 0.5F);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  turn(rig, 200);
  CHECK(rig.outputs.motor_command_nm != 0.0F);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  rig.tick(500);
  rig.inputs.encoder_count -= 400;  // out of it; the shaft is wound up
  rig.tick(500);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(50);
  CHECK(std::abs(rig.outputs.motor_command_nm) < 1e-6F);
}

TEST_CASE("a soft start in a wall is none of the knob's motion, to its last tick") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::calibrated, 0.004F)).ok());
  send_wall(rig, 0.5F);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  rig.inputs.encoder_count += 1500;  // deep in it, 0.6 N m
  rig.tick(300);
  REQUIRE(rig.send_status(Stream{3, 0, 1}) == Status::ok);
  REQUIRE(rig.device->receive(encode(Command{4, 0, Op::arm})));
  rig.telemetry.clear();
  turn(rig, 40);
  REQUIRE(rig.state() == State::armed);
  CHECK_FALSE(was_bounded(rig));
}
