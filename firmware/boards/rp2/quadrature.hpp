/// @file
/// The encoder: A and B decoded by a PIO state machine, so that no edge is lost however busy the
/// processor is.
#pragma once

#include <hardware/gpio.h>
#include <hardware/pio.h>

#include <cstdint>

#include "quadrature.pio.h"

namespace torsio::boards {

/// @tparam unit of PIO, whose instruction memory the decoder has for itself
template <std::uint32_t unit>
class Quadrature {
 public:
  /// @param pin_a GPIO of A; B is the next one
  explicit Quadrature(std::uint8_t pin_a) {
    pio_hw_t* const pio = PIO_INSTANCE(unit);
    for (std::uint8_t pin = pin_a; pin < pin_a + 2; ++pin) {
      pio_gpio_init(pio, pin);
      gpio_set_dir(pin, GPIO_IN);
      gpio_pull_up(pin);  // encoders often have open collectors
    }
    pio_add_program(pio, &quadrature_program);
    pio_sm_config config = quadrature_program_get_default_config(0);
    sm_config_set_in_pins(&config, pin_a);
    sm_config_set_in_shift(&config, false, false, 32);
    sm_config_set_out_shift(&config, true, false, 32);
    sm_config_set_fifo_join(&config, PIO_FIFO_JOIN_NONE);
    pio_sm_init(pio, kMachine, quadrature_wrap_target, &config);
    pio_sm_exec(pio, kMachine, pio_encode_set(pio_y, kCountsBeforeWrap - 1));
    pio_sm_exec(pio, kMachine, pio_encode_mov_not(pio_y, pio_y));
    // The levels now, or the first round would take them for edges.
    pio_sm_exec(pio, kMachine, pio_encode_mov(pio_isr, pio_null));
    pio_sm_exec(pio, kMachine, pio_encode_in(pio_pins, 2));
    pio_sm_exec(pio, kMachine, pio_encode_mov(pio_osr, pio_isr));
    pio_sm_set_enabled(pio, kMachine, true);
  }

  /// The count now, four an encoder line, up when A leads B. Wraps at 32 bits.
  std::uint32_t read() const {
    pio_hw_t* const pio = PIO_INSTANCE(unit);
    // What waits in the queue is old; the one behind it was pushed after this call began.
    std::uint32_t count = 0;
    for (std::uint32_t left = pio_sm_get_rx_fifo_level(pio, kMachine) + 1; left != 0; --left) {
      count = pio_sm_get_blocking(pio, kMachine);
    }
    return count;
  }

  /// Whether both channels have changed at once since the last call: what no knob does, and the
  /// count misses.
  bool take_lost_step() {
    pio_hw_t* const pio = PIO_INSTANCE(unit);
    if (!pio_interrupt_get(pio, kLostFlag)) return false;
    pio_interrupt_clear(pio, kLostFlag);
    return true;
  }

 private:
  static constexpr std::uint32_t kMachine = 0;
  static constexpr std::uint32_t kLostFlag = 0;  // quadrature.pio sets it
  // The counter starts a few counts before its wrap: what happens there happens to every knob on
  // every day, and not to one in a year.
  static constexpr std::uint32_t kCountsBeforeWrap = 16;
};

}  // namespace torsio::boards
