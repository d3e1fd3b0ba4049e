// Parts of the emulated RP2350 that are too frequent for Python: time, and the PIO's machine.
#include <stdint.h>

struct Counter {
  uint64_t cycles;    // since power-up
  uint64_t deadline;  // the emulator stops before the first block that begins then or later
  void (*stop)(void* emulator);
};

/// Called by Unicorn before every basic block. A halfword of code is one cycle: short instructions
/// take one, and the long ones are mostly loads, stores, calls and floating point, which take two
/// or more.
void count_block(void* emulator, uint64_t address, uint32_t size, struct Counter* counter) {
  (void)address;
  if (counter->cycles >= counter->deadline) {
    counter->stop(emulator);
    return;
  }
  counter->cycles += (size + 1) / 2;
}

/// Called before every instruction, where somebody wants to know how many there are.
void count_instruction(void* emulator, uint64_t address, uint32_t size, uint64_t* instructions) {
  (void)emulator;
  (void)address;
  (void)size;
  ++*instructions;
}

struct Machine {
  uint32_t pc, x, y, isr, osr;
  uint32_t pins;         // levels, from the first input pin on
  uint32_t top, bottom;  // where the program wraps
  uint32_t level;        // words in the queue
  uint32_t queue[4];
  uint32_t flags;    // that the processor sees
  uint32_t unknown;  // an instruction that is not known here, else 0
  uint16_t memory[32];
};

static uint32_t source(struct Machine* m, unsigned number) {
  switch (number) {
    case 0:
      return m->pins;
    case 1:
      return m->x;
    case 2:
      return m->y;
    case 3:
      return 0;
    case 6:
      return m->isr;
    case 7:
      return m->osr;
    default:
      m->unknown = 0x10000 | number;
      return 0;
  }
}

static void store(struct Machine* m, unsigned number, uint32_t value) {
  switch (number) {
    case 1:
      m->x = value;
      break;
    case 2:
      m->y = value;
      break;
    case 3:
      break;
    case 5:
      m->pc = value & 31;
      break;
    case 6:
      m->isr = value;
      break;
    case 7:
      m->osr = value;
      break;
    default:
      m->unknown = 0x20000 | number;
  }
}

/// One instruction: as much of them as our program uses, shifting in to the left and out to the
/// right.
void execute(struct Machine* m, uint32_t code) {
  const unsigned bits = (code & 31) == 0 ? 32 : code & 31;
  const uint32_t mask = bits == 32 ? 0xFFFFFFFF : (1U << bits) - 1;
  const unsigned field = code >> 5 & 7;
  switch (code >> 13) {
    case 0:  // jmp, always or y--
      if (field == 0 || (field == 4 && m->y != 0)) m->pc = code & 31;
      if (field == 4) --m->y;
      if (field != 0 && field != 4) m->unknown = code;
      break;
    case 2: {  // in
      const uint32_t value = source(m, field) & mask;
      m->isr = bits == 32 ? value : m->isr << bits | value;
      break;
    }
    case 3: {  // out
      const uint32_t value = m->osr & mask;
      m->osr = bits == 32 ? 0 : m->osr >> bits;
      store(m, field, value);
      break;
    }
    case 4:  // push noblock
      if ((code & 0xA0) != 0) m->unknown = code;
      if (m->level < 4) m->queue[m->level++] = m->isr;
      m->isr = 0;
      break;
    case 5: {  // mov
      const uint32_t value = source(m, code & 7);
      store(m, field, (code >> 3 & 3) == 1 ? ~value : value);
      break;
    }
    case 6:  // irq, set and go on
      if ((code & 0x78) != 0) m->unknown = code;
      m->flags |= 1U << (code & 7);
      break;
    case 7:  // set
      store(m, field, code & 31);
      break;
    default:
      m->unknown = code;
  }
}

void run(struct Machine* m, uint64_t cycles) {
  for (; cycles > 0; --cycles) {
    const uint32_t code = m->memory[m->pc];
    m->pc = m->pc == m->top ? m->bottom : (m->pc + 1) & 31;
    execute(m, code);
  }
}

uint32_t pop(struct Machine* m) {
  const uint32_t word = m->queue[0];
  if (m->level == 0) return 0;
  --m->level;
  for (uint32_t n = 0; n < m->level; ++n) m->queue[n] = m->queue[n + 1];
  return word;
}
