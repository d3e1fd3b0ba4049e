// A detent is exactly 120 units: against a closed form in rational numbers, over the whole turn.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>

#include "device/dial/dial.hpp"

namespace {

using torsio::device::dial::units;

/// Flat within an eighth of a pitch of a notch, and a straight line from one flat to the next.
double closed_form(double pitches) {
  const double notch = std::round(pitches);
  const double away = std::abs(pitches - notch);
  const double part = away <= 0.125 ? 0.0 : 60.0 * (away - 0.125) / 0.375;
  return 120.0 * notch + (pitches < notch ? -part : part);
}

}  // namespace

TEST_CASE("units follow the closed form and never go back on the way forward") {
  for (const std::uint32_t counts_per_rev : {8192U, 4000U, 1'000'003U}) {
    for (const std::uint32_t detents : {1U, 24U, 31U, 240U}) {
      const std::int64_t turn = counts_per_rev;
      const std::int64_t step = counts_per_rev > 10'000 ? 97 : 1;
      std::int64_t last = units(-turn, counts_per_rev, detents);
      for (std::int64_t at = -turn; at <= turn; at += step) {
        const double pitches = static_cast<double>(at) * detents / counts_per_rev;
        const std::int64_t now = units(at, counts_per_rev, detents);
        REQUIRE(now >= last);
        // Cut off toward the notch, and halfway between two notches either of them is near.
        REQUIRE(std::abs(static_cast<double>(now) - closed_form(pitches)) <= 1.0);
        REQUIRE(now == -units(-at, counts_per_rev, detents));
        last = now;
      }
    }
  }
}

TEST_CASE("from any rest in one notch to any rest in another are 120 units a notch") {
  constexpr std::uint32_t kCounts = 8192;
  for (const std::uint32_t detents : {2U, 24U, 100U}) {
    const double pitch = static_cast<double>(kCounts) / detents;
    const auto off = static_cast<std::int64_t>(pitch / 8.0 - 1.0);
    for (int notch = -300; notch <= 300; ++notch) {
      const std::int64_t middle = std::llround(notch * pitch);
      for (const std::int64_t rest : {-off, std::int64_t{0}, off}) {
        REQUIRE(units(middle + rest, kCounts, detents) == 120 * notch);
      }
    }
  }
}

TEST_CASE("units are as exact a billion turns away") {
  constexpr std::int64_t kTurns = 1'000'000'000;
  for (std::int64_t at = 0; at < 8192; at += 13) {
    REQUIRE(units(at + kTurns * 8192, 8192, 24) - units(at, 8192, 24) == kTurns * 24 * 120);
    REQUIRE(units(at - kTurns * 8192, 8192, 24) - units(at, 8192, 24) == -kTurns * 24 * 120);
  }
}
