// Controller and plant without the protocol: the same as with it, tick by tick.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "emulator/closed_loop.hpp"
#include "emulator/emulated_device.hpp"
#include "emulator/replay.hpp"
#include "protocol/registry.hpp"

namespace protocol = torsio::protocol;
using torsio::LoopRow;
using torsio::SpinUp;
using namespace torsio::emulator;

namespace {

constexpr std::int64_t kMillisecondNs = 1'000'000;

/// A hand that waits for the device to be armed, pushes into the wall and comes out.
Hand pushing_hand() {
  return ImpedanceHand{.inertia_kg_m2 = 1e-4,
                       .stiffness_nm_per_rad = 1.0,
                       .damping_nm_s_per_rad = 0.01,
                       .intended_angle_rad = Profile({{20 * kMillisecondNs, 0.0},
                                                      {320 * kMillisecondNs, 0.16},
                                                      {400 * kMillisecondNs, 0.16},
                                                      {700 * kMillisecondNs, 0.0}})};
}

protocol::Wall soft_wall() {
  // 0.05 rad in turns of 2^-32.
  return {.target = {}, .angle_turns_q32 = 34'178'000, .stiffness_nm_per_rad = 1.43F};
}

std::vector<LoopRow> run(ClosedLoop& loop, std::size_t ticks) {
  std::vector<LoopRow> rows(ticks);
  loop.run(ticks, rows);
  return rows;
}

ClosedLoopOptions push_into_wall(std::int64_t period_ns, protocol::Law law) {
  return {.control_period_ns = period_ns,
          .control = {.law = law},
          .hand = pushing_hand(),
          .scene = {soft_wall()}};
}

std::string refusal(const ClosedLoopOptions& options) {
  try {
    const ClosedLoop loop(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("closed loop is the emulated device without its protocol") {
  for (const std::int64_t period_ns : {kMillisecondNs, kMillisecondNs / 10}) {
    for (const protocol::Law law : {protocol::Law::paper, protocol::Law::compensated}) {
      CAPTURE(period_ns);
      ClosedLoop loop(push_into_wall(period_ns, law));
      const auto ticks = static_cast<std::size_t>(800 * kMillisecondNs / period_ns);
      const std::vector<LoopRow> rows = run(loop, ticks);

      protocol::ControlConfig control{.law = law, .passive_ramp_s = 0.0F};
      control.autonomous = protocol::Toggle::on;
      EmulatedDevice device({.control_period_ns = period_ns,
                             .hand = pushing_hand(),
                             .given = {.control = control},
                             .log_truth = true});
      REQUIRE(device.write(protocol::encode(soft_wall())));
      REQUIRE(device.write(protocol::encode(protocol::Commit{1, 0, 1})));
      REQUIRE(device.write(protocol::encode(protocol::Command{2, 0, protocol::Op::arm})));
      device.advance(800 * kMillisecondNs);
      const std::vector<torsio::TruthSample> truth = device.take_truth();

      REQUIRE(truth.size() == rows.size());
      double deepest_rad = 0.0;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        REQUIRE(rows[i].angle_rad == truth[i].angle_rad);
        REQUIRE(rows[i].spring_torque_nm == truth[i].spring_torque_nm);
        REQUIRE(rows[i].motor_torque_nm == truth[i].motor_torque_nm);
        REQUIRE(rows[i].brake_capacity_nm == truth[i].brake_capacity_nm);
        deepest_rad = std::max(deepest_rad, rows[i].angle_rad);
      }
      CHECK(deepest_rad > 0.07);
    }
  }
}

TEST_CASE("closed loop does not depend on how a run is cut or how often it is recorded") {
  const ClosedLoopOptions options = push_into_wall(kMillisecondNs, protocol::Law::paper);
  ClosedLoop whole(options);
  ClosedLoop cut(options);
  ClosedLoop sparse(options);
  const std::vector<LoopRow> rows = run(whole, 600);
  (void)run(cut, 123);
  std::vector<LoopRow> every(60);
  sparse.run(600, every, 10);
  const std::vector<LoopRow> rest = run(cut, 477);
  for (std::size_t i = 0; i < rest.size(); ++i)
    REQUIRE(rest[i].angle_rad == rows[123 + i].angle_rad);
  for (std::size_t i = 0; i < every.size(); ++i)
    REQUIRE(every[i].angle_rad == rows[10 * i].angle_rad);
}

TEST_CASE("a spin-up ends at angle and time 0 with the speed that was asked") {
  for (const double direction : {1.0, -1.0}) {
    ClosedLoopOptions options;
    options.spin_up = SpinUp{.motor_command_nm = direction * 0.04, .speed_rad_s = 18.0};
    ClosedLoop loop(options);
    const LoopRow first = run(loop, 1).front();
    CHECK(first.time_s == 0.0);
    CHECK(first.angle_rad == 0.0);
    CHECK(first.position_counts == 0);
    CHECK(direction * first.speed_rad_s >= 18.0);
    CHECK(direction * first.speed_rad_s < 18.5);
    // The brake's shaft trails by the twist of its drag and inertia.
    CHECK(direction * (first.angle_rad - first.brake_angle_rad) > 0.0);
  }
  ClosedLoopOptions weak;
  weak.spin_up = SpinUp{.motor_command_nm = 0.004, .speed_rad_s = 18.0, .longest_s = 0.1};
  CHECK_THROWS_AS(ClosedLoop{weak}, std::runtime_error);
}

TEST_CASE("a delay of the commands shifts what the motor gives by so many ticks") {
  ClosedLoopOptions options;
  options.plant.motor_time_constant_s = 0.0;
  options.delay_ticks = 3;
  options.control.law = protocol::Law::motor_only;
  options.scene = {protocol::Constant{.target = {}, .torque_nm = 0.02F, .timing = {}}};
  ClosedLoop loop(options);
  const std::vector<LoopRow> rows = run(loop, 6);
  CHECK(rows[0].motor_command_nm == 0.02F);
  CHECK(rows[3].motor_torque_nm == 0.0);
  CHECK(rows[4].motor_torque_nm == doctest::Approx(0.02));
}

TEST_CASE("a held command is given to the actuators and known to the controller") {
  ClosedLoopOptions options;
  options.scene = {protocol::Constant{.target = {}, .torque_nm = 0.02F, .timing = {}}};
  ClosedLoop loop(options);
  loop.hold_command({.motor_command_nm = 0.01, .brake_command_nm = 0.1});
  const std::vector<LoopRow> held = run(loop, 500);
  CHECK(held.back().desired_torque_nm == 0.0F);
  CHECK(held.back().motor_torque_nm == doctest::Approx(0.01));
  CHECK(held.back().motor_command_nm == 0.01F);
  CHECK(held.back().brake_command_nm == 0.1F);
  CHECK(held.back().brake_capacity_nm == doctest::Approx(0.102).scale(0).epsilon(1e-3));
  CHECK(held.back().sensed_brake_capacity_nm == doctest::Approx(0.1).scale(0).epsilon(1e-3));
  loop.release_command();
  CHECK(run(loop, 1).front().desired_torque_nm == 0.02F);
}

TEST_CASE("what the law commands of the brake is in the rows, as the brake's model follows it") {
  ClosedLoop loop(push_into_wall(kMillisecondNs, protocol::Law::paper));
  const LoopRow pressed = run(loop, 390).back();  // held for 70 ms, several time constants
  CHECK(pressed.brake_command_nm > 0.02F);
  CHECK(pressed.brake_command_nm ==
        doctest::Approx(pressed.sensed_brake_capacity_nm).scale(0).epsilon(0.1));
}

TEST_CASE("closed loop refuses what is out of range by name") {
  ClosedLoopOptions options;
  options.control_period_ns = 999;
  CHECK(refusal(options).find("control_period_ns") != std::string::npos);
  options = {};
  options.control.beta = 1.5F;
  CHECK(refusal(options).find("beta") != std::string::npos);
  options = {};
  options.actuator.brake_torque_min_nm = 1.0F;
  CHECK(refusal(options).find("brake_torque_min_nm") != std::string::npos);
  options = {};
  options.scene = {protocol::Wall{.target = {}, .stiffness_nm_per_rad = -1.0F}};
  CHECK(refusal(options).find("wall: stiffness") != std::string::npos);
  options = {};
  options.scene.assign(17, soft_wall());
  CHECK(refusal(options).find("16 effects") != std::string::npos);
  options = {};
  options.plant.brake_inertia_kg_m2 = -1.0;
  CHECK(refusal(options).find("brake_inertia") != std::string::npos);
  options = {};
  options.delay_ticks = 1001;
  CHECK(refusal(options).find("delay_ticks") != std::string::npos);
}

TEST_CASE("replay decides as the closed loop did") {
  for (const protocol::Law law : {protocol::Law::paper, protocol::Law::compensated}) {
    const ClosedLoopOptions options = push_into_wall(kMillisecondNs, law);
    ClosedLoop loop(options);
    const std::vector<LoopRow> rows = run(loop, 800);
    std::vector<std::uint32_t> counts;
    for (const LoopRow& row : rows)
      counts.push_back(static_cast<std::uint32_t>(row.position_counts));
    std::vector<torsio::ReplayRow> single(rows.size());
    replay(options, counts, single);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      REQUIRE(single[i].motor_command_nm == static_cast<double>(rows[i].motor_command_nm));
      REQUIRE(single[i].spring_torque_nm == static_cast<double>(rows[i].sensed_spring_torque_nm));
    }
  }
}

// Against the truth of the plant, which the sensor does not see.
TEST_CASE("a sensor that knows how the shaft bends errs as on a straight one, whatever the law") {
  for (const double factor : {2.0, 0.5}) {
    for (const protocol::Law law :
         {protocol::Law::paper, protocol::Law::compensated, protocol::Law::calibrated}) {
      const auto error_nm = [&](bool bent, bool told) {
        ClosedLoopOptions options = push_into_wall(50'000, law);
        options.plant.counts_per_rev = 32'768;
        options.actuator.counts_per_rev = 32'768;
        options.encoder = encoder_of(options.plant);
        if (bent) options.plant.shaft_hardening = {.knee_rad = 0.005, .stiffness_factor = factor};
        if (told) {
          options.shaft.knee_1_rad = 0.005F;
          options.shaft.knee_1_nm_per_rad = 2.873F * static_cast<float>(factor);
        }
        ClosedLoop loop(options);
        double squares = 0.0;
        const std::vector<LoopRow> rows = run(loop, 16'000);
        for (const LoopRow& row : rows) {
          const double error =
              static_cast<double>(row.sensed_spring_torque_nm) - row.spring_torque_nm;
          squares += error * error;
        }
        return std::sqrt(squares / static_cast<double>(rows.size()));
      };
      const double straight_nm = error_nm(false, false);
      CAPTURE(factor);
      CAPTURE(straight_nm);
      CHECK(error_nm(true, true) < 1.2 * straight_nm + 1e-4);
      // The other laws err too, because they know less of the brake.
      const double much = law == protocol::Law::calibrated ? 4.0 : 1.3;
      CHECK(error_nm(true, false) > much * error_nm(true, true));
    }
  }
}
