// Faults that the power stage notices, on a motor that is solved exactly: when it must report,
// how soon, and when it must be quiet.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <utility>

#include "power_motor.hpp"

namespace fault = torsio::protocol::fault;
using torsio::device::PowerLogic;
using torsio::protocol::BoardConfig;
using torsio::tests::kFast;
using torsio::tests::kSlow;
using torsio::tests::Motor;
using torsio::tests::PowerBoard;

namespace {

/// A wrong supply shows in the winding within a fifth of a second, and ends with the
/// torque.
void check_found_out(Motor& motor, double torque_nm) {
  const double found_s = motor.push(torque_nm, 1.0);
  CHECK(found_s > 4e-3);
  CHECK(found_s < 0.2);
  CHECK(motor.logic.find_faults(false) == fault::winding);
  motor.run(0.0, 1e-3);
  CHECK(motor.logic.find_faults(false) == 0);
}

}  // namespace

TEST_CASE("a sound motor is believed at every torque and speed, with values that are a third off") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const double error : {0.75, 1.0, 1.3}) {
      for (const double speed : {-60.0, 0.0, 60.0}) {
        Motor motor(board);
        motor.ohm *= error;
        motor.henry *= 2.0 - error;
        motor.speed = motor.seen_speed = speed;
        for (const double torque_nm : {0.085, -0.085, 0.0, 0.02, -0.1}) {
          CAPTURE(error);
          CAPTURE(speed);
          CAPTURE(torque_nm);
          CHECK(motor.push(torque_nm, 0.02) < 0.0);
        }
      }
    }
  }
}

TEST_CASE("a sensor that says nothing, or always the same, is found out in twenty milliseconds") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const double stuck_steps : {2048.0, 2048.0 + 200.0, 2048.0 - 400.0}) {
      for (const double torque_nm : {0.085, -0.085}) {
        Motor motor(board);
        motor.push(0.0, 0.01);
        motor.sensor = [=](const Motor&) { return stuck_steps; };
        const double found_s = motor.push(torque_nm, 1.0);
        CAPTURE(stuck_steps);
        CHECK(found_s > 0.0);
        CHECK(found_s < 20e-3);
        CHECK(motor.logic.find_faults(false) == fault::winding);
        // It stays one for as long as the bridge is on, even if the sensor works again.
        motor.sensor = nullptr;
        for (int n = 0; n < 500; ++n) motor.push(0.0, motor.period_s());
        CHECK(motor.logic.find_faults(false) == fault::winding);
        // Nothing is left to doubt once the bridge has let go, so that the fault can be cleared.
        motor.run(0.0, 1e-3);
        CHECK(motor.logic.find_faults(false) == 0);
        CHECK(motor.push(torque_nm, 0.02) < 0.0);
      }
    }
  }
}

TEST_CASE("a sound motor that turns fast is believed, and one with a weak supply") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const double sign : {1.0, -1.0}) {
      Motor fast(board);
      fast.speed = fast.seen_speed = sign * 150.0;
      for (const double torque_nm : {0.0, 0.02, -0.02}) CHECK(fast.push(torque_nm, 0.02) < 0.0);
      Motor weak(board);
      weak.supply *= 0.75;
      weak.ohm *= 1.3;
      CHECK(weak.push(sign * 0.085, 0.05) < 0.0);
    }
  }
}

TEST_CASE("what is far off is told after 3 to 6 ms, whatever the board's rate") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    Motor motor(board);
    motor.push(0.0, 0.01);
    motor.supply = 0.0;
    const double found_s = motor.push(0.085, 0.1);
    CHECK(found_s > 3e-3);
    CHECK(found_s < 6e-3);
    // And is forgotten with the power, once its cause is gone.
    motor.supply = 12.0;
    motor.run(0.0, 1e-3);
    CHECK(motor.push(0.085, 0.02) < 0.0);
  }
}

TEST_CASE("a missing supply, and a motor that spins unseen, do not fit either") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    Motor unpowered(board);
    unpowered.supply = 0.0;
    CHECK(unpowered.push(0.085, 0.1) > 0.0);
    CHECK(unpowered.logic.find_faults(false) == fault::winding);
    Motor runaway(board);  // the encoder's cable is off
    runaway.speed = 150.0;
    CHECK(runaway.push(0.085, 0.1) > 0.0);
    CHECK(runaway.logic.find_faults(false) == fault::winding);
  }
}

TEST_CASE("a supply of twice the configured voltage is found out once the motor works") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const double torque_nm : {0.085, -0.04}) {
      CAPTURE(torque_nm);
      Motor motor(board);
      motor.supply = 24.0;
      check_found_out(motor, torque_nm);
    }
    // Where little flows, or the motor makes much of the voltage, nothing is said of it.
    Motor idle(board);
    idle.supply = 24.0;
    CHECK(idle.push(0.01, 0.5) < 0.0);
    // At 70 rad/s it makes nearly all of the voltage itself, 3.5 V of 4.25.
    Motor turning(board);
    turning.supply = 24.0;
    turning.speed = turning.seen_speed = -70.0;
    CHECK(turning.push(0.085, 0.5) < 0.0);
    // Nor where it seems too much for moments only, however often.
    Motor tapping(board);
    tapping.supply = 24.0;
    for (int tap = 0; tap < 6; ++tap) {
      CHECK(tapping.push(0.085, 0.03) < 0.0);
      CHECK(tapping.push(0.0, 0.05) < 0.0);
    }
    // A supply that is a tenth high, on a winding that is a third low, is no fault.
    Motor tolerable(board);
    tolerable.supply = 13.2;
    tolerable.ohm = 2.5 / 1.43;
    CHECK(tolerable.push(0.085, 1.0) < 0.0);
  }
}

TEST_CASE("a supply of half the configured voltage is found out once the motor works or turns") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const double torque_nm : {0.085, -0.04, 0.014}) {
      for (const double warmth : {1.0, 1.3}) {
        CAPTURE(torque_nm);
        CAPTURE(warmth);
        Motor motor(board);
        motor.supply = 6.0;
        motor.ohm *= warmth;
        check_found_out(motor, torque_nm);
      }
    }
    // A turned motor makes 0.05 V s, and nobody asked for its current: 0.3 A at 15 rad/s.
    for (const auto& [speed, tells] : {std::pair{15.0, true}, {-15.0, true}, {8.0, false}}) {
      Motor turned(board);
      turned.supply = 6.0;
      turned.speed = turned.seen_speed = speed;
      CAPTURE(speed);
      CHECK((turned.push(0.0, 0.5) > 0.0) == tells);
    }
    // Where little flows nothing is said of it, nor where it seems too little for moments only.
    Motor idle(board);
    idle.supply = 6.0;
    CHECK(idle.push(0.006, 0.5) < 0.0);
    Motor tapping(board);
    tapping.supply = 6.0;
    for (int tap = 0; tap < 6; ++tap) {
      CHECK(tapping.push(0.085, 0.01) < 0.0);
      CHECK(tapping.push(0.0, 0.05) < 0.0);
    }
  }
}

TEST_CASE("a sensor that shows half the current, or twice, is found out once the motor works") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const double gain : {0.5, 2.0}) {
      CAPTURE(gain);
      Motor motor(board);
      motor.sensor = [=](const Motor& now) {
        return now.zero_steps + gain * (now.honest_steps() - now.zero_steps);
      };
      const double found_s = motor.push(0.06, 1.0);
      CHECK(found_s > 0.0);
      CHECK(found_s < 0.13);
      CHECK(motor.logic.find_faults(false) == fault::winding);
    }
  }
}

TEST_CASE("sound parts within their tolerances are believed, whatever is asked of them") {
  std::mt19937 random(3);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (int n = 0; n < 150; ++n) {
      Motor motor(board);
      motor.ohm *= between(0.7, 1.3);
      motor.henry *= between(0.7, 1.3);
      motor.emf_v_s *= between(0.9, 1.1);
      motor.supply *= between(0.9, 1.05);
      motor.speed = between(-1.0, 1.0) > 0.0 ? between(-120.0, 120.0) : 0.0;
      motor.seen_speed = motor.speed + between(-2.0, 2.0);
      const double torque_nm = between(0.0, 0.1);
      const double hertz = std::exp(between(std::log(0.5), std::log(400.0)));
      const double offset_nm = between(-0.05, 0.05);
      CAPTURE(motor.ohm);
      CAPTURE(motor.henry);
      CAPTURE(motor.supply);
      CAPTURE(motor.speed);
      CAPTURE(torque_nm);
      CAPTURE(hertz);
      CAPTURE(offset_nm);
      double found_s = -1.0;
      for (double now_s = 0.0; now_s < 0.5 && found_s < 0.0; now_s += 1e-4) {
        const double wave = std::sin(2 * 3.14159265 * hertz * now_s);
        found_s =
            motor.push(offset_nm + torque_nm * (n % 2 == 0 ? wave : (wave > 0 ? 1 : -1)), 0.9e-4);
      }
      CHECK(found_s < 0.0);
    }
  }
}

TEST_CASE("a sensor whose zero moves is found out before the knob has gone far") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const double inertia : {1e-4, 6e-5}) {
      for (const double shift_a : {0.15, -0.25, 0.4, -0.6, 1.0, -1.6}) {
        CAPTURE(inertia);
        CAPTURE(shift_a);
        Motor motor(board);
        motor.inertia = inertia;
        CHECK(motor.push(0.0, 0.05) < 0.0);
        motor.shift_zero(shift_a);
        const double found_s = motor.push(0.0, 1.0);
        CHECK(found_s > 0.0);
        CHECK(found_s < 0.17);
        CHECK(std::abs(motor.speed) < 15.0);
        CHECK(motor.logic.find_faults(false) == fault::winding);
      }
      // An unnoticed current does not turn it: 0.1 A are 5 mN m, and friction holds 8.
      for (const double shift_a : {0.1, -0.1}) {
        Motor motor(board);
        motor.inertia = inertia;
        CHECK(motor.push(0.0, 0.05) < 0.0);
        motor.shift_zero(shift_a);
        CHECK(motor.push(0.0, 2.0) < 0.0);
        CHECK(motor.speed == 0.0);
      }
    }
  }
}

TEST_CASE("a zero that moves while the motor pushes on and on is found out once it is much") {
  BoardConfig config;
  config.motor_current_continuous_a = 2.0F;
  for (const PowerBoard& board : {kFast, kSlow}) {
    // 0.1 A and a fifth of 1.7 A are never doubted, and it takes some time to add up.
    for (const auto& [shift_a, tells] :
         {std::pair{-0.7, true}, {0.7, true}, {-0.4, false}, {0.4, false}}) {
      Motor motor(board, config);
      CHECK(motor.push(0.085, 2.5) < 0.0);
      motor.shift_zero(shift_a);
      const double found_s = motor.push(0.085, 0.5);
      CAPTURE(shift_a);
      CHECK((found_s > 0.0) == tells);
      CHECK(found_s < 0.1);
      // It is noticed when the motor lets go.
      if (!tells) CHECK(motor.push(0.0, 0.1) > 0.0);
    }
    // A supply that sags by a seventh is no fault.
    Motor sagging(board, config);
    for (int sag = 0; sag < 4; ++sag) {
      sagging.supply = 12.0 * (sag % 2 == 0 ? 1.0 : 0.86);
      CHECK(sagging.push(0.085, 1.0) < 0.0);
    }
  }
}

TEST_CASE("a knob that is turned fast and stopped hard is believed, with parts that are off") {
  std::mt19937 random(5);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (int n = 0; n < 100; ++n) {
      Motor motor(board);
      motor.ohm *= between(0.7, 1.3) * (n % 4 == 0 ? between(1.0, 1.2) : 1.0);
      motor.henry *= between(0.7, 1.3);
      motor.emf_v_s *= between(0.9, 1.1);
      motor.dead_time_v = between(0.0, 0.1);
      const double supply = 12.0 * between(0.95, 1.05);
      const double sag = between(0.0, 0.1);
      const double fastest = between(-80.0, 80.0);
      const double spin_s = between(0.1, 0.6);
      const double stop_s = std::exp(between(std::log(1e-3), std::log(30e-3)));
      const double torque_nm = between(-0.1, 0.1);
      CAPTURE(board.predicts);
      CAPTURE(n);
      double found_s = -1.0;
      for (double now_s = 0.0; now_s < 1.5 && found_s < 0.0; now_s += motor.period_s()) {
        const double turn_s = std::fmod(now_s, 0.75);
        const bool spins = turn_s < spin_s;
        motor.speed = fastest * (spins ? 1.0 - std::exp(-turn_s / 0.1)
                                       : std::exp(-(turn_s - spin_s) / stop_s));
        motor.look();
        motor.supply = supply * (std::fmod(now_s, 0.4) < 0.2 ? 1.0 : 1.0 - sag);
        found_s = motor.push(spins ? 0.0 : torque_nm, 0.5 * motor.period_s());
      }
      CHECK(found_s < 0.0);
    }
  }
}

TEST_CASE("what flows on after the power went is not taken for the sensor's zero") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const double rest_s : {1e-3, 3e-3, 8e-3, 0.1}) {
      Motor motor(board);
      motor.push(0.085, 0.05);
      motor.run(0.0, rest_s);
      motor.push(0.05, 0.05);
      CAPTURE(rest_s);
      CHECK(motor.amperes == doctest::Approx(1.0).scale(0).epsilon(0.01));
    }
    // A zero that has moved is learned nevertheless.
    Motor drifting(board);
    drifting.push(0.05, 0.05);
    drifting.zero_steps += 40.0;  // 0.16 A
    drifting.run(0.0, 0.3);
    drifting.push(0.05, 0.05);
    CHECK(drifting.amperes == doctest::Approx(1.0).scale(0).epsilon(0.01));
  }
}

TEST_CASE("a zero without room for the trip level is a fault before anybody can arm") {
  // 3 A at 0.2 V/A are 745 steps.
  for (const auto& [zero, fits] : {std::pair{700.0, false},
                                   {800.0, true},
                                   {3300.0, true},
                                   {3400.0, false},
                                   {0.0, false},
                                   {4095.0, false}}) {
    Motor motor(kFast);
    motor.zero_steps = zero;
    motor.logic = PowerLogic(motor.config, motor.board, 0.06F);
    motor.run(0.0, 0.01);
    CAPTURE(zero);
    CHECK((motor.logic.find_faults(false) == fault::current_sensor) != fits);
  }
  BoardConfig sensitive;
  sensitive.current_sense_v_per_a = 1.0F;  // 3 V to either side of 1.65 V
  Motor motor(kFast, sensitive);
  CHECK(motor.logic.find_faults(false) == fault::current_sensor);
}

TEST_CASE("a bridge is not believed in the millisecond in which it wakes up") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    Motor motor(board);
    motor.bridge_reports = true;
    CHECK(motor.logic.find_faults(true) == fault::actuator);  // at rest it is
    const double found_s = motor.push(0.0, 0.1);
    CHECK(found_s >= 0.9e-3);
    CHECK(found_s <= 1.2e-3);
    CHECK(motor.logic.find_faults(true) == fault::actuator);
    motor.bridge_reports = false;
    motor.run(0.0, 1e-3);
    motor.bridge_reports = true;
    CHECK(motor.push(0.0, 0.1) >= 0.9e-3);  // each time that it wakes up
  }
}
