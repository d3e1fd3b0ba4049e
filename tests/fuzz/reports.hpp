/// @file Makes and changes reports by their field lists: ids, lengths and ranges are right or
/// nearly right, so that most reports pass the first check.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <type_traits>

#include "emulator/random.hpp"
#include "protocol/codec.hpp"
#include "protocol/registry.hpp"

namespace fuzz {

/// Fills the fields of a report: mostly within their ranges, often at the ends, seldom beyond.
class FieldMaker {
 public:
  explicit FieldMaker(std::uint64_t seed) : random_(seed) {}

  std::size_t below(std::size_t limit) { return random_.next() % limit; }
  std::uint64_t bits() { return random_.next(); }

  /// The bytes of any report.
  torsio::protocol::ReportBytes any() {
    using namespace torsio::protocol;
    torsio::protocol::ReportBytes bytes{};
    std::size_t wanted = below(std::tuple_size_v<AllReports>);
    for_each_report<AllReports>([&]<class Report>(std::type_identity<Report>) {
      if (wanted-- == 0) bytes = encode(make<Report>());
    });
    return bytes;
  }

  template <class Report>
  Report make() {
    Report report{};
    fill(report);
    return report;
  }

  template <class T>
  void fill(T& structure) {
    torsio::protocol::Layout<T>::fields.apply(
        [&](const auto&... field) { (put(structure.*field.member, field), ...); });
  }

 private:
  template <class T, class Field>
  void put(T& value, const Field& field) {
    using namespace torsio::protocol;
    if constexpr (Array<T>) {
      for (auto& element : value) put(element, field);
    } else if constexpr (Structure<T>) {
      fill(value);
    } else if constexpr (std::is_floating_point_v<T>) {
      value = number(value, field.min, field.max);
    } else if constexpr (Enumeration<T>) {
      value = static_cast<T>(below(20) == 0 ? below(256) : below(field.max + 1U));
    } else {
      value = whole(value, field.min, field.max);
    }
  }

  float number(float usual, float min, float max) {
    switch (below(8)) {
      case 0:
        return min;
      case 1:
        return max;
      case 2:
        return std::bit_cast<float>(static_cast<std::uint32_t>(bits()));
      case 3:
        return 0.0F;
      case 4:
        return min + (max - min) * static_cast<float>(random_.uniform());
      case 5:
        return usual * static_cast<float>(2.0 * random_.uniform());
      default:
        return usual;
    }
  }
  template <class T>
  T whole(T usual, T min, T max) {
    switch (below(8)) {
      case 0:
        return min;
      case 1:
        return max;
      case 2:
        return static_cast<T>(bits());
      case 3:
      case 4:
        return static_cast<T>(bits() % 17);
      default:
        return usual;
    }
  }

  torsio::emulator::Random random_;
};

/// Puts a piece behind an input, or over a part of it. @returns how long the input is then
inline std::size_t put(std::span<const std::uint8_t> piece, std::span<std::uint8_t> room,
                       std::size_t size, FieldMaker& make) {
  std::size_t at = make.below(4) == 0 ? make.below(size + 1) : size;
  if (at + piece.size() > room.size()) at = make.below(room.size() - piece.size() + 1);
  std::ranges::copy(piece, room.begin() + static_cast<std::ptrdiff_t>(at));
  return std::max(size, at + piece.size());
}

}  // namespace fuzz
