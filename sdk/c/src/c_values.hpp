/// @file
/// Values of C's structures, which may be anything, as C++ has them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "torsio/error.hpp"
#include "torsio/fields.hpp"
#include "torsio/plant_fields.hpp"
#include "torsio_types.h"

namespace torsio::c {

constexpr std::size_t kMostElements = std::size_t{1} << 20U;  // in one array; more is a slip

/// The name of a value in messages, nullptr if there is none.
template <class Enum>
const char* value_name(std::int32_t value) {
  const auto& names = Names<Enum>::values;
  if (value < 0 || static_cast<std::size_t>(value) >= names.size()) return nullptr;
  return names.at(static_cast<std::size_t>(value)).data();  // they are literals: a 0 follows
}

/// @throws InvalidArgument that names the field
template <class Enum>
Enum choice(std::int32_t value, const char* field) {
  if (value_name<Enum>(value) == nullptr) {
    throw InvalidArgument(std::string(field) + " is " + std::to_string(value) +
                          ", which is not one of its values: 0 to " +
                          std::to_string(Names<Enum>::values.size() - 1));
  }
  return static_cast<Enum>(value);
}

/// Other languages may have put more into the byte than 0 and 1.
inline bool flag(const bool& value) {
  unsigned char byte = 0;
  std::memcpy(&byte, &value, sizeof byte);
  return byte != 0;
}

/// @throws InvalidArgument that names the array
inline void check_array(const void* elements, std::size_t count, const char* name) {
  if (count != 0 && elements == nullptr) {
    throw InvalidArgument(std::string(name) + " is NULL, and " + name + "_count is " +
                          std::to_string(count) + "; give both or neither");
  }
  if (count > kMostElements) {
    throw InvalidArgument(std::string(name) + "_count is " + std::to_string(count) +
                          "; at most 2^20");
  }
}

inline void take(std::vector<double>& to, const double* numbers, std::size_t count,
                 const char* name) {
  check_array(numbers, count, name);
  to.assign(numbers, numbers + count);
}

/// Without knots it stays as it is by default.
inline void take(Profile& to, const torsio_knot* knots, std::size_t count, const char* name) {
  check_array(knots, count, name);
  if (count == 0) return;
  to.clear();
  for (std::size_t i = 0; i < count; ++i) to.push_back({knots[i].time_s, knots[i].value});
}

/// Cuts what is too long, and between two characters of UTF-8.
template <std::size_t size>
void copy(char (&to)[size], std::string_view text) {
  std::size_t length = std::min(text.size(), size - 1);
  if (length < text.size()) {
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80U) --length;
  }
  std::memcpy(to, text.data(), length);
  std::memset(to + length, 0, size - length);
}

/// @throws InvalidArgument that names what is NULL
template <class T>
T& need(T* pointer, const char* name) {
  if (pointer == nullptr) throw InvalidArgument(std::string(name) + " is NULL");
  return *pointer;
}

inline void check_size(std::size_t given, std::size_t own, const std::string& what,
                       const std::string& advice) {
  if (given == own) return;
  throw InvalidArgument(what + " is " + std::to_string(given) + ", and this library's has " +
                        std::to_string(own) + " bytes; " + advice +
                        ", and use header and library of the same version");
}

/// A structure that begins with its size. @throws InvalidArgument
template <class C>
C& need_sized(C* structure, const char* name, const char* type) {
  C& known = need(structure, name);
  check_size(known.struct_size, sizeof(C), std::string(name) + "->struct_size",
             std::string("call ") + type + "_init() first");
  return known;
}

/// The elements of an array. @throws InvalidArgument
template <class C>
void need_array(const C* elements, std::size_t capacity, std::size_t item_size, const char* name,
                const char* type) {
  check_size(item_size, sizeof(C), "item_size",
             std::string("give sizeof(") + type + ") or its like");
  if (capacity != 0) static_cast<void>(need(elements, name));
}

}  // namespace torsio::c
