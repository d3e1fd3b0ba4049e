/// @file
/// Refuses what a caller gave wrongly.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace torsio {

/// @throws std::invalid_argument with the message, unless the condition holds
inline void require(bool condition, std::string_view message) {
  if (!condition) [[unlikely]]
    throw std::invalid_argument(std::string(message));
}

}  // namespace torsio
