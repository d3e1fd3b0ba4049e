#include "boards/rp2/quadrature.hpp"

#include <hardware/gpio.h>
#include <hardware/pio.h>

#include "quadrature.pio.h"

namespace torsio::boards {
namespace {

constexpr std::uint32_t kMachine = 0;
constexpr std::uint32_t kLostFlag = 0;  // quadrature.pio sets it

// The counter starts a few counts before its wrap: what happens there happens to every knob on
// every day, and not to one in a year.
constexpr std::uint32_t kCountsBeforeWrap = 16;

template <std::uint32_t unit>
pio_hw_t* const kPio = PIO_INSTANCE(unit);

}  // namespace

template <std::uint32_t unit>
Quadrature<unit>::Quadrature(std::uint8_t pin_a) {
  for (std::uint8_t pin = pin_a; pin < pin_a + 2; ++pin) {
    pio_gpio_init(kPio<unit>, pin);
    gpio_set_dir(pin, GPIO_IN);
    gpio_pull_up(pin);  // encoders often have open collectors
  }
  pio_add_program(kPio<unit>, &quadrature_program);
  pio_sm_config config = quadrature_program_get_default_config(0);
  sm_config_set_in_pins(&config, pin_a);
  sm_config_set_in_shift(&config, false, false, 32);
  sm_config_set_out_shift(&config, true, false, 32);
  sm_config_set_fifo_join(&config, PIO_FIFO_JOIN_NONE);
  pio_sm_init(kPio<unit>, kMachine, quadrature_wrap_target, &config);
  pio_sm_exec(kPio<unit>, kMachine, pio_encode_set(pio_y, kCountsBeforeWrap - 1));
  pio_sm_exec(kPio<unit>, kMachine, pio_encode_mov_not(pio_y, pio_y));
  // The levels now, or the first round would take them for edges.
  pio_sm_exec(kPio<unit>, kMachine, pio_encode_mov(pio_isr, pio_null));
  pio_sm_exec(kPio<unit>, kMachine, pio_encode_in(pio_pins, 2));
  pio_sm_exec(kPio<unit>, kMachine, pio_encode_mov(pio_osr, pio_isr));
  pio_sm_set_enabled(kPio<unit>, kMachine, true);
}

template <std::uint32_t unit>
std::uint32_t Quadrature<unit>::read() const {
  // The count in the queue is old; the one behind it was pushed after this call began.
  std::uint32_t count = 0;
  for (std::uint32_t left = pio_sm_get_rx_fifo_level(kPio<unit>, kMachine) + 1; left != 0; --left) {
    count = pio_sm_get_blocking(kPio<unit>, kMachine);
  }
  return count;
}

template <std::uint32_t unit>
bool Quadrature<unit>::take_lost_step() {
  if (!pio_interrupt_get(kPio<unit>, kLostFlag)) return false;
  pio_interrupt_clear(kPio<unit>, kLostFlag);
  return true;
}

// The units that all chips have.
template class Quadrature<0>;
template class Quadrature<1>;

}  // namespace torsio::boards
