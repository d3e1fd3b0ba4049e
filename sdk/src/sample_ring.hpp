/// @file
/// Telemetry that waits to be read. Fixed memory; when it is full the newest wins.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "torsio/telemetry.hpp"

namespace torsio {

/// Not synchronised: its owner's lock guards it.
class SampleRing {
 public:
  explicit SampleRing(std::size_t capacity) : capacity_(std::max<std::size_t>(capacity, 1)) {
    samples_.reserve(capacity_);  // its pages are touched only as samples come
  }

  /// @returns false if the oldest sample was lost to make room
  bool push(const TelemetrySample& sample) {
    const std::size_t at = (first_ + size_) % capacity_;
    if (at == samples_.size()) {
      samples_.push_back(sample);
    } else {
      samples_[at] = sample;
    }
    if (size_ < capacity_) {
      ++size_;
      return true;
    }
    first_ = (first_ + 1) % capacity_;
    return false;
  }

  /// Moves the oldest samples out. @returns how many
  std::size_t pop(std::span<TelemetrySample> out) {
    const std::size_t count = std::min(out.size(), size_);
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = samples_[first_];
      first_ = (first_ + 1) % capacity_;
    }
    size_ -= count;
    // Where little waits, little memory serves.
    if (size_ == 0) first_ = 0;
    return count;
  }

  /// The oldest sample; there must be one.
  [[nodiscard]] const TelemetrySample& front() const { return samples_[first_]; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  void clear() { first_ = size_ = 0; }

 private:
  const std::size_t capacity_;
  std::vector<TelemetrySample> samples_;  // grows up to the capacity
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace torsio
