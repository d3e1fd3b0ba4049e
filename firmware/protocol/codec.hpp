/// @file
/// Reports to bytes and back, from the field lists. Little endian whatever the host.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "protocol/layout.hpp"
#include "protocol/status.hpp"

namespace torsio::protocol {

using ReportBytes = std::array<std::uint8_t, report_size>;

namespace detail {

template <std::size_t Size>
using UnsignedOf = std::conditional_t<
    Size == 1, std::uint8_t,
    std::conditional_t<Size == 2, std::uint16_t,
                       std::conditional_t<Size == 4, std::uint32_t, std::uint64_t>>>;

/// Finite by its bits, so that no compiler option can remove the question.
constexpr bool is_finite(float value) {
  return (std::bit_cast<std::uint32_t>(value) & 0x7F800000U) != 0x7F800000U;
}

class Writer {
 public:
  constexpr explicit Writer(std::span<std::uint8_t> bytes) : bytes_(bytes) {}

  template <class T>
  constexpr void put(const T& value) {
    if constexpr (Array<T>) {
      for (const auto& element : value) put(element);
    } else if constexpr (Structure<T>) {
      Layout<T>::fields.apply([&](const auto&... field) { (put(value.*field.member), ...); });
    } else {
      put_bits(std::bit_cast<UnsignedOf<sizeof(T)>>(value), sizeof(T));
    }
  }

  constexpr std::size_t at() const { return at_; }

 private:
  // Once for all fields: inlined in each it would take several kB of a small board's RAM.
  [[gnu::noinline]] constexpr void put_bits(std::uint64_t bits, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      bytes_[at_++] = static_cast<std::uint8_t>(bits >> (8 * i));
    }
  }

  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

class Reader {
 public:
  constexpr explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// Reads and checks one structure; the first offence is kept.
  template <Structure T>
  constexpr void get(T& value) {
    Layout<T>::fields.apply(
        [&](const auto&... field) { (get_field(value.*field.member, field), ...); });
  }

  constexpr Verdict verdict() const { return verdict_; }
  constexpr std::size_t at() const { return at_; }

 private:
  template <class T, class FieldType>
  constexpr void get_field(T& value, const FieldType& field) {
    if constexpr (Structure<T>) {
      get(value);
    } else if constexpr (Array<T>) {
      if constexpr (Structure<typename ArrayTraits<T>::Element>) {
        const std::uint8_t index = index_;
        for (auto& element : value) {
          get(element);
          index_ = index;
        }
      } else {
        for (auto& element : value) get_scalar(element, field);
      }
      ++index_;
    } else {
      get_scalar(value, field);
      ++index_;
    }
  }

  // This too is compiled once for all fields of a type.
  template <class T, class FieldType>
  [[gnu::noinline]] constexpr void get_scalar(T& value, const FieldType& field) {
    const auto exact = static_cast<UnsignedOf<sizeof(T)>>(take_bits(sizeof(T)));
    if constexpr (Enumeration<T>) {
      // An out-of-range number must never become an enumerator, not even for a moment. Open
      // enumerations have no range.
      const bool known = exact <= field.max;
      value = static_cast<T>(known ? exact : 0);
      if (!known) note(Status::out_of_range);
    } else {
      value = std::bit_cast<T>(exact);
      if constexpr (std::is_floating_point_v<T>) {
        if (!is_finite(value)) {
          note(Status::not_finite);
          return;
        }
      }
      if (value < field.min || value > field.max) note(Status::out_of_range);
    }
  }

  constexpr std::uint64_t take_bits(std::size_t size) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) {
      bits |= static_cast<std::uint64_t>(bytes_[at_++]) << (8 * i);
    }
    return bits;
  }

  constexpr void note(Status status) {
    if (verdict_.ok()) verdict_ = {status, index_};
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  std::uint8_t index_ = 0;
  Verdict verdict_;
};

}  // namespace detail

/// The bytes of a report: id, fields, zeros.
template <class Report>
constexpr ReportBytes encode(const Report& report) {
  static_assert(1 + wire_size<Report>() <= report_size);
  ReportBytes bytes{};
  bytes[0] = Layout<Report>::id;
  detail::Writer(std::span(bytes).subspan(1)).put(report);
  return bytes;
}

/// Reads a report. `report` is meaningful only if the verdict is ok.
/// @returns bad_length, unknown_report, bad_padding, or the first field that is not finite or out
///          of its range with its index
template <class Report>
constexpr Verdict decode(std::span<const std::uint8_t> bytes, Report& report) {
  if (bytes.size() != report_size) return {Status::bad_length};
  if (bytes[0] != Layout<Report>::id) return {Status::unknown_report};
  for (std::size_t i = 1 + wire_size<Report>(); i < report_size; ++i) {
    if (bytes[i] != 0) return {Status::bad_padding};
  }
  detail::Reader reader(bytes.subspan(1));
  reader.get(report);
  return reader.verdict();
}

/// Checks a report that was made here, by the same rules as one that came over the wire.
template <class Report>
constexpr Verdict check(const Report& report) {
  Report ignored{};
  return decode(encode(report), ignored);
}

}  // namespace torsio::protocol
