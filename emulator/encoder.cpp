#include "emulator/encoder.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "emulator/plant/portable_math.hpp"

namespace torsio::emulator {
namespace {

/// The largest integer that is not above the value. On plain x86-64 std::floor is a library call
/// that takes longer than the rest of a sample.
std::int64_t floor_to_integer(double value) {
  const auto truncated = static_cast<std::int64_t>(value);
  return truncated - (static_cast<double>(truncated) > value ? 1 : 0);
}

}  // namespace

EncoderParams encoder_of(const PlantParams& plant) {
  return {.counts_per_rev = plant.counts_per_rev,
          .rounding = plant.encoder_rounding,
          .phase_counts = plant.encoder_phase_counts,
          .noise_counts = plant.encoder_noise_counts,
          .index = plant.encoder_index};
}

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

Encoder::Encoder(const EncoderParams& params)
    : params_(params),
      counts_per_rad_(params.direction * (params.counts_per_rev / Angle::kTurnRad)),
      random_(params.seed) {
  validate(params);
}

double Encoder::draw_noise_counts() {
  // Box and Muller; the second value of the pair is dropped to keep the state a single number.
  // 1 - u lies in (0, 1], where the logarithm is finite.
  const double radius = std::sqrt(-2.0 * log_of(1.0 - random_.uniform()));
  return params_.noise_counts * radius * cos_of_turns(random_.uniform());
}

bool Encoder::index() {
  constexpr double kSparks = 0.01;  // of all samples
  const std::int64_t counts = params_.counts_per_rev;
  const bool pulse = within_counts_ % counts == 0;
  switch (params_.index) {
    case IndexPulse::missing:
      return false;
    case IndexPulse::doubled:
      return pulse || (within_counts_ - counts / 3) % counts == 0;
    case IndexPulse::noisy:
      return pulse != (random_.uniform() < kSparks);
    case IndexPulse::works:
      break;
  }
  return pulse;
}

std::uint32_t Encoder::sample(const Angle& angle) {
  // Whole turns are counted in integers, so that the part which is rounded stays small.
  double within = angle.fraction_rad * counts_per_rad_ + params_.phase_counts;
  if (params_.noise_counts > 0.0) within += draw_noise_counts();
  if (params_.rounding == EncoderRounding::nearest) within += 0.5;
  const std::int64_t whole = params_.direction * angle.revolutions;
  within_counts_ = floor_to_integer(within);
  // Unsigned arithmetic, so that wrapping is defined whatever the distance.
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(whole) * params_.counts_per_rev +
                                    static_cast<std::uint64_t>(within_counts_));
}

}  // namespace torsio::emulator
