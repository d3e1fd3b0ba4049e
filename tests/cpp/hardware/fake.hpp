/// @file The part of Raspberry Pi's SDK that the power stage uses, as numbers that a test reads and
/// sets. The headers beside it have the SDK's names and include this one.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

// NOLINTBEGIN: these names are the SDK's.
using uint = unsigned;
inline constexpr unsigned NUM_BANK0_GPIOS = 30;
enum gpio_function { GPIO_FUNC_PWM = 4, GPIO_FUNC_SIO = 5 };
inline constexpr unsigned GPIO_OUT = 1;
inline constexpr unsigned clk_sys = 0;
inline constexpr unsigned PICO_HIGHEST_IRQ_PRIORITY = 0;
inline constexpr std::uint32_t ADC_CS_EN_BITS = 1 << 0;
inline constexpr std::uint32_t ADC_CS_START_ONCE_BITS = 1 << 2;
inline constexpr std::uint32_t ADC_CS_READY_BITS = 1 << 8;
inline constexpr std::uint32_t ADC_CS_AINSEL_LSB = 12;

namespace fake {

struct Chip {
  std::uint32_t levels = 0xFFFFFFFF;  // of inputs as set by the test, of outputs as set by the code
  std::uint32_t outputs = 0;          // pins that are outputs
  std::array<int, 30> function{};     // by pin
  std::array<std::array<std::uint16_t, 2>, 16> pwm{};
  std::uint16_t wrap = 0;
  std::uint32_t running = 0;  // PWM units
  std::array<std::uint16_t, 12> counter{};
};
inline Chip chip;
struct Adc {
  /// Its register of control and status: a conversion that is started is over at once.
  struct {
    Adc& adc;
    operator std::uint32_t() const { return ADC_CS_READY_BITS; }
    void operator=(std::uint32_t word) {
      adc.input = word >> ADC_CS_AINSEL_LSB & 7;
      if ((word & (ADC_CS_START_ONCE_BITS | ADC_CS_EN_BITS)) == 5) adc.started.push_back(adc.input);
    }
  } cs{*this};
  std::uint32_t result = 0;
  unsigned input = 0;
  std::vector<unsigned> started;  // the input of each conversion
};
inline Adc adc;

}  // namespace fake

inline fake::Adc* const adc_hw = &fake::adc;
inline std::uint32_t clock_get_hz(unsigned) { return 150'000'000; }
inline void gpio_init(unsigned) {}
inline void gpio_pull_up(unsigned) {}
inline void gpio_init_mask(std::uint32_t pins) {
  fake::chip.levels &= ~pins;
  for (unsigned pin = 0; pin < NUM_BANK0_GPIOS; ++pin) {
    if ((pins >> pin & 1U) != 0) fake::chip.function[pin] = GPIO_FUNC_SIO;
  }
}
inline void gpio_set_dir_out_masked(std::uint32_t pins) { fake::chip.outputs |= pins; }
inline void gpio_set_function(unsigned pin, gpio_function function) {
  fake::chip.function[pin] = function;
}
inline bool gpio_get(unsigned pin) { return (fake::chip.levels >> pin & 1U) != 0; }
inline void gpio_put(unsigned pin, bool high) {
  fake::chip.levels = (fake::chip.levels & ~(1U << pin)) | (high ? 1U << pin : 0U);
}
inline void gpio_clr_mask(std::uint32_t pins) { fake::chip.levels &= ~pins; }
inline void adc_init() {}
inline void adc_gpio_init(unsigned) {}

struct pwm_config {
  std::uint16_t wrap = 0;
};
inline unsigned pwm_gpio_to_slice_num(unsigned pin) { return pin / 2 % 8; }
inline pwm_config pwm_get_default_config() { return {}; }
inline void pwm_config_set_phase_correct(pwm_config*, bool) {}
inline void pwm_config_set_output_polarity(pwm_config*, bool, bool) {}
inline void pwm_config_set_wrap(pwm_config* config, std::uint16_t wrap) { config->wrap = wrap; }
inline void pwm_init(unsigned, const pwm_config*, bool) {}
inline void pwm_set_both_levels(unsigned unit, std::uint16_t a, std::uint16_t b) {
  fake::chip.pwm[unit] = {a, b};
}
inline void pwm_set_counter(unsigned unit, std::uint16_t counter) {
  fake::chip.counter[unit] = counter;
}
inline void pwm_clear_irq(unsigned) {}
inline void pwm_set_irq_enabled(unsigned, bool) {}
inline void pwm_set_mask_enabled(std::uint32_t units) { fake::chip.running = units; }
inline unsigned PWM_DEFAULT_IRQ_NUM() { return 4; }
inline void irq_set_exclusive_handler(unsigned, void (*)()) {}
inline void irq_set_priority(unsigned, std::uint8_t) {}
inline void irq_set_enabled(unsigned, bool) {}
// NOLINTEND
