/// @file
/// The user's plant as the emulator's own structures, which check it.
#pragma once

#include "emulator/encoder.hpp"
#include "emulator/plant/params.hpp"
#include "torsio/emulator.hpp"

namespace torsio {

[[nodiscard]] emulator::PlantParams to_emulator(const PlantParams& plant);
[[nodiscard]] emulator::EncoderParams encoder_of(const PlantParams& plant);

}  // namespace torsio
