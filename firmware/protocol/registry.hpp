/// @file
/// Walks through the reports and their fields, and the fingerprint that two sides compare before
/// they talk.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "protocol/effects.hpp"
#include "protocol/layout.hpp"
#include "protocol/reports.hpp"

namespace torsio::protocol {

/// Calls `visit(std::type_identity<Report>{})` for each report of a list, in order.
template <class List, class Visit>
constexpr void for_each_report(Visit&& visit) {
  [&]<class... Report>(std::type_identity<std::tuple<Report...>>) {
    (visit(std::type_identity<Report>{}), ...);
  }(std::type_identity<List>{});
}

/// How a type is named in the documentation and hashed into the fingerprint.
template <class T>
constexpr std::string_view type_name() {
  if constexpr (Structure<T>) {
    return Layout<T>::name;
  } else if constexpr (Enumeration<T>) {
    return "u8";
  } else if constexpr (std::is_floating_point_v<T>) {
    return "f32";
  } else if constexpr (std::is_signed_v<T>) {
    return sizeof(T) == 1 ? "i8" : sizeof(T) == 2 ? "i16" : sizeof(T) == 4 ? "i32" : "i64";
  } else {
    return sizeof(T) == 1 ? "u8" : sizeof(T) == 2 ? "u16" : sizeof(T) == 4 ? "u32" : "u64";
  }
}

namespace detail {

/// @returns 0 for an open enumeration
template <Enumeration T>
consteval std::uint8_t count_if_closed() {
  return Enumerators<T>::open ? 0 : static_cast<std::uint8_t>(Enumerators<T>::names.size());
}

/// FNV-1a, 32 bits.
class Hash {
 public:
  constexpr void add(std::uint8_t byte) { value_ = (value_ ^ byte) * 16777619U; }
  constexpr void add(std::string_view text) {
    for (const char c : text) add(static_cast<std::uint8_t>(c));
    add(std::uint8_t{0});
  }
  template <class T>
  constexpr void add_type() {
    if constexpr (Array<T>) {
      add(static_cast<std::uint8_t>(ArrayTraits<T>::size));
      add_type<typename ArrayTraits<T>::Element>();
    } else if constexpr (Structure<T>) {
      Layout<T>::fields.apply([&](const auto&... field) {
        ((add(field.name), add_type<typename std::remove_cvref_t<decltype(field)>::Value>()), ...);
      });
    } else {
      add(type_name<T>());
      // The device refuses a value that it does not know, and so does the host.
      if constexpr (Enumeration<T>) add(count_if_closed<T>());
    }
  }
  constexpr std::uint32_t value() const { return value_; }

 private:
  std::uint32_t value_ = 2166136261U;
};

}  // namespace detail

/// Hash over the id, direction, field names and types of every report: other layouts give another
/// one. Wording, ranges and names of values do not enter. The number of values enters only where a
/// reader refuses an unknown value. So a new law separates released hosts and devices; a new board
/// or event does not.
consteval std::uint32_t fingerprint() {
  detail::Hash hash;
  for_each_report<AllReports>([&]<class Report>(std::type_identity<Report>) {
    hash.add(Layout<Report>::id);
    hash.add(static_cast<std::uint8_t>(Layout<Report>::direction));
    hash.add(Layout<Report>::name);
    hash.add_type<Report>();
  });
  return hash.value();
}

/// Whether a host with these reports drives a device with such a fingerprint.
constexpr bool drives(std::uint32_t device) {
  if (device == fingerprint()) return true;
  for (const std::uint32_t released : released_fingerprints) {
    if (device == released) return true;
  }
  return false;
}

/// Name of a field by its index in a Verdict ("timing.attack_s" is given as "attack_s").
/// @returns an empty view if there is no such field
template <class T>
constexpr std::string_view field_name(std::uint8_t index) {
  std::string_view found;
  std::uint8_t at = 0;
  const auto look = [&]<class Self, class S>(const Self& self, std::type_identity<S>) -> void {
    const auto one = [&](const auto& field) {
      using Value = typename std::remove_cvref_t<decltype(field)>::Value;
      if constexpr (Structure<Value>) {
        self(self, std::type_identity<Value>{});
      } else if (at++ == index) {
        found = field.name;
      }
    };
    Layout<S>::fields.apply([&](const auto&... field) { (one(field), ...); });
  };
  look(look, std::type_identity<T>{});
  return found;
}

/// Index of a field in a Verdict. Fails to compile if there is no such field.
template <class T>
consteval std::uint8_t field_index(std::string_view name) {
  for (std::uint8_t index = 0; index < field_count<T>(); ++index) {
    if (field_name<T>(index) == name) return index;
  }
  return std::array<std::uint8_t, 0>{}.at(0);  // no such field
}

}  // namespace torsio::protocol
