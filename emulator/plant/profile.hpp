/// @file
/// Piecewise-linear functions of time, for the torques and paths of hands.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "torsio/plant.hpp"

namespace torsio::emulator {

/// One corner of a piecewise-linear function of time.
struct ProfileKnot {
  std::int64_t time_ns;
  double value;
};

/// The straight piece of a profile that holds on [begin_ns, end_ns).
struct ProfileSegment {
  std::int64_t begin_ns;
  std::int64_t end_ns;
  double begin_value;
  double slope_per_s;

  /// Value at `time_ns`, which the caller keeps within [begin_ns, end_ns]. At the end this is the
  /// limit from the left; where the profile jumps, its value differs.
  [[nodiscard]] double value(std::int64_t time_ns) const {
    // A flat piece has no finite begin; testing the slope first keeps the difference in range.
    if (slope_per_s == 0.0) return begin_value;
    return begin_value + slope_per_s * 1e-9 * static_cast<double>(time_ns - begin_ns);
  }
};

/// Piecewise-linear function of time; its first value holds before the first knot and its last
/// value after the last one. Two knots at the same time make a jump, and the later one holds there
/// (continuous from the right).
class Profile {
 public:
  static constexpr std::int64_t kForeverNs = std::numeric_limits<std::int64_t>::max();
  static constexpr std::int64_t kAlwaysNs = std::numeric_limits<std::int64_t>::min();

  /// @param knots at least one; times not decreasing, at most two at the same time; finite values
  /// @param name  of the field, for errors
  /// @throws std::invalid_argument that names the first knot which breaks this
  explicit Profile(std::vector<ProfileKnot> knots, std::string_view name = "profile");

  /// @param knots the user's, with times from start_ns on
  /// @throws std::invalid_argument as above, and if a time is not within -1e9 and 1e9 s
  Profile(const torsio::Profile& knots, std::int64_t start_ns, std::string_view name);

  /// The function that is `value` at all times.
  [[nodiscard]] static Profile constant(double value) { return Profile({{0, value}}); }

  [[nodiscard]] double value(std::int64_t time_ns) const;

  /// Derivative from the right, per second.
  [[nodiscard]] double slope_per_s(std::int64_t time_ns) const;

  /// Time of the first knot after `time_ns`, or kForeverNs.
  [[nodiscard]] std::int64_t next_knot_ns(std::int64_t time_ns) const;

  /// The straight piece in force at `time_ns`.
  [[nodiscard]] ProfileSegment segment(std::int64_t time_ns) const;

  /// True when no two knots share a time.
  [[nodiscard]] bool is_continuous() const;

  [[nodiscard]] const std::vector<ProfileKnot>& knots() const { return knots_; }

 private:
  std::vector<ProfileKnot> knots_;
};

}  // namespace torsio::emulator
