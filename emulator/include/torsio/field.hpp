/// @file
/// Parts of `fields.hpp`: one field of a structure, and the templates that list them.
#pragma once

#include <limits>
#include <string_view>

namespace torsio {

/// One field: `structure.*field.member` is its value. Every number in it is within [low, high],
/// both included and in `unit`; further rules are in its sentence.
template <class Struct, class T>
struct Field {
  using Value = T;

  std::string_view name;
  T Struct::* member;
  std::string_view unit;
  double low;
  double high;
  std::string_view doc;
};

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();

template <class Struct, class T>
constexpr Field<Struct, T> field(std::string_view name, T Struct::* member, std::string_view unit,
                                 double low, double high, std::string_view doc) {
  return {name, member, unit, low, high, doc};
}

/// `name` of a structure, and `apply(visit)`, which returns visit(field...) of all its fields.
/// Specialised in fields.hpp. No tuple: one of so many types takes every source that includes it
/// seconds and a hundred megabytes to compile.
template <class Struct>
struct Fields;

/// Names of an enumeration's `values`, which count from 0. Specialised in fields.hpp.
template <class Enum>
struct Names;

}  // namespace torsio
