/// @file
/// Telemetry that waits to be read. Fixed memory; when it is full the newest wins.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "torsio/telemetry.hpp"

namespace torsio {

/// Not synchronised: its owner's lock guards it.
class SampleRing {
 public:
  explicit SampleRing(std::size_t capacity) : samples_(std::max<std::size_t>(capacity, 1)) {}

  /// @returns false if the oldest sample was lost to make room
  bool push(const TelemetrySample& sample) {
    samples_[(first_ + size_) % samples_.size()] = sample;
    if (size_ < samples_.size()) {
      ++size_;
      return true;
    }
    first_ = (first_ + 1) % samples_.size();
    return false;
  }

  /// Moves the oldest samples out. @returns how many
  std::size_t pop(std::span<TelemetrySample> out) {
    const std::size_t count = std::min(out.size(), size_);
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = samples_[first_];
      first_ = (first_ + 1) % samples_.size();
    }
    size_ -= count;
    return count;
  }

  /// The oldest sample; there must be one.
  [[nodiscard]] const TelemetrySample& front() const { return samples_[first_]; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return samples_.size(); }
  void clear() { size_ = 0; }

 private:
  std::vector<TelemetrySample> samples_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace torsio
