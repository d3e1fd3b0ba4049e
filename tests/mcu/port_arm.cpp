// Semihosting for output and the end of the program. QEMU and tests/mcu/m0plus.mjs both serve it.
#include "port.hpp"

namespace torsio::mcu {
namespace {

constexpr std::uint32_t kWrite0 = 0x04;
constexpr std::uint32_t kExit = 0x18;
constexpr std::uint32_t kElapsed = 0x30;
constexpr std::uint32_t kApplicationExit = 0x20026;

std::uint32_t call(std::uint32_t operation, std::uint32_t argument) {
  register std::uint32_t r0 __asm("r0") = operation;
  register std::uint32_t r1 __asm("r1") = argument;
  __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

volatile std::uint32_t& reg(std::uint32_t address) {
  return *reinterpret_cast<volatile std::uint32_t*>(address);
}

}  // namespace

void print(const char* text) { call(kWrite0, reinterpret_cast<std::uint32_t>(text)); }

void print(std::uint32_t number) {
  char digits[11];
  char* at = digits + 10;
  *at = 0;
  do {
    *--at = static_cast<char>('0' + number % 10);
    number /= 10;
  } while (number != 0);
  print(at);
}

#if defined(__ARM_FP)
/// With `-icount shift=0` an instruction takes one nanosecond, and the an505's SysTick counts at
/// 20 MHz: 50 instructions a count, exact over many ticks.
std::uint32_t instructions() {
  static std::uint32_t last = 0;
  static std::uint32_t total = 0;
  const std::uint32_t now = 0x00FFFFFFU - reg(0xE000E018);
  total += (now - last) & 0x00FFFFFFU;
  last = now;
  return total * 50;
}
#else
/// m0plus.mjs counts what it executes.
std::uint32_t instructions() {
  volatile std::uint32_t elapsed[2] = {0, 0};
  call(kElapsed, reinterpret_cast<std::uint32_t>(elapsed));
  return elapsed[0];
}
#endif

}  // namespace torsio::mcu

// The environment may call main(), and this is the environment.
extern "C" int program() __asm("main");

extern "C" {
extern std::uint32_t stack_top, data_load, data_start, data_end, bss_start, bss_end;
extern void (*__init_array_start[])();
extern void (*__init_array_end[])();

[[noreturn]] void reset() {
  using torsio::mcu::reg;
#if defined(__ARM_FP)
  reg(0xE000ED88) = reg(0xE000ED88) | (0xFU << 20);  // CPACR: floating point on
  __asm volatile("dsb\n isb");
#endif
  const std::uint32_t* from = &data_load;
  for (std::uint32_t* to = &data_start; to < &data_end;) *to++ = *from++;
  for (std::uint32_t* to = &bss_start; to < &bss_end;) *to++ = 0;
  for (auto init = __init_array_start; init < __init_array_end; ++init) (*init)();
  reg(0xE000E014) = 0x00FFFFFF;
  reg(0xE000E010) = 5;  // SysTick on, from the processor's clock
  program();
  torsio::mcu::call(torsio::mcu::kExit, torsio::mcu::kApplicationExit);
  for (;;) {
  }
}

[[noreturn]] void fault() {
  torsio::mcu::print("fault\n");
  torsio::mcu::call(torsio::mcu::kExit, 0);
  for (;;) {
  }
}

__attribute__((section(".vectors"), used)) void (*const vectors[])() = {
    reinterpret_cast<void (*)()>(&stack_top), reset, fault, fault, fault, fault, fault};

// The C++ run-time library would bring these.
void* __dso_handle;
int __aeabi_atexit(void*, void (*)(void*), void*) { return 0; }
}
