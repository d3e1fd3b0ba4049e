// What the board says of itself: parts confirmed or not, broken or not, and why it started.
#include <cmath>
#include <cstdint>
#include <utility>

#include "device/rig.hpp"

using namespace torsio::protocol;
using torsio::test::Rig;

namespace {

torsio::device::BoardInfo real_board() {
  torsio::device::BoardInfo info;
  info.moves_parts = true;
  info.control_period_ns = 50'000;
  return info;
}

/// Deep in a wall that is far too strong, armed, without a soft start.
void push(Rig& rig) {
  ControlConfig control;
  control.passive_ramp_s = 0.0F;
  control.watchdog_s = 60.0F;
  REQUIRE(rig.set(control).ok());
  Wall wall;
  wall.target = {1, 0, 0};
  wall.stiffness_nm_per_rad = 20.0F;
  REQUIRE(rig.send_status(wall) == Status::ok);
  REQUIRE(rig.send_status(Commit{2, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  for (int n = 0; n < 60; ++n) {
    rig.inputs.encoder_count += 1;
    rig.tick(100);
  }
}

}  // namespace

TEST_CASE(
    "a real board gives little until its parts are confirmed and known, an emulated one all") {
  for (const bool real : {true, false}) {
    for (const auto& [confirmed, basis] : {std::pair{Toggle::off, Basis::assumed},
                                           {Toggle::off, Basis::measured},
                                           {Toggle::on, Basis::assumed},
                                           {Toggle::on, Basis::stated},
                                           {Toggle::on, Basis::measured}}) {
      Rig rig(real ? real_board() : torsio::device::BoardInfo{.control_period_ns = 50'000});
      BoardConfig board;
      board.confirmed = confirmed;
      REQUIRE(rig.set(board).ok());
      CalibrationConfig known;
      known.values_are = basis;
      REQUIRE(rig.set(known).ok());
      push(rig);
      const bool timid = real && (confirmed == Toggle::off || basis == Basis::assumed);
      CAPTURE(timid);
      CHECK(std::abs(rig.outputs.motor_command_nm) <= (timid ? 0.015F : 0.085F));
      CHECK(std::abs(rig.outputs.motor_command_nm) >= (timid ? 0.0149F : 0.05F));
      CHECK(rig.outputs.brake_command_nm <= (timid ? 0.03F : 0.11F));
      CHECK(rig.outputs.brake_command_nm >= (timid ? 0.0299F : 0.05F));
      // 15 rad/s: a count a tick is 15.3.
      for (int n = 0; n < 2000; ++n) {
        rig.inputs.encoder_count += 1;
        rig.tick();
      }
      CHECK(rig.get<Health>().faults == (timid ? fault::over_speed : 0));
    }
  }
}

TEST_CASE("a board whose parts are confirmed and not known is held low but for experiments") {
  for (const Toggle confirmed : {Toggle::off, Toggle::on}) {
    Rig rig(real_board());
    BoardConfig board;
    board.confirmed = confirmed;
    REQUIRE(rig.set(board).ok());
    ControlConfig control;
    control.passive_ramp_s = 0.0F;
    control.watchdog_s = 60.0F;
    control.motor_torque_cap_nm = 0.07F;
    control.speed_limit_rad_s = 40.0F;
    REQUIRE(rig.set(control).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    Excitation excitation;
    excitation.duration_s = 60.0F;
    excitation.travel_rad = 100.0F;
    excitation.speed_limit_rad_s = 1000.0F;
    excitation.torque_limit_nm = 1.0F;
    excitation.motor_command_nm = 1.0F;
    excitation.brake_command_nm = 1.0F;
    REQUIRE(rig.send_status(excitation) == Status::ok);
    rig.tick(3);
    const bool timid = confirmed == Toggle::off;
    CHECK(rig.outputs.motor_command_nm == (timid ? 0.015F : 0.07F));
    CHECK(rig.outputs.brake_command_nm == (timid ? 0.03F : 0.11F));
    const auto faults_at = [&](std::uint32_t counts_in_8_ticks) {  // 1.92 rad/s for each
      for (int n = 0; n < 2000; ++n) {
        if (n % 8 == 0) rig.inputs.encoder_count += counts_in_8_ticks;
        rig.tick();
      }
      return rig.get<Health>().faults;
    };
    CHECK(faults_at(8) == (timid ? fault::over_speed : 0));
    CHECK(faults_at(32) == fault::over_speed);  // the user's own limit
    // A scene after it is held low again.
    rig.tick(2000);
    REQUIRE(rig.command(Op::clear_fault) == Status::ok);
    Constant constant;
    constant.torque_nm = 1.0F;
    REQUIRE(rig.send_status(constant) == Status::ok);
    REQUIRE(rig.send_status(Commit{2, 0, 1}) == Status::ok);
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.tick(300);
    CHECK(rig.outputs.motor_command_nm <= 0.015F);
    CHECK(faults_at(8) == fault::over_speed);
  }
}

TEST_CASE("an excitation that is let go at speed fades as it would without a limit for scenes") {
  Rig rig(real_board());
  BoardConfig board;
  board.confirmed = Toggle::on;
  REQUIRE(rig.set(board).ok());
  ControlConfig control;
  control.passive_ramp_s = 0.05F;
  control.watchdog_s = 60.0F;
  REQUIRE(rig.set(control).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  Excitation excitation;
  excitation.duration_s = 60.0F;
  excitation.travel_rad = 1000.0F;
  excitation.speed_limit_rad_s = 100.0F;
  excitation.torque_limit_nm = 1.0F;
  excitation.motor_command_nm = 0.05F;
  REQUIRE(rig.send_status(excitation) == Status::ok);
  const auto turn = [&](int ticks) {  // 31 rad/s; a scene would be cut at 10
    for (int n = 0; n < ticks; ++n) {
      rig.inputs.encoder_count += 2;
      rig.tick();
    }
  };
  turn(2000);
  REQUIRE(rig.outputs.motor_command_nm == 0.05F);
  REQUIRE(rig.device->receive(encode(Command{7, 0, Op::disarm})));
  turn(20);
  CHECK(rig.get<Health>().faults == 0);
  CHECK(rig.outputs.motor_command_nm > 0.0F);
  CHECK(rig.outputs.motor_command_nm < 0.05F);
  turn(4000);
  CHECK(rig.get<Health>().faults == 0);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("a board without confirmed parts never gives more than its user's own limits") {
  Rig rig(real_board());
  ControlConfig control;
  control.motor_torque_cap_nm = 0.004F;
  control.brake_torque_cap_nm = 0.01F;
  control.speed_limit_rad_s = 5.0F;
  control.passive_ramp_s = 0.0F;
  control.watchdog_s = 60.0F;
  REQUIRE(rig.set(control).ok());
  Constant constant;
  constant.torque_nm = 1.0F;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(Commit{2, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(3);
  CHECK(rig.outputs.motor_command_nm <= 0.004F);
  CHECK(rig.outputs.brake_command_nm <= 0.01F);
  for (int n = 0; n < 20'000; ++n) {
    if (n % 2 == 0) rig.inputs.encoder_count += 1;  // 7.7 rad/s
    rig.tick();
  }
  CHECK(rig.get<Health>().faults == fault::over_speed);
}

TEST_CASE("the brake that fades on a board without confirmed parts stays low, and as configured") {
  for (const auto& [wanted_nm, given_nm] : {std::pair{0.1F, 0.03F}, {0.02F, 0.02F}}) {
    Rig rig(real_board());
    ControlConfig control;
    control.passive_ramp_s = 0.1F;
    control.passive_brake_nm = wanted_nm;
    REQUIRE(rig.set(control).ok());
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.tick(3);
    rig.device->set_connected(false);
    rig.tick(3);
    CHECK(rig.outputs.brake_command_nm == given_nm);
  }
}

TEST_CASE("a coarse encoder may jump by 16 counts, or a quarter of its turn") {
  for (const auto& [per_turn, most] : {std::pair{256U, 16U}, {32U, 8U}}) {
    for (const std::uint32_t counts : {most, most + 1}) {
      Rig rig(torsio::device::BoardInfo{.control_period_ns = 50'000});
      ActuatorConfig actuator;
      actuator.counts_per_rev = per_turn;
      REQUIRE(rig.set(actuator).ok());
      rig.tick();
      rig.inputs.encoder_count += counts;
      rig.tick();
      CAPTURE(per_turn);
      CHECK(rig.get<Health>().faults == (counts > most ? fault::encoder : 0));
    }
  }
}

TEST_CASE("the longest jump that is none is what a knob makes at 2000 rad/s") {
  // 2000 rad/s of 8192 counts in 50 us: 130 counts.
  for (const int sign : {1, -1}) {
    for (const int counts : {130, 131}) {
      Rig rig(torsio::device::BoardInfo{.control_period_ns = 50'000});
      rig.tick();
      rig.inputs.encoder_count += static_cast<std::uint32_t>(sign * counts);
      rig.tick();
      CHECK(rig.get<Health>().faults == (counts > 130 ? fault::encoder : 0));
    }
  }
}

TEST_CASE("a fault of the power stage is called what the board calls it") {
  for (const std::uint16_t named : {fault::current_sensor, fault::winding, fault::actuator,
                                    fault::temperature, fault::supply}) {
    Rig rig;
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.inputs.actuator_fault = true;
    rig.inputs.power_faults = named;
    rig.tick();
    CHECK(rig.get<Health>().faults == named);
    CHECK(rig.command(Op::clear_fault) == Status::fault_persists);
    rig.inputs.actuator_fault = false;
    rig.inputs.power_faults = 0;
    CHECK(rig.command(Op::clear_fault) == Status::ok);
    CHECK(rig.get<Health>().faults == 0);
  }
}

TEST_CASE("a fault of the power stage hides no other, and its name without it says nothing") {
  for (const bool at_once : {true, false}) {
    Rig rig;
    rig.inputs.power_faults = fault::winding;
    rig.inputs.emergency_stop = true;
    if (!at_once) {
      rig.tick();
      CHECK(rig.get<Health>().faults == fault::emergency_stop);
    }
    rig.inputs.actuator_fault = true;
    rig.tick();
    CHECK(rig.get<Health>().faults == (fault::emergency_stop | fault::winding));
  }
}

TEST_CASE("a supply that is not there before anybody arms is waited for") {
  Rig rig;
  rig.inputs.actuator_fault = true;
  rig.inputs.power_faults = fault::supply;
  rig.tick();
  CHECK(rig.get<Health>().faults == fault::supply);
  CHECK(rig.command(Op::arm) == Status::fault_latched);
  CHECK(rig.command(Op::clear_fault) == Status::fault_persists);
  rig.inputs.actuator_fault = false;
  rig.inputs.power_faults = 0;
  // In the tick in which it is there.
  CHECK(rig.command(Op::arm) == Status::ok);
  CHECK(rig.get<Health>().faults == 0);

  // From an armed device it is latched as any other.
  rig.inputs.actuator_fault = true;
  rig.inputs.power_faults = fault::supply;
  rig.tick();
  CHECK_FALSE(rig.outputs.enabled);
  rig.inputs.actuator_fault = false;
  rig.inputs.power_faults = 0;
  rig.tick(5);
  CHECK(rig.get<Health>().faults == fault::supply);
  CHECK(rig.command(Op::arm) == Status::fault_latched);
  CHECK(rig.command(Op::clear_fault) == Status::ok);
}

TEST_CASE("what bridges and sensor say for want of a supply goes with it, in any order") {
  for (const std::uint16_t before : {fault::actuator, fault::supply, fault::current_sensor}) {
    Rig rig;
    CAPTURE(before);
    const auto tell = [&](std::uint16_t power_faults) {
      rig.inputs.actuator_fault = power_faults != 0;
      rig.inputs.power_faults = power_faults;
      rig.tick();
    };
    tell(before);
    tell(fault::actuator | fault::supply | fault::current_sensor);
    tell(fault::actuator);
    CHECK(rig.get<Health>().faults != 0);
    tell(0);
    rig.tick();
    CHECK(rig.get<Health>().faults == 0);
    CHECK(rig.command(Op::arm) == Status::ok);
    // From an armed device nothing is forgiven.
    tell(fault::actuator | fault::supply);
    tell(0);
    rig.tick();
    CHECK(rig.get<Health>().faults == (fault::actuator | fault::supply));
  }
  // Without a word of the supply a bridge's fault is one.
  Rig rig;
  rig.inputs.actuator_fault = true;
  rig.tick();
  rig.inputs.actuator_fault = false;
  rig.tick(5);
  CHECK(rig.get<Health>().faults == fault::actuator);
}

TEST_CASE("a supply that comes back takes no other fault with it") {
  for (const bool supply_first : {true, false}) {
    Rig rig;
    CAPTURE(supply_first);
    rig.inputs.actuator_fault = true;
    rig.inputs.power_faults = supply_first ? fault::supply : fault::winding;
    rig.tick();
    rig.inputs.power_faults = fault::supply | fault::winding;
    rig.tick();
    rig.inputs.actuator_fault = false;
    rig.inputs.power_faults = 0;
    rig.tick(5);
    CHECK(rig.get<Health>().faults == (fault::supply | fault::winding));
    CHECK(rig.command(Op::clear_fault) == Status::ok);
    // Clearing one by hand does not clear the next.
    rig.inputs.emergency_stop = true;
    rig.tick();
    rig.inputs.emergency_stop = false;
    rig.tick(5);
    CHECK(rig.get<Health>().faults == fault::emergency_stop);
  }
}

TEST_CASE("an encoder that goes on jumping cannot be cleared, one that jumped once can") {
  Rig rig;
  rig.tick();
  const auto clear = [&](std::uint32_t jump) {
    REQUIRE(rig.device->receive(encode(Command{9, 0, Op::clear_fault})));
    rig.inputs.encoder_count += jump;
    rig.tick();
    return rig.status(rig.acknowledgements.back());
  };
  rig.inputs.encoder_count += 4000;
  rig.tick();
  CHECK(rig.get<Health>().faults == fault::encoder);
  CHECK(clear(4000) == Status::fault_persists);
  CHECK(clear(0) == Status::fault_persists);  // from the tick before
  CHECK(clear(0) == Status::ok);
  CHECK(rig.get<Health>().faults == 0);
}

TEST_CASE("why the board started is in its health") {
  torsio::device::BoardInfo info;
  info.reset_cause = ResetCause::brown_out;
  Rig rig(info);
  CHECK(rig.get<Health>().reset_cause == ResetCause::brown_out);
}
