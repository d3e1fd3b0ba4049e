/// @file
/// How a report is described: one constexpr list of fields gives its bytes, its limits, its
/// documentation and its share of the fingerprint.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>

#include "protocol/field_list.hpp"

namespace torsio::protocol {

/// Every report is this long on the wire, with id and zero padding: one full-speed interrupt
/// packet. So no operating system has to guess a length.
inline constexpr std::size_t report_size = 64;

enum class Direction : std::uint8_t {
  input,    // device to host, interrupt IN
  output,   // host to device, interrupt OUT
  feature,  // both ways, control requests
};

/// Description of a report or of a structure inside reports. Specialised next to each structure
/// with `name`, `doc` and `fields`; reports have `id` and `direction` as well.
template <class Struct>
struct Layout;

/// `names` of an enumeration's values, from 0 on without gaps. If it is `open`, a reader accepts a
/// number without a name.
template <class Enum>
struct Enumerators;

template <class T>
concept Enumeration = std::is_enum_v<T>;

template <class T>
concept Structure = std::is_class_v<T> && requires { Layout<T>::fields; };

template <class T>
struct ArrayTraits : std::false_type {
  using Element = T;
};
template <class T, std::size_t N>
struct ArrayTraits<std::array<T, N>> : std::true_type {
  using Element = T;
  static constexpr std::size_t size = N;
};

template <class T>
concept Array = ArrayTraits<T>::value;

template <class T>
concept Scalar = std::is_arithmetic_v<T> && !std::same_as<T, double> && !std::same_as<T, bool>;

/// One field. `min` and `max` bound each scalar in it, both included.
template <class Owner, class T>
struct Field {
  using Value = T;
  using Bound = std::conditional_t<Scalar<typename ArrayTraits<T>::Element>,
                                   typename ArrayTraits<T>::Element, std::uint8_t>;

  std::string_view name;
  T Owner::* member;
  std::string_view unit;
  Bound min;
  Bound max;
  std::string_view doc;
};

/// A number, or an array of numbers, within [min, max].
template <class Owner, class T>
consteval Field<Owner, T> number(std::string_view name, T Owner::* member, std::string_view unit,
                                 std::type_identity_t<typename Field<Owner, T>::Bound> min,
                                 std::type_identity_t<typename Field<Owner, T>::Bound> max,
                                 std::string_view doc) {
  return {name, member, unit, min, max, doc};
}

/// A number without a range: every (finite) value has a meaning.
template <class Owner, class T>
consteval Field<Owner, T> any_number(std::string_view name, T Owner::* member,
                                     std::string_view unit, std::string_view doc) {
  using Limits = std::numeric_limits<typename Field<Owner, T>::Bound>;
  return {name, member, unit, Limits::lowest(), Limits::max(), doc};
}

/// One value of an enumeration.
template <class Owner, Enumeration T>
consteval Field<Owner, T> choice(std::string_view name, T Owner::* member, std::string_view doc) {
  constexpr std::size_t last = Enumerators<T>::open ? 0xFF : Enumerators<T>::names.size() - 1;
  return {name, member, "", 0, static_cast<std::uint8_t>(last), doc};
}

/// A structure, or an array of structures, with fields of its own.
template <class Owner, class T>
consteval Field<Owner, T> group(std::string_view name, T Owner::* member, std::string_view doc) {
  return {name, member, "", 0, 0, doc};
}

/// Bytes that a value takes on the wire. There is no padding between fields.
template <class T>
consteval std::size_t wire_size() {
  if constexpr (Array<T>) {
    return ArrayTraits<T>::size * wire_size<typename ArrayTraits<T>::Element>();
  } else if constexpr (Structure<T>) {
    return Layout<T>::fields.apply([](const auto&... field) {
      return (std::size_t{0} + ... +
              wire_size<typename std::remove_cvref_t<decltype(field)>::Value>());
    });
  } else {
    static_assert(Scalar<T> || Enumeration<T>);
    return sizeof(T);
  }
}

/// Fields in wire order with nested structures opened; an array counts as one field.
template <class T>
consteval std::size_t field_count() {
  if constexpr (Structure<T>) {
    return Layout<T>::fields.apply([](const auto&... field) {
      return (std::size_t{0} + ... +
              field_count<typename std::remove_cvref_t<decltype(field)>::Value>());
    });
  } else {
    return 1;
  }
}

}  // namespace torsio::protocol
