// Impact gives back no more energy than it has taken. The oracles are energies of the plant.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "emulator/closed_loop.hpp"

namespace {

using torsio::LoopRow;
using torsio::emulator::ClosedLoop;
using torsio::emulator::ClosedLoopOptions;
namespace protocol = torsio::protocol;
namespace emulator = torsio::emulator;

constexpr double kBeforeRad = -0.02;
constexpr auto kFlightTurnsQ32 =
    static_cast<std::int64_t>(-kBeforeRad / (2.0 * std::numbers::pi) * 0x1p32);
constexpr std::uint32_t kFineCounts = 32'768;
constexpr double kFineCountRad = 2.0 * std::numbers::pi / kFineCounts;
constexpr std::uint32_t kCoarseCounts = 2048;

/// The rates at which it holds; doctest runs a case once for each.
std::uint32_t period_ns() {
  std::uint32_t period = 0;
  SUBCASE("at 10 kHz") { period = 100'000; }
  SUBCASE("at 20 kHz") { period = 50'000; }
  return period;
}

/// A motor's lag, and what the device is told of it.
struct Lag {
  std::uint32_t period_ns = 50'000;
  double lag_s = 0.0;
  double told = 1.0;  // of the lag
  bool winding = false;
  std::uint32_t counts = kFineCounts;
};

Lag lag() {
  Lag motor;
  SUBCASE("none at 20 kHz") { motor = {50'000}; }
  SUBCASE("none at 10 kHz") { motor = {100'000}; }
  SUBCASE("none at 4 kHz") { motor = {250'000}; }
  SUBCASE("of 44 us at 20 kHz") { motor = {50'000, 44e-6}; }
  SUBCASE("of 44 us at 10 kHz, told too short") { motor = {100'000, 44e-6, 0.7}; }
  SUBCASE("of 160 us at 10 kHz") { motor = {100'000, 160e-6}; }
  SUBCASE("of 160 us at 20 kHz, told too short") { motor = {50'000, 160e-6, 0.7}; }
  SUBCASE("of 160 us at 20 kHz, told too long") { motor = {50'000, 160e-6, 1.3}; }
  SUBCASE("of 160 us at 4 kHz, told too short") { motor = {250'000, 160e-6, 0.7}; }
  SUBCASE("none at 20 kHz, with 2,048 counts") {
    motor = {.period_ns = 50'000, .counts = kCoarseCounts};
  }
  SUBCASE("of 160 us at 4 kHz, told too short, with 2,048 counts") {
    motor = {250'000, 160e-6, 0.7, false, kCoarseCounts};
  }
  SUBCASE("of a winding that is slower at its supply's limit") {
    motor = {50'000, 44e-6, 1.0, true};
  }
  return motor;
}

double seconds(std::uint32_t period) { return 1e-9 * period; }

/// A knob whose motor has no lag comes to an Impact at this speed, on a hand's spring.
ClosedLoopOptions comes_to_impact(std::uint32_t period, double speed_rad_s, double hand_nm_per_rad,
                                  float strength, float frequency_hz,
                                  std::uint32_t counts = kFineCounts) {
  ClosedLoopOptions options;
  options.control_period_ns = period;
  options.control.law = protocol::Law::motor_only;
  options.actuator.counts_per_rev = options.encoder.counts_per_rev = counts;
  options.plant.counts_per_rev = counts;
  options.plant.motor_time_constant_s = 0.0;
  options.actuator.motor_time_constant_s = 0.0F;
  protocol::Impact impact;
  impact.strength_nm_s_per_rad = impact.pulse_nm_s_per_rad = strength;
  impact.frequency_hz = frequency_hz;
  impact.angle_turns_q32 = kFlightTurnsQ32;
  impact.decay_s = 0.1F;
  impact.pulse_s = 0.05F;
  options.scene.emplace_back(impact);
  emulator::ImpedanceHand hand;
  hand.stiffness_nm_per_rad = hand_nm_per_rad;
  hand.intended_angle_rad = emulator::Profile::constant(0.0);
  options.hand = hand;
  emulator::PlantState state;
  state.knob_angle = emulator::Angle::from_rad(kBeforeRad);
  state.speed_rad_s = {speed_rad_s, speed_rad_s, 0.0};
  options.initial = state;
  return options;
}

std::vector<LoopRow> rows_of(const ClosedLoopOptions& options) {
  ClosedLoop loop(options);
  std::vector<LoopRow> rows(200'000'000 / options.control_period_ns);
  loop.run(rows.size(), rows);
  return rows;
}

/// Counts leave open where in a count the knob was at each change of torque, and how far it moved
/// in a tick.
double open_energy_j(double changes_nm, double torque_nm, double moved_rad,
                     double count_rad = kFineCountRad) {
  return changes_nm * count_rad + std::abs(torque_nm * moved_rad);
}

// The oracle is the plant's energy: of all that moves, of the shaft's spring and of the hand's.
TEST_CASE("impact_gives_no_energy_to_a_knob_that_bounces_without_friction") {
  const Lag motor = lag();
  const std::uint32_t period = motor.period_ns;
  double most_taken = 0.0;
  for (const double hand_nm_per_rad : {0.5, 5.0, 40.0}) {
    for (const double speed : {0.5, 3.0, 15.0}) {
      for (const float strength : {0.003F, 0.03F, 0.3F}) {
        for (const float frequency_hz : {10.0F, 60.0F, 300.0F}) {
          CAPTURE(hand_nm_per_rad);
          CAPTURE(speed);
          CAPTURE(strength);
          CAPTURE(frequency_hz);
          ClosedLoopOptions options =
              comes_to_impact(period, speed, hand_nm_per_rad, strength, frequency_hz, motor.counts);
          emulator::PlantParams& plant = options.plant;
          plant.motor_time_constant_s = motor.lag_s;
          options.actuator.motor_time_constant_s = static_cast<float>(motor.told * motor.lag_s);
          if (motor.winding) plant.electrics = torsio::Electrics{};
          plant.knob_coulomb_nm = plant.knob_viscous_nm_s_per_rad = 0.0;
          plant.shaft_damping_nm_s_per_rad = 0.0;
          plant.brake_viscous_nm_s_per_rad = plant.brake_drag_nm = 0.0;
          const std::vector<LoopRow> rows = rows_of(options);

          const auto energy_j = [&](const LoopRow& row) {
            const double twist_rad = row.angle_rad - row.brake_angle_rad;
            return 0.5 *
                   (plant.knob_inertia_kg_m2 * row.speed_rad_s * row.speed_rad_s +
                    plant.brake_inertia_kg_m2 * row.brake_speed_rad_s * row.brake_speed_rad_s +
                    plant.shaft_stiffness_nm_per_rad * twist_rad * twist_rad +
                    hand_nm_per_rad * row.angle_rad * row.angle_rad);
          };
          double most_nm = 0.0;
          double last_nm = 0.0;
          const double before_j = energy_j(rows.front());
          double lowest_j = before_j;
          double worst_j = -1.0;
          for (const LoopRow& row : rows) {
            const double open_j =
                open_energy_j(2.0 * most_nm, last_nm, row.speed_rad_s * seconds(period),
                              2.0 * std::numbers::pi / motor.counts);
            worst_j = std::max(worst_j, energy_j(row) - before_j - open_j);
            lowest_j = std::min(lowest_j, energy_j(row));
            last_nm = static_cast<double>(row.motor_command_nm);
            most_nm = std::max(most_nm, std::abs(last_nm));
          }
          CHECK(worst_j <= 1e-3 * before_j + (motor.winding ? 1.3e-4 : 0.0));
          most_taken = std::max(most_taken, 1.0 - lowest_j / before_j);
        }
      }
    }
  }
  CHECK(most_taken > 0.3);  // and it has had a say in the motion
}

// The oracle is the motor's true work beyond the wall, computed from counts and the motor's limits.
// Wall and knock together ask for more than the motor has.
TEST_CASE("impact_beside_a_wall_gives_no_energy_where_the_motor_saturates") {
  constexpr double kMotorNm = 85e-3;
  const std::uint32_t period = period_ns();
  double most_taken_j = 0.0;
  int saturated = 0;
  int untold = 0;
  for (const double stiffness : {0.5, 5.0, 100.0, 1e6}) {
    for (const double speed : {0.5, 3.0, 15.0}) {
      for (const float strength : {0.003F, 0.03F, 3.0F}) {
        for (const float frequency_hz : {10.0F, 300.0F}) {
          for (const double slew_nm_per_s : {0.0, 100.0}) {
            CAPTURE(stiffness);
            CAPTURE(speed);
            CAPTURE(strength);
            CAPTURE(frequency_hz);
            CAPTURE(slew_nm_per_s);
            ClosedLoopOptions options = comes_to_impact(period, speed, 5.0, strength, frequency_hz);
            options.control.motor_slew_nm_per_s = static_cast<float>(slew_nm_per_s);
            protocol::Wall wall;
            wall.side = protocol::Side::above;
            wall.stiffness_nm_per_rad = static_cast<float>(stiffness);
            wall.angle_turns_q32 = kFlightTurnsQ32;
            options.scene.emplace_back(wall);
            const std::vector<LoopRow> rows = rows_of(options);

            const double step_nm = slew_nm_per_s > 0.0 ? slew_nm_per_s * seconds(period) : 1.0;
            double before_nm = 0.0;
            double knock_nm = 0.0;
            double most_nm = 0.0;
            double changes_nm = 0.0;
            double work_j = 0.0;
            double worst_j = -1.0;
            for (std::size_t i = 1; i < rows.size(); ++i) {
              const LoopRow& row = rows[i - 1];
              const double moved_rad = rows[i].angle_rad - row.angle_rad;
              // Counted from the first sample, as the scene's angles are.
              const double depth_rad =
                  static_cast<double>(row.position_counts) * kFineCountRad + kBeforeRad;
              const double asked_nm = -std::max(0.0, stiffness * depth_rad);
              const double wall_nm = std::clamp(asked_nm, std::max(-kMotorNm, before_nm - step_nm),
                                                std::min(kMotorNm, before_nm + step_nm));
              const auto told_nm = static_cast<double>(row.motor_command_nm);
              if (asked_nm <= -kMotorNm) ++saturated;
              // A knock that takes the rest of the motor is told as a wall's that does.
              const bool all = std::abs(row.motor_command_nm) >= static_cast<float>(kMotorNm);
              if (asked_nm > -kMotorNm && row.motor_saturated != all) ++untold;
              changes_nm += std::abs(told_nm - wall_nm - knock_nm);
              knock_nm = told_nm - wall_nm;
              most_nm = std::max(most_nm, std::abs(knock_nm));
              work_j += knock_nm * moved_rad;
              // With a slew the torque does not end at once: then the test is a coarse one.
              const double open_nm = slew_nm_per_s > 0.0 ? most_nm + changes_nm : 2.0 * most_nm;
              worst_j = std::max(worst_j, work_j - open_energy_j(open_nm, knock_nm, moved_rad));
              most_taken_j = std::max(most_taken_j, -work_j);
              before_nm = told_nm;
            }
            CHECK(worst_j <= 1e-7);
          }
        }
      }
    }
  }
  CHECK(most_taken_j > 1e-3);
  CHECK(saturated > 1000);
  CHECK(untold == 0);
}

}  // namespace
