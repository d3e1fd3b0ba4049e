/// @file
/// Whether somebody turns the knob, for a guest that wants the actuator while that is so.
#pragma once

#include <cstdint>

#include "device/guest.hpp"

namespace torsio::device {

class TurnWatch {
 public:
  explicit TurnWatch(std::uint32_t period_ns) : rest_ticks_(kRestNs / period_ns) {}

  /// @param origin_moved the position was set to zero, which is no turn
  /// @param felt there is something to feel; else it takes nothing
  /// @param holds it goes on although nobody turns
  Wish see(const Moment& now, bool origin_moved, bool felt, bool holds = false) {
    if (origin_moved) rested_counts_ = now.position_counts;
    const std::int64_t turned = now.position_counts - rested_counts_;
    if (turned >= kTurnedCounts || turned <= -kTurnedCounts) {
      rested_counts_ = now.position_counts;
      turned_tick_ = now.tick;
      turns_ = felt;
      return felt ? Wish::take : Wish::nothing_new;
    }
    if (!turns_ || (felt && holds) || now.tick - turned_tick_ <= rest_ticks_) {
      return Wish::nothing_new;
    }
    turns_ = false;
    return Wish::let_go;
  }

  /// Counts as a turn at this moment.
  void touch(std::uint64_t tick) {
    turned_tick_ = tick;
    turns_ = true;
  }

 private:
  // More than the flicker of an encoder that stands between two counts.
  static constexpr std::int64_t kTurnedCounts = 2;
  static constexpr std::uint32_t kRestNs = 1'000'000'000;

  std::int64_t rested_counts_ = 0;
  std::uint64_t turned_tick_ = 0;
  std::uint32_t rest_ticks_;
  bool turns_ = false;
};

}  // namespace torsio::device
