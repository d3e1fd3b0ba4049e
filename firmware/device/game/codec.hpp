/// @file
/// Bytes of the game interface's reports: little endian, packed, the id first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "device/game/reports.hpp"

namespace torsio::device::game {

/// Bytes of a report, its id included.
template <class Report>
consteval std::size_t size_of() {
  return PidLayout<Report>::fields.apply(
      [](const auto&... field) { return (std::size_t{1} + ... + field.bytes); });
}

namespace detail {

template <class T>
constexpr void put(std::span<std::uint8_t> bytes, std::size_t& at, T value) {
  const auto bits = static_cast<std::make_unsigned_t<T>>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[at++] = static_cast<std::uint8_t>(bits >> (8 * i));
  }
}

template <class T>
constexpr T take(std::span<const std::uint8_t> bytes, std::size_t& at) {
  std::make_unsigned_t<T> bits = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bits = static_cast<std::make_unsigned_t<T>>(bits | (bytes[at++] << (8 * i)));
  }
  return static_cast<T>(bits);
}

// One encoder and one reader for each kind of field.
template <class Owner, class Field>
constexpr void write(std::span<std::uint8_t> bytes, std::size_t& at, const Owner& report,
                     const Field& field) {
  put(bytes, at, report.*field.member);
}
template <class Owner, std::size_t N>
constexpr void write(std::span<std::uint8_t> bytes, std::size_t& at, const Owner& report,
                     const Values<Owner, N>& field) {
  for (const std::uint16_t value : report.*field.member) put(bytes, at, value);
}

template <class Owner, class T>
constexpr bool read(std::span<const std::uint8_t> bytes, std::size_t& at, Owner& report,
                    const Value<Owner, T>& field) {
  const T value = take<T>(bytes, at);
  report.*field.member = value;
  return !field.strict || (value >= field.min && value <= field.max);
}
template <class Owner, std::size_t N>
constexpr bool read(std::span<const std::uint8_t> bytes, std::size_t& at, Owner& report,
                    const Choice<Owner, N>& field) {
  report.*field.member = bytes[at++];
  return !field.strict || (report.*field.member >= 1 && report.*field.member <= N);
}
template <class Owner, std::size_t N>
constexpr bool read(std::span<const std::uint8_t> bytes, std::size_t& at, Owner& report,
                    const Bits<Owner, N>& field) {
  report.*field.member = bytes[at++];
  return true;
}
template <class Owner, std::size_t N>
constexpr bool read(std::span<const std::uint8_t> bytes, std::size_t& at, Owner& report,
                    const Values<Owner, N>& field) {
  bool good = true;
  for (std::uint16_t& value : report.*field.member) {
    value = take<std::uint16_t>(bytes, at);
    good = good && value <= field.max;
  }
  return good;
}

}  // namespace detail

/// Writes a report with its id.
/// @returns its size
template <class Report>
constexpr std::size_t encode(const Report& report, std::span<std::uint8_t> bytes) {
  static_assert(size_of<Report>() <= kLongestReport);
  bytes[0] = PidLayout<Report>::id;
  std::size_t at = 1;
  PidLayout<Report>::fields.apply(
      [&](const auto&... field) { (detail::write(bytes, at, report, field), ...); });
  return at;
}

/// Reads a report. Windows fills every report up to the length of the longest, so what follows the
/// last field is not looked at.
/// @returns false if it is another report, too short, or a value has no meaning
template <class Report>
constexpr bool decode(std::span<const std::uint8_t> bytes, Report& report) {
  if (bytes.size() < size_of<Report>() || bytes[0] != PidLayout<Report>::id) return false;
  std::size_t at = 1;
  bool good = true;
  PidLayout<Report>::fields.apply([&](const auto&... field) {
    ((good = detail::read(bytes, at, report, field) && good), ...);
  });
  return good;
}

}  // namespace torsio::device::game
