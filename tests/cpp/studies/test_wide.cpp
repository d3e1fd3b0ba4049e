// The controller in 64 bits beside the device's own.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "emulator/closed_loop.hpp"
#include "emulator/replay.hpp"
#include "wide/emulator/replay.hpp"

namespace protocol = torsio::protocol;
using torsio::LoopRow;
using namespace torsio::emulator;

TEST_CASE("controller in 64 bits decides as the device's but for rounding") {
  constexpr std::int64_t kMs = 1'000'000;
  for (const protocol::Law law : {protocol::Law::paper, protocol::Law::compensated}) {
    const ClosedLoopOptions options{
        .control = {.law = law},
        .hand = ImpedanceHand{1e-4, 1.0, 0.01,
                              Profile({{20 * kMs, 0.0}, {320 * kMs, 0.16}, {700 * kMs, 0.0}})},
        // 0.05 rad in turns of 2^-32.
        .scene = {protocol::Wall{
            .target = {}, .angle_turns_q32 = 34'178'000, .stiffness_nm_per_rad = 1.43F}}};
    ClosedLoop loop(options);
    std::vector<LoopRow> rows(800);
    loop.run(rows.size(), rows);
    std::vector<std::uint32_t> counts;
    for (const LoopRow& row : rows)
      counts.push_back(static_cast<std::uint32_t>(row.position_counts));
    std::vector<torsio::ReplayRow> single(rows.size());
    std::vector<torsio::ReplayRow> wide(rows.size());
    replay(options, counts, single);
    torsio::wide::emulator::replay(options, counts, wide);
    bool differs = false;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      REQUIRE(wide[i].position_counts == single[i].position_counts);
      // 1e-7 N m is 1/20,000 of the encoder's step.
      REQUIRE(std::abs(wide[i].motor_command_nm - single[i].motor_command_nm) < 1e-7);
      REQUIRE(std::abs(wide[i].brake_command_nm - single[i].brake_command_nm) < 1e-7);
      REQUIRE(std::abs(wide[i].spring_torque_nm - single[i].spring_torque_nm) < 1e-7);
      differs = differs || wide[i].motor_command_nm != single[i].motor_command_nm;
    }
    CHECK(differs);  // else it would not be another precision
  }
}
