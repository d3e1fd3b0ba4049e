/// @file
/// The configuration in two slots of non-volatile memory. A save goes into the slot that does not
/// hold the newest configuration, so that a power cut at any byte leaves the newest one intact.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "device/config.hpp"

namespace torsio::device {

inline constexpr std::size_t kSlotSize = 512;  // whole pages of the smallest flash in use
using SlotBytes = std::array<std::uint8_t, kSlotSize>;

struct StoredSlots {
  std::array<SlotBytes, 2> slot{};
};

/// Where the slots' bytes are. A board's are in its flash, and fit on no stack.
using SlotView = std::span<const std::uint8_t, kSlotSize>;
struct SlotViews {
  std::array<SlotView, 2> slot;
  SlotViews(SlotView first, SlotView second) : slot{first, second} {}
  // NOLINTNEXTLINE(google-explicit-constructor): to have the bytes is to know where they are
  SlotViews(const StoredSlots& stored) : SlotViews(stored.slot[0], stored.slot[1]) {}
};

/// A slot to be written.
struct SlotWrite {
  std::uint8_t slot = 0;
  SlotBytes bytes{};
};

/// Slots as new flash has them.
constexpr StoredSlots empty_slots() {
  StoredSlots slots;
  for (SlotBytes& bytes : slots.slot) bytes.fill(0xFF);
  return slots;
}

/// CRC-32 (ISO-HDLC, as in Ethernet and zlib).
std::uint32_t crc32(std::span<const std::uint8_t> bytes);

/// Checksum of the values that a calibration is about: actuator and shaft.
std::uint32_t values_checksum(const Config& config);

/// The calibration as it is true of the values now.
protocol::CalibrationConfig calibration_now(const Config& config);

/// @param moves_parts the outputs reach a real motor: torques and speed are held low until the
/// parts are confirmed and their values are measured or stated
Trust trust_in(const Config& config, bool moves_parts);

class ConfigStore {
 public:
  /// @param slots read here, not later
  /// @param rule  a configuration with another wiring counts as none
  explicit ConfigStore(const SlotViews& slots, WiringRule rule = any_wiring);

  /// The newest intact configuration; nothing if neither slot holds one of this layout.
  const std::optional<Config>& loaded() const { return loaded_; }

  /// The write that saves `config`. Nothing is taken as saved before written().
  void prepare(const Config& config, SlotWrite& write) const;
  SlotWrite prepare(const Config& config) const {
    SlotWrite write;
    prepare(config, write);
    return write;
  }
  void written();

  /// How many saves there were, ever.
  std::uint32_t saves() const { return saves_; }

 private:
  std::optional<Config> loaded_;
  std::uint32_t saves_ = 0;
  std::uint8_t newest_slot_ = 1;
};

}  // namespace torsio::device
