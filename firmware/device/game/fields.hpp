/// @file
/// The kinds of fields that a report of the game interface is made of, each with what the report
/// descriptor has to say of it.
#pragma once

#include <array>
#include <cstdint>

#include "device/hid_descriptor.hpp"

namespace torsio::device::game {

namespace usage = hid::usage;
using hid::Main;
using hid::Unit;

inline constexpr Unit kNoUnit{};
inline constexpr Unit kMilliseconds{0x1003, -3};
// In hundredths, and so is its physical maximum: Wine takes directions and phases for that,
// whatever the exponent says.
inline constexpr Unit kCentidegrees{0x14, -2};
inline constexpr std::int32_t kTurn = 36000;

/// One value of one or two bytes.
template <class Owner, class T>
struct Value {
  T Owner::* member;
  std::uint16_t page;
  std::uint8_t id;
  std::int32_t min;
  std::int32_t max;
  std::int32_t physical_max = 0;  // 0: as the logical values
  Unit unit{};
  bool strict = true;  // a value outside [min, max] spoils the report

  static constexpr unsigned bytes = sizeof(T);
};
// Clang before 17 finds an aggregate's arguments only where it is told how.
template <class Owner, class T, class... Rest>
Value(T Owner::*, Rest...) -> Value<Owner, T>;

/// One of several choices, numbered from 1 in the order of their usages, in a collection.
template <class Owner, std::size_t N>
struct Choice {
  std::uint8_t Owner::* member;
  std::uint8_t id;  // of the collection
  std::array<std::uint8_t, N> choices;
  bool strict = true;  // a number that is no choice spoils the report

  static constexpr unsigned bytes = 1;
};

/// A bit of a byte.
struct Bit {
  std::uint16_t page;
  std::uint8_t id;
  std::uint8_t collection = 0;  // that it stands in; 0: none
};

/// A byte of bits, the lowest first, filled up with constants.
template <class Owner, std::size_t N>
struct Bits {
  std::uint8_t Owner::* member;
  std::array<Bit, N> bits;

  static constexpr unsigned bytes = 1;
};

/// A collection with values that differ in their usage only.
template <class Owner, std::size_t N>
struct Values {
  std::array<std::uint16_t, N> Owner::* member;
  std::uint8_t collection;
  std::uint16_t page;
  std::array<std::uint8_t, N> ids;
  std::int32_t max;
  std::int32_t physical_max;
  Unit unit{};

  static constexpr unsigned bytes = 2 * N;
};

/// The report: number, way, and the usage of the collection that it stands in; 0: none.
template <std::uint8_t number, Main way, std::uint8_t collection = 0>
struct Heading {
  static constexpr std::uint8_t id = number;
  static constexpr Main main = way;
  static constexpr std::uint8_t usage = collection;
};

template <class Report>
struct PidLayout;

}  // namespace torsio::device::game
