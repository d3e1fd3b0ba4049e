/// @file
/// What enters an emulated device from outside, so that it can run again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace torsio::emulator {

/// In brackets: what the bytes are; numbers are little endian.
enum class InputKind : std::uint8_t {
  stored,          ///< what is in the storage from now on (both slots)
  power,           ///< (0 or 1)
  connected,       ///< the bus (0 or 1)
  output,          ///< a report that has arrived (64 bytes)
  feature,         ///< a report (any length)
  game_output,     ///< a report of the game interface (any length)
  game_feature,    ///< the same (any length)
  buttons,         ///< pressed ones (a bit each)
  emergency_stop,  ///< (0 or 1)
  actuator_fault,  ///< (0 or 1)
  power_faults,    ///< which, as bits of the faults; 0: the one of the actuator (u32)
  missed_ticks,    ///< before the next one (u32)
  power_cut,       ///< in the next save, after so many bytes (u32)
  counts,          ///< of the encoder, one control tick for each (u32 each)
};

/// Their names, in this order.
inline constexpr std::array<std::string_view, 14> kInputKinds{
    "stored",       "power",        "connected", "output",         "feature",
    "game_output",  "game_feature", "buttons",   "emergency_stop", "actuator_fault",
    "power_faults", "missed_ticks", "power_cut", "counts"};

struct DeviceInput {
  std::uint64_t tick = 0;  ///< control ticks that ran before it, since the first power-up
  InputKind kind{};
  std::vector<std::uint8_t> bytes{};
};

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
  /// What was gathered since the last call.
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
