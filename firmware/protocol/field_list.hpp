/// @file
/// The list that holds the fields of one report.
#pragma once

#include <cstddef>
#include <utility>

namespace torsio::protocol {

namespace detail {
template <std::size_t Place, class T>
struct Placed {
  T value;
};
template <class Places, class... T>
struct Row;
template <std::size_t... Place, class... T>
struct Row<std::index_sequence<Place...>, T...> : Placed<Place, T>... {};
}  // namespace detail

/// The fields of one structure, in wire order. A plain row of values: a std::tuple of so many types
/// takes every source file that includes the reports seconds to compile.
template <class... T>
struct FieldList : detail::Row<std::index_sequence_for<T...>, T...> {
  static constexpr std::size_t size = sizeof...(T);

  /// @returns visit(field...)
  template <class Visit>
  constexpr decltype(auto) apply(Visit&& visit) const {
    return [&]<std::size_t... Place>(std::index_sequence<Place...>) -> decltype(auto) {
      return visit(static_cast<const detail::Placed<Place, T>&>(*this).value...);
    }(std::index_sequence_for<T...>{});
  }

  template <std::size_t Place>
  constexpr const auto& get() const {
    return at<Place>(*this);
  }

 private:
  template <std::size_t Place, class Value>
  static constexpr const Value& at(const detail::Placed<Place, Value>& placed) {
    return placed.value;
  }
};
template <class... T>
FieldList(T...) -> FieldList<T...>;

}  // namespace torsio::protocol
