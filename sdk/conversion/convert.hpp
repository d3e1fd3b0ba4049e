/// @file
/// The user's structures to the protocol's and back, written once for all of them. A field is found
/// on the other side by its name; its range is checked in the unit that the user gave it in.
#pragma once

#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>

#include "conversion/field_check.hpp"
#include "conversion/host_fields.hpp"
#include "conversion/wire_types.hpp"
#include "protocol/codec.hpp"
#include "torsio/fields.hpp"

namespace torsio::conversion {

template <class Struct>
concept Listed = requires { Fields<Struct>::name; };

namespace detail {

/// A field has one name on both sides. Angles differ: `x_rad` travels as `x_turns_q32`.
constexpr bool is_same_field(std::string_view host, std::string_view wire) {
  constexpr std::string_view rad = "_rad";
  constexpr std::string_view turns = "_turns_q32";
  if (host == wire) return true;
  return host.ends_with(rad) && wire.ends_with(turns) &&
         host.substr(0, host.size() - rad.size()) == wire.substr(0, wire.size() - turns.size());
}

/// Place of the field that carries the user's `host`; the number of fields if it does not travel by
/// itself.
template <class Wire>
consteval std::size_t wire_place(std::string_view host) {
  return protocol::Layout<Wire>::fields.apply([&](const auto&... field) {
    std::size_t place = 0;
    static_cast<void>(((is_same_field(host, field.name) || (++place, false)) || ...));
    return place;
  });
}

/// Calls `visit(host_field, wire_field)` for each field that both sides have under one name and as
/// a value. Rules across fields do the rest.
template <class Host, class Wire, class Visit>
void for_each_pair(Visit&& visit) {
  constexpr const auto& wire_fields = protocol::Layout<Wire>::fields;
  using WireFields = std::remove_cvref_t<decltype(wire_fields)>;
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    const auto one = [&]<std::size_t Index>(std::integral_constant<std::size_t, Index>) {
      constexpr const auto& host_field = host_fields<Host>.template get<Index>();
      constexpr std::size_t place = wire_place<Wire>(host_field.name);
      if constexpr (place < WireFields::size) {
        constexpr const auto& wire_field = wire_fields.template get<place>();
        using WireValue = typename std::remove_cvref_t<decltype(wire_field)>::Value;
        // 2^-32 of other things than an angle have limits that depend on the encoder.
        if constexpr (!std::same_as<WireValue, std::uint64_t>) visit(host_field, wire_field);
      }
    };
    (one(std::integral_constant<std::size_t, I>{}), ...);
  }(std::make_index_sequence<host_fields<Host>.size>{});
}

/// The double that a person would write for this float: 0.1F comes back as 0.1.
inline double widen(float value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double shortest = 0.0;
  std::from_chars(text.data(), end, shortest);
  return shortest;
}

}  // namespace detail

/// Fills in the fields that the user's structure has. check_fields() finds values out of range that
/// can travel.
/// @throws InvalidArgument that names a field which cannot travel, its value and its range
template <class Host, class Wire>
void convert_fields(const Host& host, Wire& wire) {
  detail::for_each_pair<Host, Wire>([&](const auto& from, const auto& to) {
    const auto& value = host.*from.member;
    auto& travels = wire.*to.member;
    using Value = std::remove_cvref_t<decltype(value)>;
    using Travels = std::remove_cvref_t<decltype(travels)>;
    if constexpr (Listed<Value>) {
      convert_fields(value, travels);
    } else if constexpr (std::same_as<Travels, std::int64_t>) {
      travels = turns_q32(from.name, value);
    } else if constexpr (std::floating_point<Value>) {
      travels = narrow(value);
    } else if constexpr (std::integral<Travels>) {
      travels = whole_number<Travels>(from.name, value, to.min, to.max);
    } else {
      travels = static_cast<Travels>(value);  // an enumeration, or a yes or no
    }
  });
}

/// The report, by the protocol's own rules for single fields.
/// @throws InvalidArgument that names the field, its value and its range
template <class Host>
typename WireType<Host>::type convert(const Host& host) {
  typename WireType<Host>::type wire;
  convert_fields(host, wire);
  check_fields(wire);
  return wire;
}

/// The report's content in the user's units.
template <class Host>
Host convert_back(const typename WireType<Host>::type& wire) {
  Host host;
  detail::for_each_pair<Host, typename WireType<Host>::type>([&](const auto& to, const auto& from) {
    auto& value = host.*to.member;
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::floating_point<Value>) {
      value = detail::widen(wire.*from.member);
    } else {
      value = static_cast<Value>(wire.*from.member);
    }
  });
  return host;
}

}  // namespace torsio::conversion
