#include "conversion/field_check.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "conversion/turns.hpp"

namespace torsio {

std::string number_text(double value, int digits) {
  if (std::isnan(value)) return "not a number";
  if (std::isinf(value)) return value > 0 ? "infinite" : "minus infinite";
  std::array<char, 32> text;
  char* const begin = text.data();
  char* const limit = begin + text.size();
  return {begin,
          (digits == 0 ? std::to_chars(begin, limit, value)
                       : std::to_chars(begin, limit, value, std::chars_format::general, digits))
              .ptr};
}

float narrow(double value) {
  constexpr auto kLargest = static_cast<double>(std::numeric_limits<float>::max());
  if (std::abs(value) > kLargest) {
    return std::copysign(std::numeric_limits<float>::infinity(), value < 0 ? -1.0F : 1.0F);
  }
  return static_cast<float>(value);
}

namespace {

/// The error of a number; a number that nobody gave is NaN.
std::string is_text(double value) {
  return " is " + number_text(value) + (std::isnan(value) ? " (it must be given)" : "");
}

}  // namespace

std::int64_t turns_q32(std::string_view name, double angle_rad) {
  constexpr double kMaxRad =
      static_cast<double>(protocol::max_turns_q32) / 0x1p32 * conversion::kTurnRad.value;
  // The comparison is also false for NaN.
  if (!(std::abs(angle_rad) <= kMaxRad)) {
    const std::string limit = number_text(kMaxRad);
    throw InvalidArgument(std::string(name) + is_text(angle_rad) + ", allowed are -" + limit +
                          " to " + limit + " rad");
  }
  return conversion::quotient_q32({angle_rad}, conversion::kTurnRad);
}

std::int64_t whole_ns(std::string_view name, double seconds) {
  constexpr double kLongestS = 1e9;
  // The comparison is also false for NaN.
  if (!(seconds >= 0.0 && seconds <= kLongestS)) {
    throw InvalidArgument(std::string(name) + " is " + number_text(seconds) +
                          ", allowed are 0 to 1e9 s");
  }
  return std::llround(seconds * 1e9);
}

void refuse(const BadField& field) {
  std::string message(field.name);
  message += field.is_number ? is_text(field.value) : " has a value that is not allowed";
  message += ", allowed are " + number_text(field.low) + " to " + number_text(field.high);
  if (!field.unit.empty()) message += " " + std::string(field.unit);
  throw InvalidArgument(message);
}

}  // namespace torsio
