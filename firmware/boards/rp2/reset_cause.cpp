#include "boards/rp2/reset_cause.hpp"

#include <hardware/structs/watchdog.h>
#include <hardware/watchdog.h>
#if PICO_RP2040
#include <hardware/structs/vreg_and_chip_reset.h>
#else
#include <hardware/structs/powman.h>
#endif

#include <cstdint>

// The stack's lowest word, from the linker.
extern "C" std::uint32_t __StackBottom;

namespace torsio::boards {
namespace {

using protocol::ResetCause;

// In a scratch register, which keeps its value through a reset; the low byte is the cause.
constexpr std::uint32_t kMark = 0x70C51000;
constexpr std::uint32_t kStackMark = 0x57AC1E0D;

/// The chip's own knowledge.
ResetCause chips_cause() {
  if (watchdog_enable_caused_reboot()) return ResetCause::watchdog;
  // The boot ROM starts a file that was copied by the watchdog too, and the older causes are past.
  if (watchdog_hw->reason != 0) return ResetCause::unknown;
#if PICO_RP2040
  // A supply that was too low looks like one that was switched on.
  const std::uint32_t chip = vreg_and_chip_reset_hw->chip_reset;
  if ((chip & VREG_AND_CHIP_RESET_CHIP_RESET_HAD_RUN_BITS) != 0) return ResetCause::reset_pin;
  if ((chip & VREG_AND_CHIP_RESET_CHIP_RESET_HAD_POR_BITS) != 0) return ResetCause::power;
#else
  const std::uint32_t chip = powman_hw->chip_reset;
  if ((chip & POWMAN_CHIP_RESET_HAD_RUN_LOW_BITS) != 0) return ResetCause::reset_pin;
  if ((chip & POWMAN_CHIP_RESET_HAD_BOR_BITS) != 0) return ResetCause::brown_out;
  if ((chip & POWMAN_CHIP_RESET_HAD_POR_BITS) != 0) return ResetCause::power;
#endif
  return ResetCause::unknown;
}

}  // namespace

ResetCause take_reset_cause() {
  const std::uint32_t left = watchdog_hw->scratch[0];
  watchdog_hw->scratch[0] = 0;
  const ResetCause cause = chips_cause();
  const bool marked = (left & ~0xFFU) == kMark;
  return cause == ResetCause::watchdog && marked ? static_cast<ResetCause>(left & 0xFFU) : cause;
}

void leave_reset_cause(ResetCause why) {
  watchdog_hw->scratch[0] = kMark | static_cast<std::uint32_t>(why);
}

void guard_stack() { __StackBottom = kStackMark; }

bool stack_is_whole() {
  // Volatile: the compiler does not know who else may write there.
  return *static_cast<volatile std::uint32_t*>(&__StackBottom) == kStackMark;
}

}  // namespace torsio::boards
