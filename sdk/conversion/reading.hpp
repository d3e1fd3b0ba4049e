/// @file
/// A device's reports in the user's structures and units, written once for all.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string_view>
#include <type_traits>
#include <utility>

#include "conversion/host_fields.hpp"
#include "conversion/wire_types.hpp"
#include "protocol/codec.hpp"
#include "protocol/reports.hpp"
#include "torsio/fields.hpp"

namespace torsio::conversion {

namespace detail {

constexpr bool is_told_as(std::string_view told, std::string_view name, std::string_view unit) {
  for (const ReportUnit& row : kReportUnits) {
    if (row.unit != unit) continue;
    return told.ends_with(row.told_ending) && name.ends_with(row.ending) &&
           told.substr(0, told.size() - row.told_ending.size()) ==
               name.substr(0, name.size() - row.ending.size());
  }
  return told == name;
}

/// Place of the report's field that users are told as `told`; the number of fields if there is
/// none.
template <class Wire>
consteval std::size_t told_place(std::string_view told) {
  return protocol::Layout<Wire>::fields.apply([&](const auto&... field) {
    std::size_t place = 0;
    static_cast<void>(((is_told_as(told, field.name, field.unit) || (++place, false)) || ...));
    return place;
  });
}

consteval std::size_t unit_index(std::string_view unit) {
  std::size_t index = 0;
  while (index < kReportUnits.size() && kReportUnits.at(index).unit != unit) ++index;
  return index;
}

template <class Value>
concept Told = std::is_arithmetic_v<Value> || std::is_enum_v<Value>;

}  // namespace detail

/// Fills in the user's fields that a report has as numbers and enumerations: by its name, or under
/// the name that its unit makes of it. Texts, sums and angles are the caller's.
/// @param device whose steps the report counts in
template <class Host, class Wire>
void read_into(Host& host, const Wire& wire, const protocol::Identity& device) {
  constexpr const auto& reported = protocol::Layout<Wire>::fields;
  const auto one = [&]<std::size_t Index>(std::integral_constant<std::size_t, Index>) {
    constexpr const auto& to = host_fields<Host>.template get<Index>();
    constexpr std::size_t place = detail::told_place<Wire>(to.name);
    if constexpr (place < std::remove_cvref_t<decltype(reported)>::size) {
      constexpr const auto& from = reported.template get<place>();
      auto& value = host.*to.member;
      const auto& travelled = wire.*from.member;
      using Value = std::remove_cvref_t<decltype(value)>;
      using Travelled = std::remove_cvref_t<decltype(travelled)>;
      if constexpr (std::floating_point<Value> && std::is_arithmetic_v<Travelled>) {
        value = in_si<detail::unit_index(from.unit)>(static_cast<Value>(travelled), device);
      } else if constexpr (detail::Told<Value> && detail::Told<Travelled>) {
        value = static_cast<Value>(travelled);
      }
    }
  };
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (one(std::integral_constant<std::size_t, I>{}), ...);
  }(std::make_index_sequence<host_fields<Host>.size>{});
}

/// The same as a structure, whose other fields are as they begin.
template <class Host, class Wire>
Host read(const Wire& wire, const protocol::Identity& device) {
  Host host{};
  read_into(host, wire, device);
  return host;
}

/// The time of a tick.
inline double time_s(std::uint64_t tick, const protocol::Identity& device) {
  return static_cast<double>(tick) * (1e-9 * device.control_period_ns);
}

inline double angle_rad(std::int64_t position_counts, const protocol::Identity& device) {
  return static_cast<double>(position_counts) * (2.0 * std::numbers::pi / device.counts_per_rev);
}

}  // namespace torsio::conversion
