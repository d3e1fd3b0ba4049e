/// @file
/// A bound that goes a step at a time, and listens to the knob's swings.
#pragma once

#include "core/stiffness_bound.hpp"
#include "core/swings.hpp"

namespace torsio::core {

/// A bound of 0.01 N m for each count. Its scene follows time, so the second lasting swing brings
/// it down.
struct BoundBench {
  BoundState state;
  std::uint64_t now = 0;

  BoundBench() {
    state.params = {0.01F, 1.0F / 64, 40, 150};
    state.in_time_nm = 1e-3F;
    set_share(state, 1.0F);
  }
  double step(double asked_nm, std::int32_t delta_counts, double timed_nm = 0.0) {
    ++now;
    if (follow_swing(state, delta_counts)) judge_swing(state, now);
    return static_cast<double>(bound_stiffness(state, static_cast<float>(asked_nm),
                                               static_cast<float>(timed_nm), delta_counts));
  }
  /// Goes so far, a count in each tick.
  void swing(int counts, int sign) {
    for (int n = 0; n < counts; ++n) step(0.0, sign);
  }
};

}  // namespace torsio::core
