/// @file
/// How to make an emulated knob.
///
/// Printed from the field lists in firmware/protocol/definition/ and emulator/definition/ by `./dev
/// generate`; change those instead.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "torsio/config.hpp"
#include "torsio/plant.hpp"

namespace torsio {

/// Options of an emulated knob: parts, hand and records.
struct EmulatorOptions {
  std::uint64_t seed = 0;           ///< of everything random: encoder noise, damaged reports
  double control_rate_hz = 1000.0;  ///< ticks in a second; 1000 to 2e4
  PlantParams plant{};              ///< its parts
  Hand hand = NoHand{};             ///< the hand on it
  std::string serial{};  ///< at most 16 ASCII characters; empty: derived from the device's name
  /// configuration at power-up; it replaces the stored one and the defaults
  std::optional<ActuatorConfig> actuator{};
  std::optional<ControlConfig> control{};  ///< the same
  std::optional<BoardConfig> board{};      ///< the same; a plant with electrics has use for it
  std::optional<GameConfig> game{};        ///< the same
  std::optional<ShaftConfig> shaft{};      ///< the same
  /// true: real time, as with hardware; false: virtual time, which passes only inside calls that
  /// wait, as fast as the computer can. The same calls with the same seed give the same bytes
  bool paced = false;
  bool log_truth = false;  ///< record what no sensor sees, once a tick
  /// record what enters the device, from power-up on, so that it can run again
  bool log_inputs = false;
};

}  // namespace torsio
