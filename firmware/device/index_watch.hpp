/// @file
/// Where the encoder's index is, a pulse once a turn.
#pragma once

#include <cstdint>
#include <limits>

namespace torsio::device {

/// A pulse is where its middle is, whichever way the knob passes it and however wide it is. Sparks
/// give pulses too, and a dirty disc two in a turn. So it is found by the first two on end that are
/// a turn apart. A tick that moves the count by more than one says too little about a flank.
struct IndexWatch {
  static constexpr std::int64_t kNearCounts = 2;
  enum class Known : std::uint8_t { nothing, pulse, place };

  bool awake = false;  // there is something to watch
  bool told = false;   // the level of this tick
  bool level = false;  // of the last tick
  bool flank = false;  // in the last tick
  bool entered = false;
  Known known = Known::nothing;
  std::int64_t from_counts = 0;    // the place before the last tick
  std::int64_t before_counts = 0;  // the last place before the pulse
  std::int64_t at_counts = 0;

  constexpr bool found() const { return known == Known::place; }

  /// In a tick that was told another level, and in the one after it, which knows how far the knob
  /// moved meanwhile.
  /// @param position_counts before this tick
  /// @returns whether the next tick must come here
  constexpr bool watch(std::int64_t position_counts, std::int64_t turn_counts) {
    if (flank) see(level, position_counts - from_counts, position_counts, turn_counts);
    flank = told != level;
    level = told;
    from_counts = position_counts;
    return flank;
  }

  /// The level has changed.
  /// @param delta_counts    in the tick that saw it
  /// @param position_counts after that tick
  constexpr void see(bool now, std::int64_t delta_counts, std::int64_t position_counts,
                     std::int64_t turn_counts) {
    if (found()) return;
    const bool slow = delta_counts >= -1 && delta_counts <= 1;
    if (now) {
      entered = slow;
      before_counts = position_counts - delta_counts;
      return;
    }
    // A knob that turns back leaves where it came in.
    if (!entered || !slow || position_counts == before_counts) return;
    const std::int64_t place = (before_counts + position_counts) >> 1;
    const std::int64_t away = place < at_counts ? at_counts - place : place - at_counts;
    const bool again = known == Known::pulse && away >= turn_counts - kNearCounts &&
                       away <= turn_counts + kNearCounts;
    known = again ? Known::place : Known::pulse;
    at_counts = place;
  }
};

/// A place of the index that is not known; others are within a turn.
inline constexpr std::int32_t kNoPlace = std::numeric_limits<std::int32_t>::max();

/// The place within a turn, from half a turn below 0 on.
constexpr std::int32_t within_turn(std::int64_t counts, std::int32_t turn_counts) {
  auto rest = static_cast<std::int32_t>(counts % turn_counts);
  if (2 * rest >= turn_counts) rest -= turn_counts;
  if (2 * rest < -turn_counts) rest += turn_counts;
  return rest;
}

}  // namespace torsio::device
