// The device's report of the motor's current, against sums that are kept beside it.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>

#include "device/power_logic.hpp"
#include "rig.hpp"

using torsio::device::PowerDrive;
using torsio::device::PowerLogic;
using torsio::protocol::BoardConfig;
using torsio::protocol::MotorCurrent;
using torsio::protocol::Toggle;
using torsio::test::Rig;

TEST_CASE("a device that nobody measures the current of says so, and nothing else") {
  Rig rig;
  rig.tick(3);
  const auto told = rig.get<MotorCurrent>();
  CHECK(told.measured == Toggle::off);
  CHECK(told.position_counts == 0);
  CHECK(told.periods == 0);
  CHECK(told.a_per_step == 0.0F);
}

TEST_CASE("the sums are those of all periods, the bridge's share as it turns the knob") {
  for (const bool reversed : {false, true}) {
    BoardConfig config;
    config.motor_reversed = reversed ? Toggle::on : Toggle::off;
    PowerLogic power(config, {25'000, 20'000, true}, 0.06F);
    Rig rig;
    rig.device->measure_by(power);
    rig.tick(1);  // where it is is its zero
    rig.inputs.encoder_count += 5;
    rig.tick(1);
    std::int64_t readings = 0;
    std::int64_t shares = 0;
    std::int64_t last = 0;
    std::int64_t before = 0;
    for (int n = 0; n < 400; ++n) {
      const std::int32_t steps = 2048 + n % 7;
      readings += steps;
      const PowerDrive drive = power.step({n < 200 ? 0.02F : -0.04F, 0.0F, n >= 100}, steps);
      before = last;
      last = std::lround(std::trunc(drive.motor_share * (reversed ? -16384.0 : 16384.0)));
      shares += last;
    }
    const auto told = rig.get<MotorCurrent>();
    CHECK(told.measured == Toggle::on);
    CHECK(told.position_counts == 5);
    CHECK(told.period_ns == 25'000);
    CHECK(told.delay_ns == 20'000);
    CHECK(told.periods == 400);
    CHECK(told.reading_sum == readings);
    CHECK(told.reading == 2048 + 399 % 7);
    CHECK(shares < 0);  // most of the time it drove to smaller angles
    CHECK(told.share_sum == shares);
    CHECK(told.share == last);
    CHECK(told.share_before == before);
    // The sensor of 0.2 V/A on a converter of 12 bits over 3.3 V.
    CHECK(static_cast<double>(told.a_per_step) ==
          doctest::Approx((reversed ? -1.0 : 1.0) * 3.3 / 4096.0 / 0.2).epsilon(1e-6));
    CHECK(static_cast<double>(told.a_per_nm) == doctest::Approx(20.0));
    CHECK(static_cast<double>(told.zero) == doctest::Approx(2051.0).epsilon(1e-3));
  }
}
