/// @file
/// A game that sends a steady force anew in each of its frames sends points of a curve. They are
/// joined by lines, each as long as a frame, so half a frame late (docs/reference/games.md,
/// "Between updates").
#pragma once

#include <cstdint>

#include "core/slew_limit.hpp"

namespace torsio::device::game {

struct JoinedUpdates {
  std::uint64_t heard = 0;        // when the last update came, in the games' time; 0: none has
  std::uint64_t updated = 0;      // when the last one came that changed something
  std::uint32_t frame_ticks = 0;  // from one of these to the next; 0: not known yet
  float change_nm = 0;            // of this frame
  float change_before_nm = 0;     // of the frame before it
  core::Fade late{};              // the rest of the change, with the old value's sign

  /// An update has come.
  /// @returns whether it is the first for long
  bool hear(std::uint64_t now, std::uint32_t frame_max_ticks) {
    const bool first = heard == 0 || now - heard > frame_max_ticks;
    heard = now;
    return first;
  }

  /// The update stands for itself. The next one may be joined to it.
  void begin(std::uint64_t now) { *this = {.heard = heard, .updated = now}; }

  /// Joins an update to the one before it.
  /// @param change in N m
  /// @param hit_nm a change of more than this beyond the one before it is a hit
  /// @returns false for a hit, or when the frame is not known: the update stands for itself
  bool join(float change, std::uint64_t now, std::uint32_t frame_max_ticks, float hit_nm) {
    begin_frame(now, frame_max_ticks);
    change_nm += change;
    float usual_nm = hit_nm;
    if (change_nm * change_before_nm > 0.0F) usual_nm += core::absolute(change_before_nm);
    if (core::absolute(change_nm) > usual_nm || frame_ticks == 0) {
      late.nm = 0.0F;
      return false;
    }
    late.begin(late.nm - change, frame_ticks);
    return true;
  }

 private:
  /// Unless it is another report of the same update.
  void begin_frame(std::uint64_t now, std::uint32_t frame_max_ticks) {
    const std::uint64_t gap = now - updated;
    if (2 * gap < frame_ticks) return;
    const bool paused = gap > frame_max_ticks;
    updated = now;
    change_before_nm = paused ? 0.0F : change_nm;
    change_nm = 0.0F;
    if (paused) return;
    const auto frame = static_cast<std::uint32_t>(gap);
    frame_ticks = frame_ticks == 0 ? frame : (3 * frame_ticks + frame) / 4;
  }
};

}  // namespace torsio::device::game
