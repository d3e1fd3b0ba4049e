/// @file
/// Notices an encoder that cannot be trusted.
///
/// One channel is dead: the count goes one up and one down with each edge of the other, however far
/// the knob turns, so a wall would push for ever. A sound encoder does that too, when the knob
/// rests on the border of two counts and trembles. But a knob that trembles by itself does so at
/// random, and a wall or a texture shakes it slowly. Only a turning knob makes many such changes
/// that are both quick and even.
#pragma once

#include <cstdint>

namespace torsio::core {

// Counts up and down on end. Noise of any kind is not even for so long: 1e-14.
inline constexpr std::uint32_t kFlipsOfDeadChannel = 128;

// A knob that is shaken 1250 times a second moves by 8 urad at most, and a springy one does not
// buzz so fast. Turning at 4 rad/s passes two of 8192 counts in this time.
inline constexpr std::uint32_t kLongestFlipNs = 400'000;

struct EncoderWatch {
  std::uint32_t last_count = 0;
  std::int32_t last_delta = 0;  // that was not 0
  std::uint32_t ticks = 0;      // since then
  std::uint32_t last_ticks = 0;
  std::uint32_t flips = 0;
};

/// One tick.
/// @param longest_ticks  between two changes of the count that are quick; 0: it never says anything
/// @param encoder_count  now; wraps at 32 bits
/// @returns true when there have been so many that one channel must be dead; counting then begins
///          anew
constexpr bool finds_dead_channel(EncoderWatch& watch, std::uint32_t longest_ticks,
                                  std::uint32_t encoder_count) {
  ++watch.ticks;
  const auto delta = static_cast<std::int32_t>(encoder_count - watch.last_count);
  if (delta == 0) return false;
  const bool back = delta + watch.last_delta == 0 && (delta == 1 || delta == -1);
  const bool even = watch.ticks - watch.last_ticks + 1 <= 2;  // by one tick at most
  watch.flips = back && even && watch.ticks <= longest_ticks ? watch.flips + 1 : 0;
  watch.last_count = encoder_count;
  watch.last_delta = delta;
  watch.last_ticks = watch.ticks;
  watch.ticks = 0;
  if (watch.flips < kFlipsOfDeadChannel) return false;
  watch.flips = 0;
  return true;
}

// Each makes the count two steps wrong. A spark does that once, a loose plug again and again.
inline constexpr std::uint32_t kMostLostSteps = 4;
inline constexpr std::uint32_t kForgetLostNs = 1'000'000'000;

struct LostSteps {
  std::uint32_t steps = 0;
  std::uint32_t ticks = 0;  // since the last one
};

/// One tick, of changes of both channels at once.
/// @param forget_ticks without any, after which they do not count any more
/// @param lost         there was one since the last tick
/// @returns true when there have been so many that the plug must be loose; counting then begins
///          anew
constexpr bool finds_loose_plug(LostSteps& seen, std::uint32_t forget_ticks, bool lost) {
  if (!lost) {
    if (seen.ticks < forget_ticks) ++seen.ticks;
    return false;
  }
  seen.steps = seen.ticks < forget_ticks ? seen.steps + 1 : 1;
  seen.ticks = 0;
  if (seen.steps < kMostLostSteps) return false;
  seen.steps = 0;
  return true;
}

}  // namespace torsio::core
