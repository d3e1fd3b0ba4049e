/// @file
/// A first order lag over one step of time, exact for a target that is held.
#pragma once

#include <cmath>

namespace torsio::studies {

struct Lag {
  double end = 0.0;   ///< exp(-h/tau)
  double mean = 0.0;  ///< of exp(-t/tau) over the step

  /// @param time_constant_s >= 0; 0 is no lag
  [[nodiscard]] static Lag over(double duration_s, double time_constant_s) {
    if (time_constant_s == 0.0) return {};
    const double ratio = duration_s / time_constant_s;
    return {std::exp(-ratio), -std::expm1(-ratio) / ratio};
  }
};

}  // namespace torsio::studies
