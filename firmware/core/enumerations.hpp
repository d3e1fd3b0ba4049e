/// @file
/// The choices that the control mathematics has. They keep their number from the wire.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <cstdint>

namespace torsio::core {

/// Shape of a periodic torque.
enum class Waveform : std::uint8_t { sine, square, triangle, sawtooth_up, sawtooth_down };

/// Torque from one notch to the next: -T sin(2 pi u) at u pitches from a notch; -2 T u within half
/// a pitch; or linear within the width, beyond it T toward the notch.
enum class DetentProfile : std::uint8_t { sine, linear, click };

/// Shape of a texture's grains; noise draws a value for each and joins them smoothly.
enum class Grain : std::uint8_t { sine, square, triangle, noise };

/// How the desired torque is shared between motor and brake; docs/explanation/theory.md.
enum class Law : std::uint8_t {
  paper,        ///< the printed law, as it must be read
  compensated,  ///< the motor fills in what the brake does not hold, with its drag counted
  parallel,     ///< fixed shares without the sensor: it sticks, and is here to show that
  motor_only,   ///< no brake
  calibrated,   ///< as compensated, with a stiffness that is bounded by the parts
};

}  // namespace torsio::core
