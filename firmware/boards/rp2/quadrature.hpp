/// @file
/// The encoder: A and B decoded by a PIO state machine, so that no edge is lost however busy the
/// processor is.
#pragma once

#include <cstdint>

namespace torsio::boards {

/// @tparam unit of PIO, whose instruction memory the decoder has for itself
template <std::uint32_t unit>
class Quadrature {
 public:
  /// @param pin_a GPIO of A; B is the next one
  explicit Quadrature(std::uint8_t pin_a);

  /// The count now, four an encoder line, up when A leads B. Wraps at 32 bits.
  std::uint32_t read() const;

  /// Whether both channels have changed at once since the last call: what no knob does, and the
  /// count misses.
  bool take_lost_step();
};

}  // namespace torsio::boards
