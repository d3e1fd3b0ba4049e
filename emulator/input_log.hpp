/// @file
/// Gathers what enters an emulated device from outside, so that it can run again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "torsio/plant.hpp"

namespace torsio::emulator {

/// Gathers inputs in order; counts of ticks on end become one.
class InputLog {
 public:
  void add(InputKind kind, const std::uint8_t* bytes, std::size_t size) {
    log_.push_back({ticks_, kind, {bytes, bytes + size}});
  }
  void add(InputKind kind, std::uint8_t byte) { add(kind, &byte, 1); }
  void add_number(InputKind kind, std::uint32_t number) {
    const std::array<std::uint8_t, 4> bytes = little_endian(number);
    add(kind, bytes.data(), bytes.size());
  }
  void add_tick(std::uint32_t count) {
    if (log_.empty() || log_.back().kind != InputKind::counts) {
      log_.push_back({ticks_, InputKind::counts, {}});
    }
    const std::array<std::uint8_t, 4> bytes = little_endian(count);
    log_.back().bytes.insert(log_.back().bytes.end(), bytes.begin(), bytes.end());
    ++ticks_;
  }
  /// Inputs since the last call.
  [[nodiscard]] std::vector<DeviceInput> take() {
    std::vector<DeviceInput> taken;
    taken.swap(log_);
    return taken;
  }

 private:
  static std::array<std::uint8_t, 4> little_endian(std::uint32_t number) {
    return {static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8U),
            static_cast<std::uint8_t>(number >> 16U), static_cast<std::uint8_t>(number >> 24U)};
  }

  std::uint64_t ticks_ = 0;
  std::vector<DeviceInput> log_;
};

}  // namespace torsio::emulator
