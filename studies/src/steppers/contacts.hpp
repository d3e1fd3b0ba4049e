/// @file
/// Set-valued dry friction on one or two shafts, solved for the forces that fit its law.
#pragma once

#include <algorithm>
#include <utility>

namespace torsio::studies {

/// Dry friction on a shaft: speed = free_speed + gain force. The force is the lowest there is while
/// the speed is positive, the highest while it is negative, and anything in between at rest.
struct Contact {
  double gain;  ///< > 0
  double free_speed;
  double lowest;   ///< <= 0
  double highest;  ///< >= 0
};

/// The force of a single contact: the one that stops it, or all that there is.
[[nodiscard]] inline double solve_contact(const Contact& contact) {
  const double stopping = -contact.free_speed / contact.gain;
  return std::clamp(stopping, contact.lowest, contact.highest);
}

/// Two contacts coupled by `cross`: speed_i = free_i + gain_i force_i + cross force_j. The gains
/// form a positive definite matrix, so exactly one pair of forces fits both laws. It is found by
/// trying what contact a may do: slip either way, with b answering it; if neither fits, a sticks.
[[nodiscard]] inline std::pair<double, double> solve_contacts(const Contact& a, const Contact& b,
                                                              double cross) {
  for (const double direction : {1.0, -1.0}) {
    const double force_a = direction > 0.0 ? a.lowest : a.highest;
    const double force_b =
        solve_contact({b.gain, b.free_speed + cross * force_a, b.lowest, b.highest});
    const double speed_a = a.free_speed + a.gain * force_a + cross * force_b;
    if (direction * speed_a > 0.0) return {force_a, force_b};
  }
  const double force_b =
      solve_contact({b.gain - cross * cross / a.gain, b.free_speed - cross * a.free_speed / a.gain,
                     b.lowest, b.highest});
  return {-(a.free_speed + cross * force_b) / a.gain, force_b};
}

}  // namespace torsio::studies
