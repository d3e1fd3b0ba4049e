// With which lag the brake's coil follows when its inductance is known, against a coil that is
// solved exactly.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>

#include "device/power_logic.hpp"
#include "rig.hpp"

using torsio::device::PowerBoard;
using torsio::device::PowerLogic;
using torsio::protocol::ActuatorConfig;
using torsio::protocol::BoardConfig;
using torsio::protocol::Op;
using torsio::protocol::Status;
using torsio::test::Rig;

namespace {

constexpr PowerBoard kFastCoil{25'000, 25'000, true};
constexpr PowerBoard kSlowCoil{100'000, 100'000, false};

BoardConfig known_coil() {
  BoardConfig config;
  config.brake_inductance_h = 2.4F;
  return config;
}

/// A coil at its bridge.
struct Coil {
  explicit Coil(const PowerBoard& on) : board(on), logic(known_coil(), board, 0.06F) {
    run(0.0, 1e-3, false);
  }

  void run(double torque_nm, double time_s, bool enabled = true) {
    for (double now_s = 0.0; now_s < time_s; now_s += period_s()) {
      const double share =
          logic.step({0.0F, static_cast<float>(torque_nm), enabled}, 2048).brake_share;
      const double end_a = enabled ? 12.0 / 40.0 * share : 0.0;
      amperes = end_a + (amperes - end_a) * std::exp(-period_s() * 40.0 / 2.4);
    }
  }
  /// How long it takes from 44 mN m, which are 0.1 A, to 1 / e of it.
  double fall_s() {
    run(0.044, 0.5);
    CHECK(amperes == doctest::Approx(0.1).scale(0).epsilon(0.01));
    double passed_s = 0.0;
    for (; amperes > 0.1 / 2.71828; passed_s += period_s()) run(0.0, 0.5 * period_s());
    return passed_s;
  }
  double period_s() const { return 1e-9 * board.current_period_ns; }

  PowerBoard board;
  PowerLogic logic;
  double amperes = 0.0;
};

}  // namespace

TEST_CASE("another lag of the brake reaches its coil once the bridges let go, and not before") {
  for (const PowerBoard& board : {kFastCoil, kSlowCoil}) {
    CAPTURE(board.current_period_ns);
    Coil coil(board);
    CHECK(coil.fall_s() == doctest::Approx(60e-3).scale(0).epsilon(0.01));
    // 0.1 A of 40 ohm, and 2.4 H in 20 ms: 8 V of 12.
    coil.logic.set_brake_lag(20e-3F);
    CHECK(coil.fall_s() == doctest::Approx(60e-3).scale(0).epsilon(0.01));
    coil.run(0.0, coil.period_s(), false);
    CHECK(coil.fall_s() == doctest::Approx(20e-3).scale(0).epsilon(0.01));
    // One that is copied has it too.
    Coil copy = coil;
    CHECK(copy.fall_s() == doctest::Approx(20e-3).scale(0).epsilon(0.01));
    coil.logic.set_brake_lag(30e-3F);
    copy = coil;
    copy.run(0.0, copy.period_s(), false);
    CHECK(copy.fall_s() == doctest::Approx(30e-3).scale(0).epsilon(0.01));
    // Without a lag it is as fast as the supply: L/R ln((0.3 + 0.1) / (0.3 + 0.0368)) = 10.3 ms.
    copy.logic.set_brake_lag(0.0F);
    copy.run(0.0, copy.period_s(), false);
    CHECK(copy.fall_s() == doctest::Approx(10.3e-3).scale(0).epsilon(0.02));
  }
}

TEST_CASE("a device tells its power stage the lag that it is configured with, without a restart") {
  Rig rig;
  Coil coil(kFastCoil);
  rig.device->measure_by(coil.logic);
  const auto falls_in = [&coil](double lag_s) {
    coil.run(0.0, coil.period_s(), false);
    CHECK(coil.fall_s() == doctest::Approx(lag_s).scale(0).epsilon(0.01));
  };
  ActuatorConfig actuator;
  actuator.brake_time_constant_s = 20e-3F;
  REQUIRE(rig.set(actuator).ok());
  falls_in(20e-3);
  // None is for the sensor alone.
  actuator.brake_time_constant_s = 0.0F;
  REQUIRE(rig.set(actuator).ok());
  falls_in(20e-3);
  REQUIRE(rig.command(Op::load_defaults) == Status::ok);
  falls_in(60e-3);
}
