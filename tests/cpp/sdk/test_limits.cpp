// A knob's stated limits, for an emulated device and for one that calls itself a
// board.
#include <doctest/doctest.h>

#include "protocol/reports.hpp"
#include "sdk/wrapped_transport.hpp"
#include "torsio/knob.hpp"

using namespace torsio;

namespace {

bool same(const Limits& is, const Limits& wanted) {
  const auto near = [](double a, double b) {
    return a == doctest::Approx(b).scale(0.01).epsilon(1e-6);
  };
  return near(is.motor_torque_max_nm, wanted.motor_torque_max_nm) &&
         near(is.motor_torque_continuous_max_nm, wanted.motor_torque_continuous_max_nm) &&
         near(is.brake_torque_max_nm, wanted.brake_torque_max_nm) &&
         near(is.speed_limit_rad_s, wanted.speed_limit_rad_s) && is.held_low == wanted.held_low;
}

}  // namespace

TEST_CASE("an emulated knob gives what actuator and caps let it") {
  Knob knob = Knob::open("emulated");
  CHECK(same(knob.limits(), {0.085, 0.085, 0.11, 0.0, false}));
  knob.update([](ControlConfig& control) {
    control.motor_torque_cap_nm = 0.02;
    control.brake_torque_cap_nm = 0.05;
    control.speed_limit_rad_s = 30.0;
  });
  CHECK(same(knob.limits(), {0.02, 0.02, 0.05, 30.0, false}));
}

TEST_CASE(
    "a board is held low until its parts are confirmed and known, and then by its currents too") {
  Knob knob = Knob::open(test::emulated_with<protocol::Identity>(
      [](protocol::Identity& identity) { identity.board = 2; }));
  CHECK(same(knob.limits(), {0.015, 0.015, 0.03, 10.0, true}));
  knob.update([](ControlConfig& control) {
    control.motor_torque_cap_nm = 0.01;
    control.speed_limit_rad_s = 4.0;
  });
  CHECK(same(knob.limits(), {0.01, 0.01, 0.03, 4.0, true}));
  knob.update([](ControlConfig& control) { control = {}; });
  knob.update([](BoardConfig& board) { board.confirmed = true; });
  CHECK(same(knob.limits(), {0.015, 0.015, 0.03, 10.0, true}));
  knob.update([](CalibrationConfig& known) { known.values_are = Basis::measured; });
  // 1 A for ever at 0.05 N m/A.
  CHECK(same(knob.limits(), {0.085, 0.05, 0.11, 0.0, false}));
  // 64 of the 100 degrees that it makes are left.
  knob.update([](BoardConfig& board) { board.ambient_c = 61; });
  CHECK(same(knob.limits(), {0.085, 0.04, 0.11, 0.0, false}));
  knob.update([](BoardConfig& board) {
    board.ambient_c = 25;
    board.motor_current_max_a = 0.5;
    board.brake_current_max_a = 0.1;
  });
  CHECK(same(knob.limits(), {0.025, 0.025, 0.044, 0.0, false}));
}

TEST_CASE("an emulated device has no boot loader, and says so") {
  CHECK_THROWS_AS(start_bootloader("emulated"), Refused);
  CHECK_THROWS_AS(start_bootloader("TS-9999"), DeviceNotFound);
}
