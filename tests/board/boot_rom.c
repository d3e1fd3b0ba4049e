// A boot ROM for the emulated RP2040: what the firmware asks of the real one, and no more. Written
// from chapter 2.8 of the datasheet; nothing of Raspberry Pi's ROM is in it.
//
// What needs the flash chip is done by the test bench: it stops at these breakpoints and finds the
// arguments in r0 to r3.
#include <stdint.h>

#define FUNCTION __attribute__((used)) static
#define TRAP(name, number)                                                              \
  __attribute__((naked, used, noinline)) static uint32_t name(                          \
      __attribute__((unused)) uint32_t a, __attribute__((unused)) uint32_t b,           \
      __attribute__((unused)) uint32_t c, __attribute__((unused)) uint32_t d) {         \
    __asm volatile("bkpt " #number "\n bx lr");                                         \
  }

TRAP(erase_begins, 1)
TRAP(program_begins, 2)
TRAP(flash_is_busy, 3)
TRAP(reset_to_usb_boot, 4)
TRAP(connect_internal_flash, 5)
TRAP(flash_flush_cache, 6)

FUNCTION void nothing(void) {}

FUNCTION void wait_for_flash(void) {
  while (flash_is_busy(0, 0, 0, 0) != 0) {
  }
}
FUNCTION void flash_range_erase(uint32_t address, uint32_t count, uint32_t block, uint32_t command) {
  erase_begins(address, count, block, command);
  wait_for_flash();
}
FUNCTION void flash_range_program(uint32_t address, uint32_t data, uint32_t count) {
  program_begins(address, data, count, 0);
  wait_for_flash();
}

// About as fast as the real one, because the firmware's main loop spends much time here. `volatile`
// keeps the compiler from making calls of these loops.
FUNCTION uint8_t* fill(uint8_t* to, uint8_t value, uint32_t count) {
  volatile uint8_t* byte = to;
  for (; count > 0 && ((uint32_t)byte & 3) != 0; --count) *byte++ = value;
  volatile uint32_t* word = (volatile uint32_t*)byte;
  const uint32_t values = value * 0x01010101U;
  for (; count >= 16; count -= 16, word += 4) word[0] = word[1] = word[2] = word[3] = values;
  for (; count >= 4; count -= 4) *word++ = values;
  for (byte = (volatile uint8_t*)word; count > 0; --count) *byte++ = value;
  return to;
}
FUNCTION uint8_t* copy(uint8_t* to, const uint8_t* from, uint32_t count) {
  volatile uint8_t* byte = to;
  if ((((uint32_t)to ^ (uint32_t)from) & 3) == 0) {
    for (; count > 0 && ((uint32_t)byte & 3) != 0; --count) *byte++ = *from++;
    volatile uint32_t* word = (volatile uint32_t*)byte;
    const uint32_t* words = (const uint32_t*)from;
    for (; count >= 16; count -= 16, word += 4, words += 4) {
      const uint32_t a = words[0], b = words[1], c = words[2], d = words[3];
      word[0] = a;
      word[1] = b;
      word[2] = c;
      word[3] = d;
    }
    for (; count >= 4; count -= 4) *word++ = *words++;
    byte = (volatile uint8_t*)word;
    from = (const uint8_t*)words;
  }
  for (; count > 0; --count) *byte++ = *from++;
  return to;
}
FUNCTION uint32_t count_ones(uint32_t value) {
  uint32_t ones = 0;
  for (; value != 0; value &= value - 1) ++ones;
  return ones;
}
FUNCTION uint32_t leading_zeros(uint32_t value) {
  uint32_t zeros = value == 0;
  for (uint32_t bits = 16; bits > 0; bits >>= 1) {
    if (value >> (32 - bits) != 0) continue;
    zeros += bits;
    value <<= bits;
  }
  return zeros;
}
FUNCTION uint32_t trailing_zeros(uint32_t value) {
  return value == 0 ? 32 : count_ones((value & -value) - 1);
}
FUNCTION uint32_t reverse(uint32_t value) {
  uint32_t result = 0;
  for (int i = 0; i < 32; ++i, value >>= 1) result = (result << 1) | (value & 1);
  return result;
}

FUNCTION uint32_t lookup(const uint16_t* table, uint32_t code) {
  for (; table[0] != 0; table += 2) {
    if (table[0] == code) return table[1];
  }
  return 0;
}

/// Copies the second stage from the flash's first page to the end of the RAM and runs it there.
/// With 0 in lr it goes on to the program behind it.
__attribute__((used, noreturn)) static void start(void) {
  uint8_t* const stage2 = (uint8_t*)0x20041F00;
  copy(stage2, (const uint8_t*)0x10000000, 252);
  register uint32_t entry __asm("r0") = (uint32_t)stage2 + 1;
  __asm volatile("movs r1, #0\n mov lr, r1\n bx r0" ::"r"(entry) : "r1", "lr");
  __builtin_unreachable();
}

FUNCTION void lost(void) {
  for (;;) __asm volatile("bkpt 255");
}

__asm(
    ".macro entry first, second, function\n"
    "  .hword \\first | (\\second << 8), \\function + 1\n"
    ".endm\n"
    ".section .header, \"a\"\n"
    "  .word 0x20041F00, start + 1, lost + 1, lost + 1\n"
    "  .byte 'M', 'u', 1, 3\n"
    "  .hword functions, no_data, lookup + 1\n"
    "  .align 2\n"
    "functions:\n"
    "  entry 'P', '3', count_ones\n"
    "  entry 'L', '3', leading_zeros\n"
    "  entry 'T', '3', trailing_zeros\n"
    "  entry 'R', '3', reverse\n"
    "  entry 'M', 'S', fill\n"
    "  entry 'S', '4', fill\n"
    "  entry 'M', 'C', copy\n"
    "  entry 'C', '4', copy\n"
    "  entry 'I', 'F', connect_internal_flash\n"
    "  entry 'E', 'X', nothing\n"
    "  entry 'R', 'E', flash_range_erase\n"
    "  entry 'R', 'P', flash_range_program\n"
    "  entry 'F', 'C', flash_flush_cache\n"
    "  entry 'C', 'X', flash_flush_cache\n"
    "  entry 'U', 'B', reset_to_usb_boot\n"
    "no_data:\n"
    "  .word 0\n"
    ".text\n");
