/// @file
/// What the RP2350 remembers of its last reset, as a number; see hardware/fake.hpp.
#pragma once

#include <cstdint>

// NOLINTBEGIN: these names are the SDK's.
inline constexpr std::uint32_t POWMAN_CHIP_RESET_HAD_POR_BITS = 1U << 16;
inline constexpr std::uint32_t POWMAN_CHIP_RESET_HAD_BOR_BITS = 1U << 17;
inline constexpr std::uint32_t POWMAN_CHIP_RESET_HAD_RUN_LOW_BITS = 1U << 18;
namespace fake {
struct PowerManager {
  std::uint32_t chip_reset = 0;
};
inline PowerManager power_manager;
}  // namespace fake
inline fake::PowerManager* const powman_hw = &fake::power_manager;
// NOLINTEND
