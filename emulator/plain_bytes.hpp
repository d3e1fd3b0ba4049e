/// @file
/// Plain values as bytes, for the same program to read again.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace torsio::emulator {

template <class T>
void add_bytes(std::vector<std::uint8_t>& into, std::span<const T> values) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(values.data());
  into.insert(into.end(), bytes, bytes + values.size_bytes());
}

/// @param from at least as many bytes as the values have
/// @returns the bytes that follow
template <class T>
std::span<const std::uint8_t> take_bytes(std::span<const std::uint8_t> from, std::span<T> values) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (!values.empty()) std::memcpy(values.data(), from.data(), values.size_bytes());
  return from.subspan(values.size_bytes());
}

}  // namespace torsio::emulator
