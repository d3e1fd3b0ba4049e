// The counts alone tell an encoder with a dead channel from a sound one: quick and
// even changes up and down. One with a loose plug by changes of both channels at once.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <random>

#include "core/encoder_watch.hpp"

using namespace torsio::core;

namespace {

/// The knob's angle, as a decoder of four counts a line reads it.
class Encoder {
 public:
  Encoder(double counts_per_rev, bool dead)
      : counts_per_rad_(counts_per_rev / 2 / std::numbers::pi), dead_(dead) {}

  std::uint32_t count(double angle_rad) const {
    const auto counts = static_cast<std::int64_t>(std::floor(angle_rad * counts_per_rad_));
    // With one live channel each level is two counts long, and one of them counts as 1.
    return static_cast<std::uint32_t>(dead_ ? (counts >> 1) & 1 : counts);
  }

 private:
  double counts_per_rad_;
  bool dead_;
};

struct Board {
  double period_s;
  std::uint32_t longest_ticks;  // 0.4 ms
};

constexpr Board kFast{50e-6, 8};
constexpr Board kSlow{100e-6, 4};

/// Moves a knob so: angle_rad(time_s).
/// @returns when the channel was found dead, in s; negative: never
template <class Path>
double find(const Board& board, double counts_per_rev, bool dead, double time_s,
            const Path& angle_rad) {
  const Encoder encoder(counts_per_rev, dead);
  EncoderWatch watch;
  const auto ticks = static_cast<int>(time_s / board.period_s);
  for (int tick = 0; tick < ticks; ++tick) {
    const double now_s = tick * board.period_s;
    if (finds_dead_channel(watch, board.longest_ticks, encoder.count(angle_rad(now_s)))) {
      return now_s;
    }
  }
  return -1.0;
}

}  // namespace

TEST_CASE("a knob that runs away on one channel is found out within a fifth of a radian and some") {
  for (const Board& board : {kFast, kSlow}) {
    for (const double counts : {4096.0, 8192.0, 16384.0, 32768.0}) {
      // Two counts in less than two thirds of a tick are not even any more.
      if (counts > 16384.0 && board.period_s > 50e-6) continue;
      for (const double acceleration : {100.0, 315.0, 480.0, -315.0}) {
        CAPTURE(board.period_s);
        CAPTURE(counts);
        CAPTURE(acceleration);
        const auto path = [&](double now_s) { return 0.5 * acceleration * now_s * now_s; };
        const double found_s = find(board, counts, true, 1.0, path);
        REQUIRE(found_s > 0.0);
        // 128 changes are 256 counts; before that, 0.4 ms for two counts is reached.
        const double count_rad = 2 * std::numbers::pi / counts;
        const double quick_rad_s = 2 * count_rad / 0.4e-3;
        const double least_rad = quick_rad_s * quick_rad_s / 2 / std::abs(acceleration);
        CHECK(std::abs(path(found_s)) < 1.3 * (least_rad + 256 * count_rad));
        CHECK(find(board, counts, false, 1.0, path) < 0.0);
      }
    }
  }
}

TEST_CASE("a knob that a hand turns evenly is found out after 256 counts") {
  for (const double speed : {5.0, -5.0, 9.0, 14.0}) {
    const auto path = [&](double now_s) { return speed * now_s; };
    const double found_s = find(kFast, 8192.0, true, 1.0, path);
    CAPTURE(speed);
    REQUIRE(found_s > 0.0);
    CHECK(std::abs(path(found_s)) * 8192 / 2 / std::numbers::pi ==
          doctest::Approx(258).epsilon(0.02));
    CHECK(find(kFast, 8192.0, false, 1.0, path) < 0.0);
  }
}

TEST_CASE("a knob that rests on a border of two counts may be noisy for hours") {
  // At the border, with noise on the angle: white noise, then noise with a memory.
  for (const Board& board : {kFast, kSlow}) {
    for (const double memory : {0.0, 0.5, 0.9}) {
      for (const double border : {0.0, 0.5, 1.5}) {
        std::mt19937 random(7);
        std::normal_distribution<double> normal;
        EncoderWatch watch;
        double noise = 0.0;
        bool found = false;
        for (int tick = 0; tick < 1'000'000; ++tick) {
          noise = memory * noise + normal(random);
          const std::uint32_t count = noise > border ? 1 : 0;
          found |= finds_dead_channel(watch, board.longest_ticks, count);
        }
        CAPTURE(memory);
        CAPTURE(border);
        CHECK_FALSE(found);
      }
    }
  }
}

TEST_CASE("a knob that is shaken across a border is sound, up to 1 kHz and 20 counts") {
  const double count_rad = 2 * std::numbers::pi / 8192;
  for (const Board& board : {kFast, kSlow}) {
    for (double hertz = 20.0; hertz < 1000.0; hertz *= 1.07) {
      for (const double counts : {0.01, 0.9, 1.1, 3.0, 20.0}) {
        for (const double middle : {0.0, 0.4}) {
          const auto path = [&](double now_s) {
            const double phase = 2 * std::numbers::pi * hertz * now_s;
            return count_rad * (1.0 + counts * (middle + std::sin(phase)));
          };
          CAPTURE(hertz);
          CAPTURE(counts);
          CHECK(find(board, 8192.0, false, 0.3, path) < 0.0);
        }
      }
    }
  }
}

TEST_CASE("only changes to and fro between two counts count, quick, even, and on end") {
  const auto found_after = [](std::initializer_list<std::int32_t> deltas, int times) {
    EncoderWatch watch;
    std::uint32_t count = 0;
    for (int n = 0; n < times; ++n) {
      for (const std::int32_t delta : deltas) {
        count += static_cast<std::uint32_t>(delta);
        if (finds_dead_channel(watch, 4, count)) return n + 1;
      }
    }
    return -1;
  };
  // The first change of all turns nothing back.
  CHECK(found_after({0, 1, 0, -1}, 200) == 65);
  CHECK(found_after({0, 0, 0, 1, 0, 0, 0, -1}, 200) == 65);
  CHECK(found_after({0, 0, 0, 0, 1, 0, 0, 0, 0, -1}, 200) == -1);  // slow
  CHECK(found_after({0, 1, 0, 0, 0, -1}, 200) == -1);              // uneven
  CHECK(found_after({1, 0, 0, -1, 1, 0, 0, -1}, 200) == -1);       // uneven, too
  CHECK(found_after({0, 1, 0, 0, -1}, 200) == 65);                 // even enough
  CHECK(found_after({0, 2, 0, -2}, 200) == -1);                    // a knob that swings
  CHECK(found_after({0, 1, 0, 1, 0, -1, 0, -1}, 200) == -1);
  // Once told it begins anew, so that the fault can be cleared after a repair.
  EncoderWatch watch;
  int told = 0;
  for (int n = 0; n < 3 * 128 + 10; ++n) {
    if (finds_dead_channel(watch, 4, n % 2 == 0 ? 1U : 0U)) ++told;
  }
  CHECK(told == 3);
}

TEST_CASE("four changes of both channels at once are a loose plug unless a second lies between") {
  constexpr std::uint32_t kSecond = 10'000;
  // Ticks without one before each; after which of them the plug is found loose.
  const auto found_at = [](std::initializer_list<std::uint32_t> pauses) {
    LostSteps seen;
    int number = 0;
    for (const std::uint32_t pause : pauses) {
      for (std::uint32_t tick = 0; tick < pause; ++tick) {
        CHECK_FALSE(finds_loose_plug(seen, kSecond, false));
      }
      ++number;
      if (finds_loose_plug(seen, kSecond, true)) return number;
    }
    return -1;
  };
  CHECK(found_at({0, 0, 0, 0}) == 4);
  CHECK(found_at({0, 0, 0}) == -1);
  CHECK(found_at({500'000, 9'999, 9'999, 9'999}) == 4);
  CHECK(found_at({0, 9'999, 9'999, 10'000, 9'999, 9'999, 9'999}) == 7);
  CHECK(found_at({10'000, 10'000, 10'000, 10'000, 10'000, 10'000}) == -1);
  // Once told it begins anew.
  LostSteps seen;
  int told = 0;
  for (int n = 0; n < 11; ++n) {
    if (finds_loose_plug(seen, kSecond, true)) ++told;
  }
  CHECK(told == 2);
}
