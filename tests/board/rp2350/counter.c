// Time in the emulated Cortex-M33: called by Unicorn before every basic block. In C, because it is
// called some 100,000 times in an emulated millisecond.
#include <stdint.h>

struct Counter {
  uint64_t cycles;    // since power-up
  uint64_t deadline;  // the emulator stops before the first block that begins then or later
  void (*stop)(void* emulator);
};

/// A halfword of code is one cycle: short instructions take one, and the long ones are mostly loads,
/// stores, calls and floating point, which take two or more.
void count_block(void* emulator, uint64_t address, uint32_t size, struct Counter* counter) {
  (void)address;
  if (counter->cycles >= counter->deadline) {
    counter->stop(emulator);
    return;
  }
  counter->cycles += (size + 1) / 2;
}
