/// @file
/// A seeded generator of random numbers, the same on every platform.
#pragma once

#include <cstdint>

namespace torsio::emulator {

/// SplitMix64: a small seeded generator whose sequence is the same on every platform, which
/// std::uniform_real_distribution does not promise.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  [[nodiscard]] std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }

  /// Uniform in [0, 1).
  [[nodiscard]] double uniform() { return static_cast<double>(next() >> 11U) * 0x1.0p-53; }

  /// True with the given probability; draws nothing if that is 0.
  [[nodiscard]] bool happens(double probability) {
    return probability > 0.0 && uniform() < probability;
  }

 private:
  std::uint64_t state_;
};

}  // namespace torsio::emulator
