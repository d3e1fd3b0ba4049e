/// @file
/// A board's answer about its wiring. The device keeps the rule and knows nothing of pins.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "protocol/configuration.hpp"

namespace torsio::device {

/// A pin that cannot have the job it is given.
struct PinConflict {
  std::uint8_t field = 0;  // of BoardConfig
  std::uint8_t pin = 0;    // its value
  std::string_view reason;
};

/// The first conflict of a wiring whose fields are each in range, with the pin of the encoder's
/// index; 0: it has none.
using WiringRule = std::optional<PinConflict> (*)(const protocol::BoardConfig&,
                                                  std::uint8_t index_pin);

/// Nothing is wired.
constexpr std::optional<PinConflict> any_wiring(const protocol::BoardConfig& /*config*/,
                                                std::uint8_t /*index_pin*/) {
  return {};
}

}  // namespace torsio::device
