// What the power stage notices by itself, on a motor that is solved exactly: when it must speak up,
// how soon, and when it must be quiet.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <utility>

#include "device/power_logic.hpp"

using torsio::device::PowerBoard;
using torsio::device::PowerDrive;
using torsio::device::PowerLogic;
using torsio::device::TickOutputs;
using torsio::protocol::BoardConfig;
namespace fault = torsio::protocol::fault;

namespace {

constexpr PowerBoard kFast{25'000, 25'000, true};
constexpr PowerBoard kSlow{100'000, 100'000, false};

/// A winding with its bridge and its sensor. Its values are those of the configuration unless a
/// test says otherwise.
struct Motor {
  explicit Motor(const PowerBoard& on, BoardConfig of = {})
      : config(of), board(on), logic(config, board, 0.06F) {
    run(0.0, 0.1);
  }

  double period_s() const { return 1e-9 * board.current_period_ns; }
  double honest_steps() const { return zero_steps + amperes * volts_per_a / 3.3 * 4096.0; }

  /// Wants a torque for so long, or lets go of the bridges with 0 N m at rest.
  /// @returns when a fault was seen, in s; negative: never
  double run(double torque_nm, double time_s, bool enabled = false) {
    const double decay = std::exp(-period_s() * ohm / henry);
    for (double now_s = 0.0; now_s < time_s; now_s += period_s()) {
      const double steps = sensor ? sensor(*this) : honest_steps();
      logic.set_speed(static_cast<float>(seen_speed));
      const PowerDrive drive =
          logic.step({static_cast<float>(torque_nm), 0.0F, enabled},
                     static_cast<std::int32_t>(std::clamp(std::round(steps), 0.0, 4095.0)));
      const double lost_v = std::clamp(amperes / 0.02, -1.0, 1.0) * dead_time_v;
      const double volts =
          enabled ? supply * static_cast<double>(acting) - emf_v_s * speed - lost_v : 0.0;
      const double end = enabled ? volts / ohm : 0.0;
      amperes = end + (amperes - end) * decay;  // flows on when the bridge has let go
      if (inertia > 0.0) turn();
      most = std::max(most, std::abs(amperes));
      acting = drive.motor_share;
      if (logic.find_faults(bridge_reports) != 0) return now_s + period_s();
    }
    return -1.0;
  }
  /// A period of a knob that nobody holds, with the friction of the reference actuator.
  void turn() {
    const double pushed = speed + period_s() * emf_v_s * amperes / inertia;
    const double friction = period_s() * 8e-3 / inertia;
    speed = pushed - std::clamp(pushed, -friction, friction);
    look();
  }
  /// What a speed estimate with 100 Hz makes of a period of such speed.
  void look() {
    const double pole = 2 * 3.14159265 * 100.0;
    behind += period_s() * (speed - seen_speed - 2 * pole * behind);
    seen_speed += period_s() * pole * pole * behind;
  }
  void shift_zero(double by_a) { zero_steps += by_a * volts_per_a / 3.3 * 4096.0; }
  double push(double torque_nm, double time_s) { return run(torque_nm, time_s, true); }

  BoardConfig config;
  PowerBoard board;
  PowerLogic logic;
  double ohm = 2.5;
  double henry = 1.5e-3;
  double supply = 12.0;
  double volts_per_a = 0.2;
  double emf_v_s = 0.05;
  double speed = 0.0;        // rad/s
  double seen_speed = 0.0;   // what the encoder says
  double behind = 0.0;       // the estimate's position, in rad
  double inertia = 0.0;      // of a knob that turns by itself; 0: it turns as a test says
  double dead_time_v = 0.0;  // of its voltage that the bridge keeps
  double zero_steps = 2048.0;
  double amperes = 0.0;
  double most = 0.0;
  float acting = 0.0F;
  bool bridge_reports = false;
  std::function<double(const Motor&)> sensor;
};

/// What the supply makes of the winding is told within a fifth of a second, and over with the
/// torque.
void check_found_out(Motor& motor, double torque_nm) {
  const double found_s = motor.push(torque_nm, 1.0);
  CHECK(found_s > 4e-3);
  CHECK(found_s < 0.2);
  CHECK(motor.logic.find_faults(false) == fault::winding);
  motor.run(0.0, 1e-3);
  CHECK(motor.logic.find_faults(false) == 0);
}

/// A board that measures its supply.
struct Divider {
  Divider(const PowerBoard& on, double supply_v, int ratio)
      : board(on), of(ratio), logic(configured(supply_v, ratio), on, 0.06F) {}

  static BoardConfig configured(double supply_v, int ratio) {
    BoardConfig config;
    config.supply_v = static_cast<float>(supply_v);
    config.supply_sense_pin = 27;
    config.supply_sense_ratio = static_cast<std::uint8_t>(ratio);
    return config;
  }
  double period_s() const { return 1e-9 * board.current_period_ns; }

  /// The supply gives so many volts for so long.
  /// @param on goes on when there is a fault
  /// @returns when a fault was seen, in s; negative: never
  double watch(double volts, double time_s, bool on = false) {
    const double steps = std::clamp(std::floor(volts / of / 3.3 * 4096.0), 0.0, 4095.0);
    for (double now_s = 0.0; now_s < time_s; now_s += period_s()) {
      if (!on && logic.find_faults(false) != 0) return now_s;
      logic.step({}, 2048);
      if (logic.wants_supply()) logic.see_supply(static_cast<std::int32_t>(steps));
    }
    return -1.0;
  }

  PowerBoard board;
  double of;
  PowerLogic logic;
};

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
    // A motor that is turned makes 0.05 V s of its own, which asks for no current: 0.3 A at 15
    // rad/s.
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
      for (const double shift_a : {0.18, -0.25, 0.4, -0.6, 1.0, -1.6}) {
        CAPTURE(inertia);
        CAPTURE(shift_a);
        Motor motor(board);
        motor.inertia = inertia;
        CHECK(motor.push(0.0, 0.05) < 0.0);
        motor.shift_zero(shift_a);
        const double found_s = motor.push(0.0, 1.0);
        CHECK(found_s > 0.0);
        CHECK(found_s < 0.13);
        CHECK(std::abs(motor.speed) < 15.0);
        CHECK(motor.logic.find_faults(false) == fault::winding);
      }
      // What is not found out does not turn it: 0.1 A are 5 mN m, of 8 that friction holds.
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
      // What was not found out then is when the motor lets go.
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

TEST_CASE("without a divider nobody asks for the supply") {
  Motor motor(kFast);
  for (int i = 0; i < 1000; ++i) {
    motor.logic.step({}, 2048);
    REQUIRE_FALSE(motor.logic.wants_supply());
  }
}

TEST_CASE("a supply a quarter beside the configured one is a fault, while it lasts") {
  for (const PowerBoard& board : {kFast, kSlow}) {
    for (const auto& [supply_v, ratio] : {std::pair{12.0, 11}, {24.0, 16}, {5.0, 2}, {36.0, 11}}) {
      Divider divider(board, supply_v, ratio);
      CAPTURE(supply_v);
      // Three readings, each half a millisecond after the last.
      const double soon_s = 1.5e-3 + divider.period_s();
      CHECK(divider.watch(supply_v, 0.1) < 0.0);
      for (const double wrong : {0.0, 0.25, 0.5, 0.74, 1.26, 2.0, 20.0}) {
        CAPTURE(wrong);
        const double found_s = divider.watch(wrong * supply_v, 0.1);
        // A converter whose range ends below that sees its end.
        CHECK(found_s > 0.9e-3);
        CHECK(found_s <= soon_s);
        CHECK(divider.logic.find_faults(false) == fault::supply);
        CHECK(divider.watch(wrong * supply_v, 0.1) == 0.0);
        // Back again it must stay so for a twentieth of a second, then all is well.
        divider.watch(supply_v, 0.0491, true);
        CHECK(divider.logic.find_faults(false) == fault::supply);
        divider.watch(supply_v, 3e-3, true);
        CHECK(divider.logic.find_faults(false) == 0);
      }
      for (const double right : {0.76, 0.9, 1.0, supply_v < 36.0 ? 1.24 : 1.0}) {
        CAPTURE(right);
        CHECK(divider.watch(right * supply_v, 0.1) < 0.0);
      }
    }
  }
}

TEST_CASE("a supply at the edge of the band does not flutter") {
  Divider divider(kFast, 12.0, 11);
  int changes = 0;
  std::uint16_t before = 0;
  std::uint32_t noise = 1;
  for (int step = 0; step < 400'000; ++step) {
    divider.logic.step({}, 2048);
    noise = 1664525U * noise + 1013904223U;
    // 9 V are 1015 steps.
    const auto steps = static_cast<std::int32_t>(1013 + (noise >> 30));
    if (divider.logic.wants_supply()) divider.logic.see_supply(steps);
    const std::uint16_t now = divider.logic.find_faults(false);
    changes += now == before ? 0 : 1;
    before = now;
  }
  CHECK(changes == 1);  // of ten seconds
}

TEST_CASE("a reading or two that are wrong are noise, however often they come") {
  Divider divider(kFast, 12.0, 11);
  int readings = 0;
  for (int step = 0; step < 100'000; ++step) {
    divider.logic.step({}, 2048);
    if (divider.logic.wants_supply()) divider.logic.see_supply(++readings % 3 == 0 ? 1354 : 0);
    REQUIRE(divider.logic.find_faults(false) == 0);
  }
  CHECK(readings == 100'000 / 20);
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

TEST_CASE("warm air leaves less for ever") {
  BoardConfig config;
  config.ambient_c = 65;
  Motor motor(kSlow, config);
  CHECK(motor.push(0.085, 100.0) < 0.0);
  // 60 of the 100 degrees that 1 A makes.
  CHECK(motor.amperes == doctest::Approx(std::sqrt(0.6)).scale(0).epsilon(0.03));
}

TEST_CASE("a current that warms more than was allowed is a fault until the winding has cooled") {
  Motor motor(kSlow);
  std::mt19937 random(1);
  // 1 A on the average and 0.8 A to and fro, which nobody asked for: 1.64 times the heat.
  motor.sensor = [&](const Motor& of) {
    return of.honest_steps() + (random() % 2 == 0 ? -1.0 : 1.0) * 0.8 * 0.2 / 3.3 * 4096.0;
  };
  const double found_s = motor.push(0.085, 100.0);
  CHECK(found_s > 5.0);
  CHECK(motor.logic.find_faults(false) == fault::temperature);
  motor.sensor = nullptr;
  // From 145 to 125 degrees in air of 25, with a time constant of 10 s.
  double cooled_s = 0.0;
  while (motor.logic.find_faults(false) != 0 && cooled_s < 5.0) {
    motor.run(0.0, 1e-3);
    cooled_s += motor.period_s();
  }
  CHECK(cooled_s == doctest::Approx(10.0 * std::log(120.0 / 100.0)).scale(0).epsilon(0.05));
  CHECK(motor.push(0.0, 0.1) < 0.0);
}

TEST_CASE("a coil gets more than its continuous current for a while, driven or not") {
  for (const float inductance_h : {0.0F, 2.4F}) {
    CAPTURE(inductance_h);
    BoardConfig config;
    config.brake_continuous_percent = 50;
    config.brake_inductance_h = inductance_h;
    PowerLogic logic(config, kSlow, 0.06F);
    const TickOutputs full{0.0F, 0.132F, true};  // 0.3 A
    const auto mean_a = [&](double time_s) {
      double sum = 0.0;
      const int n = static_cast<int>(time_s / 100e-6);
      for (int i = 0; i < n; ++i) {
        sum += static_cast<double>(logic.step(full, 2048).brake_share) * 12.0 / 40.0;
        REQUIRE(logic.find_faults(false) == 0);
      }
      return sum / n;
    };
    mean_a(0.5);  // so long a driven coil rises
    CHECK(mean_a(10.0) == doctest::Approx(0.3).scale(0).epsilon(0.01));
    mean_a(400.0);
    CHECK(mean_a(1.0) == doctest::Approx(0.15).scale(0).epsilon(0.03));
  }
}

TEST_CASE("the peak current is for seconds, the continuous one for ever") {
  Motor motor(kSlow);
  const double wanted_nm = 1.7 * 0.05;
  CHECK(motor.push(wanted_nm, 1.0) < 0.0);
  CHECK(motor.amperes == doctest::Approx(1.7).scale(0).epsilon(0.02));
  CHECK(motor.push(wanted_nm, 100.0) < 0.0);
  // The square of the current is what warms: 1 A is the default.
  CHECK(motor.amperes == doctest::Approx(1.0).scale(0).epsilon(0.03));
  motor.run(0.0, 60.0);  // cools down, let go
  CHECK(motor.push(wanted_nm, 0.2) < 0.0);
  CHECK(motor.amperes == doctest::Approx(1.7).scale(0).epsilon(0.02));
}
