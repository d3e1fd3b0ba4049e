/// @file
/// Counts the instructions of something that is done once a tick.
#pragma once

#include <cstdint>
#include <string_view>

#include "port.hpp"

namespace torsio::mcu {

// Whole times to and fro. Where the counter is coarse, enough of them to make that small.
#if defined(__ARM_FP)
inline constexpr std::uint32_t kTicks = 2048;
#else
inline constexpr std::uint32_t kTicks = 256;
#endif

template <class Tick>
[[gnu::always_inline]] inline std::uint32_t count_instructions(Tick&& tick) {
  std::uint32_t count = 0;
  const std::uint32_t start = instructions();
  for (std::uint32_t n = 0; n < kTicks; ++n) {
    count += (n & 64U) != 0 ? 1U : 0xFFFFFFFFU;
    tick(count);
  }
  return instructions() - start;
}

/// Calls `tick` with the count of a knob that moves to and fro, and prints `NAME EFFECTS
/// INSTRUCTIONS`: per call, without the loop's own, and a hundred times too large so that it has
/// two decimals.
template <class Tick>
void measure(std::string_view name, unsigned effects, Tick&& tick) {
  const std::uint32_t loop = count_instructions([](std::uint32_t count) {
    __asm volatile("" : : "r"(count));
  });
  const std::uint32_t all = count_instructions(tick);
  for (const char c : name) {
    const char text[2] = {c, 0};
    print(text);
  }
  print(" ");
  print(effects);
  print(" ");
  print(static_cast<std::uint32_t>(std::uint64_t{all - loop} * 100 / kTicks));
  print("\n");
}

}  // namespace torsio::mcu
