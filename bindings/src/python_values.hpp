/// @file
/// The Python package's data classes as the libraries' structures and back, written once for all of
/// them: both sides name their fields alike. Python has them as frozen data classes, so that type
/// checkers, `repr` and `==` work without help; they are read by attribute.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "attributes.hpp"
#include "bytes.hpp"
#include "torsio/fields.hpp"
#include "torsio/plant_fields.hpp"

namespace torsio::bindings {

template <class T>
concept Listed = requires { Fields<T>::name; };

template <class T>
concept Named = requires { Names<T>::values; };

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_list = false;
template <Listed T>
inline constexpr bool is_list<std::vector<T>> = true;

Profile profile_from_python(const pybind11::handle& source);

/// An object that C++ may destroy on any thread, and use there with the interpreter's lock.
std::shared_ptr<pybind11::object> keep(const pybind11::object& source);

/// A Python function that C++ may call from any thread and destroy there.
HandFunction hand_function_from_python(const pybind11::object& source);

/// True while this thread runs the function of a hand, in the middle of a step of the plant.
bool is_in_hand();

/// @param source a hand of the package, or None
/// @throws InvalidArgument or TypeError that names the class and the attribute, as all below
Hand hand_from_python(const pybind11::handle& source);

template <Listed T>
T from_python(const pybind11::handle& source);

/// One attribute of a data class.
template <class T>
void read(const Attributes& from, const char* name, T& value) {
  if constexpr (std::is_same_v<T, double>) {
    value = from.number(name);
  } else if constexpr (std::is_same_v<T, std::optional<double>>) {
    value = from.optional_number(name);
  } else if constexpr (std::is_same_v<T, bool>) {
    value = from.boolean(name);
  } else if constexpr (std::is_integral_v<T>) {
    value = from.integer<T>(name);
  } else if constexpr (std::is_same_v<T, std::string>) {
    value = from.text(name);
  } else if constexpr (Named<T>) {
    value = from.choice<T>(name, Names<T>::values);
  } else if constexpr (std::is_same_v<T, Profile>) {
    value = profile_from_python(from.get(name));
  } else if constexpr (std::is_same_v<T, HandFunction>) {
    value = hand_function_from_python(from.get(name));
  } else if constexpr (std::is_same_v<T, Hand>) {
    value = hand_from_python(from.get(name));
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    const pybind11::object points = from.get(name);
    for (const pybind11::handle point : points) value.push_back(from.as_number(point, name));
  } else if constexpr (is_optional<T>) {
    const pybind11::object part = from.get(name);
    if (!part.is_none()) value = from_python<typename T::value_type>(part);
  } else {
    value = from_python<T>(from.get(name));
  }
}

template <Listed T>
T from_python(const pybind11::handle& source) {
  T made{};
  const Attributes from(source, Fields<T>::name);
  Fields<T>::apply(
      [&](const auto&... field) { (read(from, field.name.data(), made.*field.member), ...); });
  return made;
}

/// A value as Python has it: enumerations by name, several as a tuple, structures as dicts of
/// their data class's arguments.
template <class T>
pybind11::object to_python(const T& value) {
  if constexpr (Listed<T>) {
    pybind11::dict dict;
    Fields<T>::apply([&](const auto&... field) {
      ((dict[field.name.data()] = to_python(value.*field.member)), ...);
    });
    return dict;
  } else if constexpr (is_optional<T>) {
    return value ? to_python(*value) : pybind11::none();
  } else if constexpr (Named<T>) {
    return pybind11::cast(Names<T>::values[static_cast<std::size_t>(value)]);
  } else if constexpr (std::is_same_v<T, std::vector<std::uint8_t>>) {
    return to_bytes(value);
  } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
    return pybind11::tuple(pybind11::cast(value));
  } else if constexpr (is_list<T>) {
    pybind11::tuple list(value.size());
    for (std::size_t i = 0; i < value.size(); ++i) list[i] = to_python(value[i]);
    return list;
  } else {
    return pybind11::cast(value);
  }
}

/// The type of a structured array with one row for each `T`.
template <Listed T>
pybind11::dtype row_type() {
  static_assert(std::is_trivially_copyable_v<T>);
  pybind11::list names;
  pybind11::list formats;
  pybind11::list offsets;
  const T row{};
  const auto one = [&](const auto& field) {
    names.append(pybind11::str(field.name.data()));
    formats.append(pybind11::dtype::of<typename std::remove_cvref_t<decltype(field)>::Value>());
    offsets.append(reinterpret_cast<const char*>(&(row.*field.member)) -
                   reinterpret_cast<const char*>(&row));
  };
  Fields<T>::apply([&](const auto&... field) { (one(field), ...); });
  return pybind11::dtype(names, formats, offsets, static_cast<pybind11::ssize_t>(sizeof(T)));
}

/// Has NumPy know `T` as a row of a structured array, for `array_t<T>`.
template <Listed T>
void register_rows() {
  std::vector<pybind11::detail::field_descriptor> columns;
  const T row{};
  const auto one = [&](const auto& field) {
    using Value = typename std::remove_cvref_t<decltype(field)>::Value;
    columns.push_back(
        {field.name.data(),
         reinterpret_cast<const char*>(&(row.*field.member)) - reinterpret_cast<const char*>(&row),
         sizeof(Value), pybind11::format_descriptor<Value>::format(),
         pybind11::detail::npy_format_descriptor<Value>::dtype()});
  };
  Fields<T>::apply([&](const auto&... field) { (one(field), ...); });
  pybind11::detail::npy_format_descriptor<T>::register_dtype(columns);
}

/// Makes the bytes between and behind a row's fields zero, so that equal records have equal bytes.
template <Listed T>
void clear_padding(std::vector<T>& rows) {
  for (T& row : rows) {
    const T fields = row;
    std::memset(static_cast<void*>(&row), 0, sizeof(T));
    Fields<T>::apply(
        [&](const auto&... field) { ((row.*field.member = fields.*field.member), ...); });
  }
}

/// Rows as a structured array that owns the vector's memory: no copy.
template <Listed T>
pybind11::array as_array(std::vector<T>&& rows) {
  auto owner = std::make_unique<std::vector<T>>(std::move(rows));
  const auto size = static_cast<pybind11::ssize_t>(owner->size());
  const T* data = owner->data();
  const pybind11::capsule base(owner.release(),
                               [](void* vector) { delete static_cast<std::vector<T>*>(vector); });
  return pybind11::array(row_type<T>(), {size}, data, base);
}

/// @throws InvalidArgument or TypeError that names the class and the attribute; likewise below
Effect effect_from_python(const pybind11::handle& source);

/// @param source one effect or an iterable of effects
Scene scene_from_python(const pybind11::handle& source);

}  // namespace torsio::bindings
