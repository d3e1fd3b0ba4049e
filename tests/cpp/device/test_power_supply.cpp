// A board that measures its supply: when a voltage is wrong, and when only a reading is.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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
