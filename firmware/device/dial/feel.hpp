/// @file
/// What the control interrupt is to render on a dial: one word, so that it never sees half of it.
#pragma once

#include <cstdint>

namespace torsio::device::dial {

inline constexpr std::uint32_t kFullFeel = 128;

struct Feel {
  std::uint32_t word = kFullFeel;

  static constexpr Feel make(std::uint32_t detents, std::uint32_t pulse, bool goes_on,
                             std::uint32_t number) {
    return {detents | pulse << 8 | (goes_on ? 1U << 16 : 0U) | number << 17};
  }
  /// Strength of the detents, of kFullFeel.
  constexpr std::uint32_t detents() const { return word & 0xFF; }
  /// Strength of a pulse, of kFullFeel.
  constexpr std::uint32_t pulse() const { return word >> 8 & 0xFF; }
  /// Pulses follow one another.
  constexpr bool goes_on() const { return (word >> 16 & 1U) != 0; }
  /// Another number asks for one more pulse.
  constexpr std::uint32_t number() const { return word >> 17; }
};

}  // namespace torsio::device::dial
