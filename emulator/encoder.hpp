/// @file
/// The emulated encoder: angles to counts, with rounding, phase and noise.
#pragma once

#include <cstdint>

#include "emulator/plant/params.hpp"
#include "emulator/plant/state.hpp"
#include "emulator/random.hpp"

namespace torsio::emulator {

/// An incremental encoder on the knob's shaft, after quadrature decoding.
struct EncoderParams {
  std::uint32_t counts_per_rev = PlantParams{}.counts_per_rev;  ///< >= 1
  EncoderRounding rounding = EncoderRounding::floor;
  std::int8_t direction = 1;  ///< +1, or -1 if it counts down along positive angle
  double phase_counts = 0.0;  ///< where in a count angle 0 lies; finite
  /// Part: standard deviation of noise that is added to the angle before rounding, >= 0 counts.
  double noise_counts = 0.0;
  std::uint64_t seed = 0;  ///< of the noise
  IndexPulse index = IndexPulse::works;
};

/// The encoder of a plant, without a seed.
[[nodiscard]] EncoderParams encoder_of(const PlantParams& plant);

/// @throws std::invalid_argument that names the field, its range and its value
void validate(const EncoderParams& params);

class Encoder {
 public:
  /// @throws std::invalid_argument as validate() does
  explicit Encoder(const EncoderParams& params = {});

  /// Samples the angle:  rounding(direction angle counts_per_rev / (2 pi) + phase + noise).
  /// The counter wraps at 32 bits. With noise, each call draws from the seeded sequence.
  [[nodiscard]] std::uint32_t sample(const Angle& angle);

  /// The level of the index at the last sample: high for the count 0 of a turn. Sparks draw from
  /// the seeded sequence.
  [[nodiscard]] bool index();

  [[nodiscard]] const EncoderParams& params() const { return params_; }

 private:
  [[nodiscard]] double draw_noise_counts();

  EncoderParams params_;
  double counts_per_rad_;  // with its sign; a division takes as long as all the rest of a sample
  Random random_;
  std::int64_t within_counts_ = 0;
};

}  // namespace torsio::emulator
