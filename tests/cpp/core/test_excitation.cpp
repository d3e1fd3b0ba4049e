// Bounded experiments, against closed forms: what ends them, and what they never command.
#include <doctest/doctest.h>

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "core/excitation.hpp"

namespace {

using namespace torsio::core;
using doctest::Approx;

constexpr float kRadPerCount = 2.0F * 3.14159265F / 8192.0F;

struct Bench {
  ExcitationState state;
  PartitionParams limits{Law::motor_only, 0.5F, 0.085F, 0.110F};
  Motion motion;

  explicit Bench(const Excitation& first = {}, std::int64_t position_counts = 0) {
    motion.position_counts = position_counts;
    begin(first);
  }
  void begin(const Excitation& next) { begin_excitation(state, next, motion.position_counts); }
  Shares tick(int ticks = 1) {
    Shares shares;
    for (int n = 0; n < ticks; ++n) shares = excite(state, limits, motion, kRadPerCount);
    return shares;
  }
};

Excitation wide(float motor_nm, float brake_nm = 0.0F) {
  Excitation excitation;
  excitation.duration_ticks = 1000;
  excitation.travel_counts = 100'000;
  excitation.speed_limit_rad_s = 100.0F;
  excitation.torque_limit_nm = 1.0F;
  excitation.motor_command_nm = motor_nm;
  excitation.brake_command_nm = brake_nm;
  return excitation;
}

bool gives_nothing(const Shares& shares) {
  return shares.motor_command_nm == 0.0F && shares.brake_command_nm == 0.0F;
}

}  // namespace

TEST_CASE("an experiment ends one count behind its travel, on either side of where it began") {
  for (const int sign : {1, -1}) {
    Excitation excitation = wide(0.02F, 0.03F);
    excitation.travel_counts = 50;
    Bench bench(excitation, 500);
    bench.motion.position_counts = 500 + 50 * sign;
    CHECK(bench.tick().motor_command_nm == Approx(0.02));
    CHECK(bench.state.end == ExcitationEnd::none);
    bench.motion.position_counts += sign;
    CHECK(gives_nothing(bench.tick()));
    CHECK(bench.state.end == ExcitationEnd::out_of_bounds);
  }
}

TEST_CASE("an experiment ends above its speed, whichever way the knob turns") {
  for (const float sign : {1.0F, -1.0F}) {
    Bench bench(wide(0.02F));
    bench.motion.speed_rad_s = sign * 100.0F;
    CHECK(bench.tick().motor_command_nm == Approx(0.02));
    bench.motion.speed_rad_s = sign * 100.1F;
    CHECK(gives_nothing(bench.tick()));
    CHECK(bench.state.end == ExcitationEnd::out_of_bounds);
  }
}

TEST_CASE("an experiment ends when its servo pulls with all it may and the knob stands still") {
  Excitation excitation = wide(0.0F);
  excitation.servo_damping_nm_s_per_rad = 6e-3F;
  excitation.servo_rad_s = 80.0F;  // asks for 0.48 N m of a motor that gives 0.085
  excitation.still_ticks = 50;
  for (const std::int64_t border : {0, 1, -1}) {  // between two counts
    Bench bench(excitation);
    for (int n = 0; n < 50; ++n) {
      bench.motion.position_counts = n % 2 == 0 ? 0 : border;
      CHECK(bench.tick().motor_command_nm == 0.085F);
    }
    CHECK(gives_nothing(bench.tick()));
    CHECK(bench.state.end == ExcitationEnd::out_of_bounds);
  }
  // Two counts in 50 ticks are a knob that moves, either way, until it stands still elsewhere.
  for (const int way : {2, -2}) {
    Bench bench(excitation);
    for (int n = 0; n < 10; ++n) {
      bench.tick(50);
      bench.motion.position_counts += way;
    }
    CHECK(bench.state.end == ExcitationEnd::none);
    bench.tick(52);
    CHECK(bench.state.end == ExcitationEnd::out_of_bounds);
  }
}

TEST_CASE("a servo that is a spring alone ends as well when the knob does not follow") {
  Excitation excitation = wide(0.0F);
  excitation.servo_stiffness_nm_per_rad = 1.0F;
  excitation.servo_counts_q32 = std::int64_t{1} << 32;  // a count in a tick, 0.77 mN m more
  excitation.still_ticks = 50;
  Bench bench(excitation);
  bench.tick(111);  // 110 counts ask for 84.4 mN m, 111 for more than the 85 there are
  CHECK(bench.state.end == ExcitationEnd::none);
  bench.tick(50);
  CHECK(bench.state.end == ExcitationEnd::none);
  bench.tick();
  CHECK(bench.state.end == ExcitationEnd::out_of_bounds);
}

TEST_CASE("an experiment may hold a knob that stands still, without a servo or below its limit") {
  Excitation pull = wide(0.9F);  // is given 0.085
  pull.still_ticks = 50;
  Excitation servo = wide(0.0F);
  servo.servo_damping_nm_s_per_rad = 6e-3F;
  servo.servo_rad_s = 14.0F;  // asks for 0.084
  servo.still_ticks = 50;
  for (const Excitation& excitation : {pull, servo}) {
    Bench bench(excitation);
    bench.tick(500);
    CHECK(bench.state.end == ExcitationEnd::none);
  }
  // Earlier pulls in vain do not count.
  Bench bench(servo);
  for (int n = 0; n < 10; ++n) {
    bench.motion.speed_rad_s = -1.0F;  // asks for 0.09
    bench.tick(50);
    bench.motion.speed_rad_s = 0.0F;
    bench.tick();
  }
  CHECK(bench.state.end == ExcitationEnd::none);
}

TEST_CASE("an experiment lasts as many ticks as it was told, and its next one as many again") {
  Bench bench(wide(0.02F, 0.03F));
  CHECK(bench.tick(600).motor_command_nm == Approx(0.02));
  bench.begin(wide(0.03F, 0.03F));
  CHECK(bench.tick(1000).motor_command_nm == Approx(0.03));
  CHECK(bench.state.end == ExcitationEnd::none);
  CHECK(gives_nothing(bench.tick()));
  CHECK(bench.state.end == ExcitationEnd::over);
}

TEST_CASE("an experiment's torques hold at the lowest of all limits, and say so") {
  for (const float sign : {1.0F, -1.0F}) {
    for (const auto& [limit_nm, most_nm] : {std::pair{0.05F, 0.05F}, {0.5F, 0.085F}}) {
      Excitation excitation = wide(sign * 0.9F, 0.9F);
      excitation.torque_limit_nm = limit_nm;
      Bench bench(excitation);
      const Shares shares = bench.tick();
      CHECK(shares.motor_command_nm == sign * most_nm);
      CHECK(shares.motor_saturated);
      CHECK(shares.brake_command_nm == 0.110F);
      CHECK(shares.brake_saturated);
    }
    const Shares within = Bench(wide(sign * 0.084F, 0.109F)).tick();
    CHECK_FALSE(within.motor_saturated);
    CHECK_FALSE(within.brake_saturated);
  }
}

TEST_CASE("an experiment goes in a straight line from where the last one is, the first from zero") {
  Excitation up = wide(0.02F, 0.04F);
  up.ramp_ticks = 10;
  up.share_per_tick = 0.1F;
  Bench bench(up);
  for (int n = 0; n < 20; ++n) {
    const Shares shares = bench.tick();
    const double share = std::min(n / 10.0, 1.0);
    CHECK(static_cast<double>(shares.motor_command_nm) == Approx(0.02 * share).scale(0.02));
    CHECK(static_cast<double>(shares.brake_command_nm) == Approx(0.04 * share).scale(0.02));
  }
  Excitation down = up;
  down.motor_command_nm = -0.02F;
  down.brake_command_nm = 0.0F;
  bench.begin(down);
  for (int n = 0; n < 20; ++n) {
    const Shares shares = bench.tick();
    const double share = std::min(n / 10.0, 1.0);
    CHECK(static_cast<double>(shares.motor_command_nm) == Approx(0.02 - 0.04 * share).scale(0.02));
    CHECK(static_cast<double>(shares.brake_command_nm) == Approx(0.04 - 0.04 * share).scale(0.02));
  }
  bench.state.on = false;  // disarmed meanwhile
  bench.begin(up);
  CHECK(gives_nothing(bench.tick()));
  CHECK(static_cast<double>(bench.tick().motor_command_nm) == Approx(0.002));
}

TEST_CASE("a servo pulls towards where it began, within 2^14 counts, and goes on in the next one") {
  for (const int sign : {1, -1}) {
    Excitation servo = wide(0.0F);
    servo.servo_stiffness_nm_per_rad = 0.5F;
    servo.torque_limit_nm = 100.0F;
    Bench bench(servo, 1000);
    bench.limits.motor_torque_max_nm = 100.0F;
    bench.motion.position_counts = 1000 + 20 * sign;
    const double torque_nm = -0.5 * 20 * sign * static_cast<double>(kRadPerCount);
    CHECK(static_cast<double>(bench.tick().motor_command_nm) == Approx(torque_nm));
    bench.begin(servo);
    CHECK(static_cast<double>(bench.tick().motor_command_nm) == Approx(torque_nm));
    bench.motion.position_counts = 1000 + 90'000 * sign;
    CHECK(static_cast<double>(bench.tick().motor_command_nm) ==
          Approx(-0.5 * 16384 * sign * static_cast<double>(kRadPerCount)));
    // Behind one without a servo it begins anew.
    bench.begin(wide(0.0F));
    bench.begin(servo);
    CHECK(bench.tick().motor_command_nm == 0.0F);
  }
}
