/// @file The protocol's own rules, applied to the user's values before anything is sent.
#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/codec.hpp"
#include "protocol/registry.hpp"
#include "torsio/error.hpp"

namespace torsio {

/// "1.5", without zeros at the end; "not a number", "infinite".
/// @param digits the most that count; 0: as many as make it this very number again
std::string number_text(double value, int digits = 7);

/// Double to the float that travels; what no float can hold becomes infinite and is then refused.
float narrow(double value);

/// Angle to fixed-point turns of 2^-32, rounded to nearest.
/// @throws InvalidArgument "NAME is ..., allowed are ..."
std::int64_t turns_q32(std::string_view name, double angle_rad);

/// Seconds to nanoseconds.
/// @throws InvalidArgument unless 0 <= seconds <= 1e9
std::int64_t whole_ns(std::string_view name, double seconds);

/// Whole number to the type that travels.
/// @throws InvalidArgument if it is outside [min, max]
template <std::integral Wire>
Wire whole_number(std::string_view name, std::int64_t value, Wire min, Wire max) {
  if (value < static_cast<std::int64_t>(min) || value > static_cast<std::int64_t>(max)) {
    throw InvalidArgument(std::string(name) + " is " + std::to_string(value) + ", allowed are " +
                          std::to_string(min) + " to " + std::to_string(max));
  }
  return static_cast<Wire>(value);
}

/// A field that a rule of its own forbids, for the sentence that says so.
struct BadField {
  std::string_view name;
  std::string_view unit;
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
  bool is_number = false;
};

/// @throws InvalidArgument that names the field, its value and its range
[[noreturn]] void refuse(const BadField& field);

/// @throws InvalidArgument that names the field, its value and its range
template <class Report>
void check_fields(const Report& report) {
  const protocol::Verdict verdict = protocol::check(report);
  if (verdict.ok()) return;

  BadField bad;
  bad.name = protocol::field_name<Report>(verdict.field);
  std::uint8_t at = 0;
  const auto look = [&]<class Self, class S>(const Self& self, const S& structure) -> void {
    const auto one = [&](const auto& field) {
      const auto& value = structure.*field.member;
      using Value = std::remove_cvref_t<decltype(value)>;
      if constexpr (protocol::Structure<Value>) {
        self(self, value);
      } else if (at++ == verdict.field) {
        bad.unit = field.unit;
        bad.low = static_cast<double>(field.min);
        bad.high = static_cast<double>(field.max);
        bad.is_number = std::is_arithmetic_v<Value>;
        if constexpr (std::is_arithmetic_v<Value>) bad.value = static_cast<double>(value);
      }
    };
    protocol::Layout<S>::fields.apply([&](const auto&... field) { (one(field), ...); });
  };
  look(look, report);
  refuse(bad);
}

}  // namespace torsio
