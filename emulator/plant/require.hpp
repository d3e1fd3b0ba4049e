/// @file
/// Refuses what a caller gave wrongly.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace torsio {

[[noreturn, gnu::cold, gnu::noinline]] inline void refuse(std::string_view message) {
  throw std::invalid_argument(std::string(message));
}

/// @throws std::invalid_argument with the message, unless the condition holds
[[gnu::always_inline]] inline void require(bool condition, std::string_view message) {
  if (!condition) [[unlikely]]
    refuse(message);
}

}  // namespace torsio
