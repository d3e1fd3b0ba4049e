/// @file
/// The watchdog's registers as numbers; see hardware/fake.hpp.
#pragma once

#include <array>
#include <cstdint>

// NOLINTBEGIN: these names are the SDK's.
namespace fake {
struct Watchdog {
  std::uint32_t reason = 0;
  std::array<std::uint32_t, 8> scratch{};
  std::uint32_t time_ms = 0;
  int updates = 0;
};
inline Watchdog watchdog;
/// watchdog_enable() leaves this in scratch[4]. It tells its restart from the boot ROM's own.
inline constexpr std::uint32_t kEnabled = 0x6ab73121;
}  // namespace fake
inline fake::Watchdog* const watchdog_hw = &fake::watchdog;
// NOLINTEND
