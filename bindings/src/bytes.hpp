/// @file
/// Bytes of Python to C++, and back.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <span>
#include <string_view>

namespace torsio::bindings {

/// Valid as long as the object.
inline std::span<const std::uint8_t> bytes_of(const pybind11::handle& bytes) {
  const auto view = bytes.cast<std::string_view>();
  return {reinterpret_cast<const std::uint8_t*>(view.data()), view.size()};
}

inline pybind11::bytes to_bytes(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace torsio::bindings
