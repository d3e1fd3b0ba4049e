#include "emulator/encoder.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace torsio::emulator {
namespace {

/// SplitMix64 (Steele, Lea, Flood 2014): the same sequence with every compiler and library, which
/// the distributions of <random> do not promise.
std::uint64_t next_random(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15u;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// Uniform in (0, 1), never an end.
double next_uniform(std::uint64_t& state) {
  return (static_cast<double>(next_random(state) >> 11) + 0.5) * 0x1p-53;
}

/// The largest integer that is not above the value. std::floor is a call into the mathematics
/// library on plain x86-64 and takes longer than all the rest of a sample.
std::int64_t floor_to_integer(double value) {
  const auto truncated = static_cast<std::int64_t>(value);
  return truncated - (static_cast<double>(truncated) > value ? 1 : 0);
}

}  // namespace

void validate(const EncoderParams& params) {
  const auto refuse = [](const char* field, const char* rule, double value) {
    throw std::invalid_argument(std::string("encoder: ") + field + " must be " + rule + ", is " +
                                std::to_string(value));
  };
  if (params.counts_per_rev < 1) refuse("counts_per_rev", ">= 1", params.counts_per_rev);
  if (params.direction != 1 && params.direction != -1) {
    refuse("direction", "+1 or -1", params.direction);
  }
  if (!std::isfinite(params.phase_counts)) refuse("phase_counts", "finite", params.phase_counts);
  if (!std::isfinite(params.noise_counts) || params.noise_counts < 0.0) {
    refuse("noise_counts", "finite and >= 0", params.noise_counts);
  }
}

Encoder::Encoder(const EncoderParams& params) : params_(params), noise_state_(params.seed) {
  validate(params);
}

double Encoder::draw_noise_counts() {
  // Box and Muller; the second value of the pair is dropped to keep the state a single number.
  const double radius = std::sqrt(-2.0 * std::log(next_uniform(noise_state_)));
  return params_.noise_counts * radius *
         std::cos(2.0 * std::numbers::pi * next_uniform(noise_state_));
}

std::uint32_t Encoder::sample(const Angle& angle) {
  // Whole turns are counted in integers, so that the part which is rounded stays small.
  const double counts_per_rad = params_.counts_per_rev / Angle::kTurnRad;
  double within = params_.direction * angle.fraction_rad * counts_per_rad + params_.phase_counts;
  if (params_.noise_counts > 0.0) within += draw_noise_counts();
  if (params_.rounding == Rounding::nearest) within += 0.5;
  const std::int64_t whole = params_.direction * angle.revolutions;
  // Unsigned arithmetic, so that wrapping is defined whatever the distance.
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(whole) * params_.counts_per_rev +
                                    static_cast<std::uint64_t>(floor_to_integer(within)));
}

}  // namespace torsio::emulator
