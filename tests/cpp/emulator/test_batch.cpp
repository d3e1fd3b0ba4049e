// Many closed loops at once: the same as each alone, for any number of threads.
#include <doctest/doctest.h>

#include <cstring>
#include <stdexcept>
#include <vector>

#include "emulator/batch.hpp"

namespace torsio::emulator {
namespace {

std::vector<ClosedLoopOptions> kinds() {
  ClosedLoopOptions noisy;
  noisy.encoder.noise_counts = 0.7;
  noisy.hand = TorqueHand{Profile::constant(0.03)};
  ClosedLoopOptions rigid;
  rigid.plant.spring_and_brake = false;
  rigid.hand = TorqueHand{Profile::constant(-0.02)};
  rigid.delay_ticks = 2;
  return {noisy, rigid};
}

BatchOptions batch_options(std::size_t loops, unsigned threads) {
  BatchOptions options;
  options.kinds = kinds();
  options.threads = threads;
  for (std::size_t i = 0; i < loops; ++i) {
    options.kind_of.push_back(static_cast<std::uint32_t>(i % 2));
    options.seeds.push_back(100 + i);
  }
  return options;
}

bool same(const LoopRow& a, const LoopRow& b) {
  return a.time_s == b.time_s && a.angle_rad == b.angle_rad && a.speed_rad_s == b.speed_rad_s &&
         a.spring_torque_nm == b.spring_torque_nm && a.position_counts == b.position_counts &&
         a.motor_command_nm == b.motor_command_nm && a.brake_command_nm == b.brake_command_nm &&
         a.sensed_spring_torque_nm == b.sensed_spring_torque_nm;
}

TEST_CASE("a batch of loops does what each does alone") {
  for (const unsigned threads : {1U, 2U, 5U, 64U}) {
    Batch batch(batch_options(11, threads));
    batch.step(1200);  // each loop's are worth a thread
    batch.step(799);
    batch.step(1);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      ClosedLoopOptions options = kinds()[i % 2];
      options.encoder.seed = 100 + i;
      ClosedLoop alone(options);
      std::vector<LoopRow> rows(2001);
      alone.run(2001, rows);
      CHECK(same(batch.states()[i], rows[2000]));
    }
  }
}

TEST_CASE("a batch of loops names the first that fails and lets the others go on") {
  BatchOptions options = batch_options(9, 3);
  options.acts_hand = true;
  Batch batch(std::move(options));
  batch.actions()[7].hand_torque_nm = 1e9;
  batch.actions()[4].hand_torque_nm = 1e9;
  CHECK_THROWS_WITH_AS(batch.step(1), "loop 4: plant: hand_torque_nm must be within -100 and 100",
                       std::invalid_argument);
  CHECK(batch.states()[4].time_s == 0.0);
  CHECK(batch.states()[8].time_s == doctest::Approx(1e-3));
}

TEST_CASE("a copy of a closed loop goes its own way") {
  ClosedLoop first(kinds()[0]);
  first.run(50, {});
  ClosedLoop second = first;
  std::vector<LoopRow> a(30);
  std::vector<LoopRow> b(30);
  second.set_hand_torque(-0.05);
  second.run(30, b);
  first.run(30, a);
  CHECK(a[0].angle_rad == b[0].angle_rad);
  CHECK(a[29].angle_rad > b[29].angle_rad);
}

}  // namespace
}  // namespace torsio::emulator
