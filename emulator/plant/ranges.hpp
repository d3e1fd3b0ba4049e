/// @file
/// Checks what the plant is given against the ranges of the field lists.
#pragma once

#include <string>
#include <string_view>
#include <type_traits>

#include "torsio/plant_fields.hpp"

namespace torsio::emulator {

/// @throws std::invalid_argument with name, value, range and unit, if the value is outside or not
///         finite
void require_within(double value, double low, double high, const std::string& name,
                    std::string_view unit);

template <class Struct>
void require_ranges(const Struct& given, const std::string& where);

/// One value: a number, several, a function of time, or a part of the plant that may be left out.
/// @param where what stands before the field's name in the message
template <class Value, class Field>
void require_range(const Value& value, const Field& field, const std::string& where) {
  const std::string name = where + std::string(field.name);
  const auto within = [&](double number) {
    require_within(number, field.low, field.high, name, field.unit);
  };
  if constexpr (std::is_same_v<Value, bool> || std::is_enum_v<Value>) {
    // Every value has a meaning.
  } else if constexpr (std::is_arithmetic_v<Value>) {
    within(static_cast<double>(value));
  } else if constexpr (requires { value.has_value(); }) {
    if (value) require_ranges(*value, name + ".");
  } else if constexpr (requires { value.knots(); }) {
    for (const auto& knot : value.knots()) within(knot.value);
  } else if constexpr (requires { value.front().value; }) {
    for (const auto& knot : value) within(knot.value);
  } else {
    for (const double number : value) within(number);
  }
}

/// Every number of a structure and of its parts.
template <class Struct>
void require_ranges(const Struct& given, const std::string& where) {
  Fields<Struct>::apply(
      [&](const auto&... field) { (require_range(given.*field.member, field, where), ...); });
}

/// A value that stands for a field of the user's structure, such as a path in the plant's time.
template <class Struct, class T, class Value>
void require_as(T Struct::* member, const Value& value, const std::string& where) {
  const auto one = [&](const auto& field) {
    if constexpr (std::is_same_v<decltype(field.member), T Struct::*>) {
      if (field.member == member) require_range(value, field, where);
    }
  };
  Fields<Struct>::apply([&](const auto&... field) { (one(field), ...); });
}

}  // namespace torsio::emulator
