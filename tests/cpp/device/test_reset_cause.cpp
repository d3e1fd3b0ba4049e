// Why a board started, and whether its stack is whole, on a chip that is made of numbers.
#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>
#include <utility>

#include "boards/rp2/reset_cause.cpp"

extern "C" std::uint32_t __StackBottom;  // the linker's on a board
std::uint32_t __StackBottom = 0;

using namespace torsio::boards;
using torsio::protocol::ResetCause;

namespace {

/// The chip starts anew and knows why; scratch registers stay.
ResetCause start(std::uint32_t chip, bool by_watchdog) {
  fake::watchdog.reason = by_watchdog ? 1 : 0;
  fake::watchdog.scratch[4] = fake::kEnabled;  // as the program before has left it
  fake::power_manager.chip_reset = chip;
  return take_reset_cause();
}

}  // namespace

TEST_CASE("what the chip knows of its start is told, a watchdog's before the older cause") {
  fake::watchdog = {};
  for (const auto& [bits, cause] :
       {std::pair{POWMAN_CHIP_RESET_HAD_RUN_LOW_BITS, ResetCause::reset_pin},
        {POWMAN_CHIP_RESET_HAD_BOR_BITS, ResetCause::brown_out},
        {POWMAN_CHIP_RESET_HAD_POR_BITS, ResetCause::power},
        {0U, ResetCause::unknown}}) {
    CHECK(start(bits, false) == cause);
    CHECK(start(bits, true) == ResetCause::watchdog);
  }
}

TEST_CASE("the boot ROM's start of new firmware is no hanging program, nor what was before it") {
  fake::watchdog = {.reason = 1};  // with 0 in scratch[4], as the boot ROM leaves it
  fake::power_manager.chip_reset = POWMAN_CHIP_RESET_HAD_POR_BITS;
  CHECK(take_reset_cause() == ResetCause::unknown);
}

TEST_CASE("a program that has lost its way leaves word of it, once and for the watchdog's reset") {
  fake::watchdog = {};
  for (const ResetCause why : {ResetCause::stack, ResetCause::hard_fault}) {
    leave_reset_cause(why);
    CHECK(start(0, true) == why);
    CHECK(start(0, true) == ResetCause::watchdog);
  }
  leave_reset_cause(ResetCause::stack);
  CHECK(start(POWMAN_CHIP_RESET_HAD_POR_BITS, false) == ResetCause::power);
  CHECK(start(0, true) == ResetCause::watchdog);
  // Without the mark the register is no cause: it has any value at first.
  fake::watchdog.scratch[0] = static_cast<std::uint32_t>(ResetCause::stack);
  CHECK(start(0, true) == ResetCause::watchdog);
}

TEST_CASE("a stack that has been written beyond its end is not whole") {
  __StackBottom = 0;
  CHECK_FALSE(stack_is_whole());
  guard_stack();
  CHECK(stack_is_whole());
  __StackBottom ^= 1;
  CHECK_FALSE(stack_is_whole());
}
