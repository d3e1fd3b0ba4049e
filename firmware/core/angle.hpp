/// @file
/// Angles that stay exact however far the knob has turned. Positions are integer counts. Reference
/// angles are counts plus a fraction. Phases of periodic effects are 64-bit fractions that wrap by
/// themselves. Only differences become floating point.
#pragma once

#include <cstdint>

#include "core/math.hpp"

namespace torsio::core {

/// Sizes of the encoder's count and of the control period.
struct Resolution {
  std::uint32_t counts_per_rev = 0;
  float rad_per_count = 0;
  float period_s = 0;
};

constexpr Resolution make_resolution(std::uint32_t counts_per_rev, std::uint32_t period_ns) {
  return {counts_per_rev, kTwoPi / static_cast<float>(counts_per_rev),
          static_cast<float>(period_ns) * 1e-9F};
}

/// A reference angle: counts + fraction / 2^32 counts.
struct Origin {
  std::int64_t counts = 0;
  std::uint32_t fraction_q32 = 0;
  float fraction = 0;  // the same, to the 24 bits that a tick needs

  friend bool operator==(const Origin&, const Origin&) = default;
};

/// The origin at an angle in 2^-32 turns. Exact.
constexpr Origin make_origin(std::int64_t angle_turns_q32, std::uint32_t counts_per_rev) {
  const std::int64_t turns = angle_turns_q32 >> 32;
  const std::uint64_t part =
      static_cast<std::uint64_t>(static_cast<std::uint32_t>(angle_turns_q32)) * counts_per_rev;
  return {turns * static_cast<std::int64_t>(counts_per_rev) + static_cast<std::int64_t>(part >> 32),
          static_cast<std::uint32_t>(part),
          static_cast<float>(static_cast<std::uint32_t>(part) >> 8) * 0x1p-24F};
}

/// Angle from an origin to a position, rad. The difference is taken in integers; further away than
/// 2^30 counts it holds.
constexpr float offset_rad(std::int64_t position_counts, const Origin& origin,
                           float rad_per_count) {
  constexpr std::int32_t limit = std::int32_t{1} << 30;
  const std::int64_t difference = position_counts - origin.counts;
  // Compared in 32 bits and both ways at once: nearly every difference fits.
  auto near = static_cast<std::int32_t>(difference);
  if (difference != near || static_cast<std::uint32_t>(near) + limit > 2U * limit) [[unlikely]] {
    near = difference < 0 ? -limit : limit;
  }
  return (static_cast<float>(near) - origin.fraction) * rad_per_count;
}

/// A pattern that repeats along the angle.
struct Pattern {
  Origin origin;
  std::uint64_t cycles_per_count_q64 = 0;
  std::uint64_t shift_q64 = 0;  // phase of the origin's fraction of a count
};

/// @param per_turn_q32 repetitions in a turn, times 2^32; less than one in a count
constexpr Pattern make_pattern(std::int64_t angle_turns_q32, std::uint64_t per_turn_q32,
                               std::uint32_t counts_per_rev) {
  Pattern pattern{make_origin(angle_turns_q32, counts_per_rev)};
  const std::uint64_t whole = per_turn_q32 / counts_per_rev;
  const std::uint64_t rest = per_turn_q32 % counts_per_rev;
  pattern.cycles_per_count_q64 = (whole << 32) + (rest << 32) / counts_per_rev;
  pattern.shift_q64 = (pattern.cycles_per_count_q64 >> 32) * pattern.origin.fraction_q32;
  return pattern;
}

/// 2^96 / divisor, for 2^32 < divisor <= 2^63, by long division: prepares patterns that are given
/// by their length.
constexpr std::uint64_t divide_2_96(std::uint64_t divisor) {
  std::uint64_t remainder = std::uint64_t{1} << 32;  // 2^32 < divisor: the first digits are zeros
  std::uint64_t quotient = 0;
  for (int i = 0; i < 64; ++i) {
    remainder <<= 1;
    quotient <<= 1;
    if (remainder >= divisor) {
      remainder -= divisor;
      quotient |= 1;
    }
  }
  return quotient;
}

/// A pattern given by its length.
/// @param span_turns_q32 length of a repetition in 2^-32 turns; longer than a count, with
///                       span_turns_q32 * counts_per_rev <= 2^63
constexpr Pattern make_pattern_of_span(std::int64_t angle_turns_q32, std::uint64_t span_turns_q32,
                                       std::uint32_t counts_per_rev) {
  Pattern pattern{make_origin(angle_turns_q32, counts_per_rev)};
  pattern.cycles_per_count_q64 = divide_2_96(span_turns_q32 * counts_per_rev);
  pattern.shift_q64 = (pattern.cycles_per_count_q64 >> 32) * pattern.origin.fraction_q32;
  return pattern;
}

/// Where in the pattern a position is: 0 to 2^32 is one repetition. Exact modulo any number of
/// turns: the product is taken modulo 2^64.
constexpr std::uint32_t pattern_phase(std::int64_t position_counts, const Pattern& pattern) {
  const std::uint64_t difference =
      static_cast<std::uint64_t>(position_counts - pattern.origin.counts);
  return static_cast<std::uint32_t>(
      (difference * pattern.cycles_per_count_q64 - pattern.shift_q64) >> 32);
}

}  // namespace torsio::core
