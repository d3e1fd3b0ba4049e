// Begin and end of a bounded experiment. Nothing is left of it afterwards.
#include "device/game/game_rig.hpp"
#include "device/played.hpp"

using namespace torsio::protocol;
using torsio::test::at_once;
using torsio::test::count;
using torsio::test::GameRig;
using torsio::test::play;
using torsio::test::Rig;

namespace {

Excitation steady(float motor_nm, float duration_s = 0.05F) {
  Excitation excitation;
  excitation.duration_s = duration_s;
  excitation.travel_rad = 0.1F;
  excitation.speed_limit_rad_s = 50.0F;
  excitation.torque_limit_nm = 0.05F;
  excitation.motor_command_nm = motor_nm;
  return excitation;
}

/// Armed, with a scene of 0.01 N m and no soft start.
void arm_with(Rig& rig, Law law = Law::motor_only, float motor_slew_nm_per_s = 0.0F) {
  ControlConfig control = at_once(law);
  control.motor_slew_nm_per_s = motor_slew_nm_per_s;
  REQUIRE(rig.set(control).ok());
  play(rig, 0.01F);
}

}  // namespace

TEST_CASE("an experiment is refused to whoever has not armed, and while the torque fades") {
  GameRig rig;
  CHECK(rig.send_status(steady(0.02F)) == Status::not_armed);
  rig.play_constant(8192);
  rig.tick(5);
  REQUIRE(rig.state() == State::armed);
  CHECK(rig.send_status(steady(0.02F)) == Status::not_owner);
  REQUIRE(rig.command(Op::disarm) == Status::ok);

  ControlConfig control;
  control.passive_ramp_s = 0.1F;
  REQUIRE(rig.set(control).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(3);
  rig.device->set_connected(false);
  rig.tick(2);
  rig.device->set_connected(true);
  CHECK(rig.send_status(steady(0.02F)) == Status::not_armed);
  rig.tick(2);
  CHECK(std::abs(rig.outputs.motor_command_nm) < 0.02F);
}

TEST_CASE("an experiment takes the place of the scene, ends by itself and disarms") {
  Rig rig;
  arm_with(rig);
  CHECK(rig.outputs.motor_command_nm == doctest::Approx(0.01));
  REQUIRE(rig.send_status(steady(-0.03F)) == Status::ok);
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == doctest::Approx(-0.03));
  rig.tick(70);
  CHECK(rig.state() == State::disarmed);
  CHECK_FALSE(rig.outputs.enabled);
  CHECK(count(rig, EventKind::excitation_over) == 1);
  CHECK(count(rig, EventKind::excitation_stopped) == 0);
  // The next arming plays the scene.
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(3);
  CHECK(rig.state() == State::armed);
  CHECK(rig.outputs.motor_command_nm == doctest::Approx(0.01));
}

TEST_CASE(
    "nothing is left in the tick in which an experiment ends, however slow the motor's slew") {
  Rig rig;
  arm_with(rig, Law::motor_only, 1.0F);
  REQUIRE(rig.send_status(steady(0.03F)) == Status::ok);
  float last_nm = 0.0F;
  int ticks = 0;
  for (; ticks < 100 && rig.outputs.enabled; ++ticks) {
    last_nm = rig.outputs.motor_command_nm;
    rig.tick();
  }
  // The slew would take 25 ms for it.
  CHECK(last_nm > 0.025F);
  for (int after = 0; after < 30; ++after) {
    CHECK_FALSE(rig.outputs.enabled);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
    rig.tick();
  }
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("an experiment goes past the law, and gives each part what was asked of it") {
  Rig rig;
  arm_with(rig, Law::compensated);
  Excitation excitation = steady(-0.03F);
  excitation.brake_command_nm = 0.05F;
  REQUIRE(rig.send_status(excitation) == Status::ok);
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == -0.03F);
  CHECK(rig.outputs.brake_command_nm == 0.05F);
}

TEST_CASE("an experiment that leaves its bounds is stopped, and says so") {
  Rig rig;
  arm_with(rig);
  REQUIRE(rig.send_status(steady(0.03F)) == Status::ok);
  rig.inputs.encoder_count += 150;  // 0.115 rad
  rig.tick();
  CHECK(rig.outputs.motor_command_nm == 0.0F);
  rig.tick(2);
  CHECK(rig.state() == State::disarmed);
  CHECK(count(rig, EventKind::excitation_stopped) == 1);
  CHECK(count(rig, EventKind::excitation_over) == 0);
}

TEST_CASE("a fault or a disarming ends an experiment for good") {
  for (const bool fault : {true, false}) {
    Rig rig;
    arm_with(rig);
    REQUIRE(rig.send_status(steady(0.03F)) == Status::ok);
    rig.tick();
    if (fault) {
      rig.inputs.emergency_stop = true;
      rig.tick();
      rig.inputs.emergency_stop = false;
      rig.tick();
      REQUIRE(rig.command(Op::clear_fault) == Status::ok);
    } else {
      REQUIRE(rig.command(Op::disarm) == Status::ok);
    }
    CHECK(rig.outputs.motor_command_nm == 0.0F);
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.tick(3);
    CHECK(rig.outputs.motor_command_nm == doctest::Approx(0.01));
  }
}

TEST_CASE("an experiment ends the streamed model before it, with its deadline") {
  Rig rig;
  arm_with(rig);
  LocalModel model;
  model.torque_nm = 0.02F;
  model.deadline_s = 0.01F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick(2);
  REQUIRE(rig.send_status(steady(0.03F)) == Status::ok);
  rig.tick(30);
  CHECK(rig.state() == State::armed);
  CHECK(rig.outputs.motor_command_nm == doctest::Approx(0.03));
  CHECK(count(rig, EventKind::deadline_missed) == 0);
}
