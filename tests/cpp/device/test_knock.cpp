// A knock on the device: that the motor gives it with every law, and tells it. The effect itself is
// in test_impact.cpp.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "device/played.hpp"

using namespace torsio::protocol;
using doctest::Approx;
using torsio::test::at_once;
using torsio::test::Rig;

namespace {

constexpr int kSurfaceCounts = 40;
constexpr double kTickS = 1e-3;
constexpr double kSpeedRadS = 2.0 * std::numbers::pi / 8192 / kTickS;  // a count in a tick

/// Plays nothing but an impact at 40 counts; armed.
void begin(Rig& rig, const ControlConfig& config) {
  REQUIRE(rig.set(config).ok());
  Impact impact;
  impact.target = {1, 0, 0};
  impact.angle_turns_q32 = kSurfaceCounts * (std::int64_t{1} << 32) / 8192;
  impact.strength_nm_s_per_rad = 0.05F;
  impact.frequency_hz = 125.0F;
  impact.decay_s = 5e-3F;
  REQUIRE(rig.send_status(impact) == Status::ok);
  REQUIRE(rig.send_status(Commit{2, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(2);
}

/// The motor's command while the knob moves by a count in each tick.
std::vector<double> come_in(Rig& rig, int ticks) {
  std::vector<double> told_nm;
  for (int n = 0; n < ticks; ++n) {
    rig.inputs.encoder_count += 1;
    rig.tick();
    told_nm.push_back(static_cast<double>(rig.outputs.motor_command_nm));
  }
  return told_nm;
}

double expected_nm(int ticks) {
  const double time_s = ticks * kTickS;
  return -0.05 * kSpeedRadS * std::exp(-time_s / 5e-3) *
         std::sin(2.0 * std::numbers::pi * 125.0 * time_s);
}

}  // namespace

TEST_CASE("a knock is given by the motor with every law, and told as asked") {
  for (const Law law : {Law::paper, Law::compensated, Law::calibrated}) {
    CAPTURE(static_cast<int>(law));
    Rig rig;
    begin(rig, at_once(law));
    REQUIRE(rig.send_status(Stream{3, 0, 1}) == Status::ok);
    const std::vector<double> before_nm = come_in(rig, kSurfaceCounts);
    CHECK(std::ranges::all_of(before_nm, [](double told) { return std::abs(told) < 1e-3; }));
    rig.telemetry.clear();
    const std::vector<double> told_nm = come_in(rig, 12);
    for (int n = 0; n < 4; ++n)
      CHECK(told_nm[n] == Approx(expected_nm(n)).scale(0.02).epsilon(0.1));
    rig.tick(8);
    REQUIRE_FALSE(rig.telemetry.empty());
    const double step_nm = static_cast<double>(rig.get<Identity>().torque_step_nm);
    double least_asked_nm = 0.0;
    for (const Telemetry& report : rig.telemetry) {
      for (const auto& sample : report.sample) {
        least_asked_nm = std::min(least_asked_nm, sample.desired_torque * step_nm);
      }
    }
    // The first lobe, which pushes out of the solid, is the largest.
    CHECK(least_asked_nm == Approx(*std::ranges::min_element(told_nm)).scale(0).epsilon(0.02));
  }
}

TEST_CASE("a knock rises with a soft start") {
  Rig rig;
  ControlConfig config = at_once(Law::paper);
  config.passive_ramp_s = 0.1F;
  begin(rig, config);
  come_in(rig, kSurfaceCounts);
  // Two ticks, 40 and two more have passed of a hundred.
  CHECK(come_in(rig, 3)[2] == Approx(0.45 * expected_nm(2)).epsilon(0.1));
}

TEST_CASE("a knock ends where the device is disarmed, and does not go on when it is armed again") {
  Rig rig;
  begin(rig, at_once(Law::paper));
  come_in(rig, kSurfaceCounts);
  CHECK(std::abs(come_in(rig, 3)[2]) > 0.01);
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  CHECK(come_in(rig, 3)[2] == 0.0);
}
