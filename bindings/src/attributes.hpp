/// @file
/// Reads the attributes of a Python object, with errors that say which one is wrong.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "torsio/error.hpp"

namespace torsio::bindings {

/// A value as messages show it: short, in one line.
inline std::string shown(const pybind11::handle& value) {
  return pybind11::module_::import("torsio.common.checks").attr("show")(value).cast<std::string>();
}

/// A message as Python has it, also where it names a file whose name is no text.
inline pybind11::str to_text(std::string_view message) {
  return pybind11::reinterpret_steal<pybind11::str>(PyUnicode_DecodeUTF8(
      message.data(), static_cast<Py_ssize_t>(message.size()), "surrogateescape"));
}

/// A name in Python's words, made once. With the interpreter's lock.
/// @param name lives as long as the process
inline pybind11::handle interned(const char* name) {
  static std::unordered_map<const char*, PyObject*> made;
  PyObject*& text = made[name];
  if (text == nullptr) text = PyUnicode_InternFromString(name);
  return text;
}

class Attributes {
 public:
  /// @param wanted the class that it should be of, for the message if it is not
  explicit Attributes(pybind11::handle source, std::string_view wanted = "another object")
      : source_(source), wanted_(wanted) {}

  [[nodiscard]] std::string class_name() const {
    return pybind11::str(pybind11::type::handle_of(source_).attr("__name__"));
  }

  [[nodiscard]] pybind11::object get(const char* name) const {
    PyObject* const value = PyObject_GetAttr(source_.ptr(), interned(name).ptr());
    if (value != nullptr) return pybind11::reinterpret_steal<pybind11::object>(value);
    if (PyErr_ExceptionMatches(PyExc_AttributeError) == 0) throw pybind11::error_already_set();
    PyErr_Clear();
    throw pybind11::type_error(shown(source_) + " is no " + std::string(wanted_) + ": it has no " +
                               name);
  }

  [[nodiscard]] double number(const char* name) const { return as_number(get(name), name); }

  [[nodiscard]] std::optional<double> optional_number(const char* name) const {
    const pybind11::object value = get(name);
    if (value.is_none()) return std::nullopt;
    return as_number(value, name);
  }

  /// A whole number of any C++ integer type.
  template <class T>
  [[nodiscard]] T integer(const char* name) const {
    const pybind11::object value = get(name);
    const auto whole = pybind11::reinterpret_steal<pybind11::object>(PyNumber_Index(value.ptr()));
    if (!whole) refuse_type(name, "a whole number", value);
    using Widest = std::conditional_t<std::is_signed_v<T>, long long, unsigned long long>;
    Widest wide{};
    if constexpr (std::is_signed_v<T>) {
      wide = PyLong_AsLongLong(whole.ptr());
    } else {
      wide = PyLong_AsUnsignedLongLong(whole.ptr());
    }
    const bool fits = PyErr_Occurred() == nullptr;
    PyErr_Clear();
    if (!fits || !std::in_range<T>(wide)) {
      refuse(name, "must be from " + std::to_string(std::numeric_limits<T>::min()) + " to " +
                       std::to_string(std::numeric_limits<T>::max()) + ", is " + shown(value));
    }
    return static_cast<T>(wide);
  }

  [[nodiscard]] bool boolean(const char* name) const {
    const pybind11::object value = get(name);
    const int truth = PyObject_IsTrue(value.ptr());
    if (truth < 0) refuse_type(name, "True or False", value);
    return truth != 0;
  }

  [[nodiscard]] std::string text(const char* name) const {
    const pybind11::object value = get(name);
    const auto text = utf8(value);
    if (!text) refuse_type(name, "a string of valid characters", value);
    return std::string(*text);
  }

  /// An enumeration that counts from 0, given by the name of its value.
  template <class Enum, std::size_t N>
  [[nodiscard]] Enum choice(const char* name, const std::array<std::string_view, N>& names) const {
    const pybind11::object value = get(name);
    const auto text = utf8(value);
    for (std::size_t i = 0; i < N; ++i) {
      if (text == names[i]) return static_cast<Enum>(i);
    }
    std::string allowed;
    for (const std::string_view known : names) {
      allowed += (allowed.empty() ? "'" : ", '") + std::string(known) + "'";
    }
    refuse(name, "must be one of " + allowed + ", is " + shown(value));
  }

  [[noreturn]] void refuse(const char* name, const std::string& why) const {
    throw InvalidArgument(class_name() + "." + name + " " + why);
  }

  [[noreturn]] void refuse_type(const char* name, const std::string& wanted,
                                const pybind11::handle& value) const {
    PyErr_Clear();
    throw pybind11::type_error(class_name() + "." + name + " must be " + wanted + ", is " +
                               shown(value));
  }

  [[nodiscard]] double as_number(const pybind11::handle& value, const char* name) const {
    const double number = PyFloat_AsDouble(value.ptr());
    if (number == -1.0 && PyErr_Occurred() != nullptr &&
        PyErr_ExceptionMatches(PyExc_OverflowError) != 0) {
      PyErr_Clear();
      refuse(name, "is too large");
    }
    if (number == -1.0 && PyErr_Occurred() != nullptr) refuse_type(name, "a number", value);
    return number;
  }

 private:
  /// Nothing for other types and for strings with surrogates, which UTF-8 lacks. Valid as long as
  /// the value.
  static std::optional<std::string_view> utf8(const pybind11::handle& value) {
    if (!pybind11::isinstance<pybind11::str>(value)) return std::nullopt;
    Py_ssize_t size = 0;
    const char* const text = PyUnicode_AsUTF8AndSize(value.ptr(), &size);
    if (text != nullptr) return std::string_view(text, static_cast<std::size_t>(size));
    PyErr_Clear();
    return std::nullopt;
  }

  pybind11::handle source_;
  std::string_view wanted_;
};

}  // namespace torsio::bindings
