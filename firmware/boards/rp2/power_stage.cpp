#include "boards/rp2/power_stage.hpp"

#include <hardware/adc.h>
#include <hardware/clocks.h>
#include <hardware/gpio.h>
#include <hardware/irq.h>
#include <hardware/pwm.h>

#include "boards/rp2/pins.hpp"
#include "core/math.hpp"

namespace torsio::boards {
namespace {

// Above hearing, and a whole multiple of every rate of a current loop.
constexpr std::uint32_t kPwmHz = 40'000;

// Output pins of all stages, for start() and for cut_power(), which has no object.
std::uint32_t output_pins = 0;
std::uint32_t bridge_units = 0;

/// Makes the converter measure a pin once.
std::uint32_t measure(std::uint8_t pin) {
  return ADC_CS_EN_BITS | ADC_CS_START_ONCE_BITS |
         (std::uint32_t{pin} - rp2::kFirstAdcPin) << ADC_CS_AINSEL_LSB;
}

}  // namespace

PowerStage::PowerStage(const protocol::BoardConfig& config, const device::PowerBoard& board,
                       float brake_lag_s)
    : config_(config),
      logic_(config, board, brake_lag_s),
      motor_unit_(pwm_gpio_to_slice_num(config.motor_pin)),
      brake_unit_(pwm_gpio_to_slice_num(config.brake_pin)),
      step_unit_(0),
      measure_current_(measure(config.current_sense_pin)),
      step_cycles_(static_cast<std::uint32_t>(std::uint64_t{clock_get_hz(clk_sys)} *
                                              board.current_period_ns / 1'000'000'000U)),
      pwm_steps_(static_cast<std::uint16_t>(clock_get_hz(clk_sys) / kPwmHz / 2)) {
  bridge_units |= (1U << motor_unit_) | (1U << brake_unit_);
  while ((bridge_units >> step_unit_ & 1U) != 0) ++step_unit_;

  const std::uint32_t pins =
      (1U << config.enable_pin) | (3U << config.motor_pin) | (3U << config.brake_pin);
  output_pins |= pins;
  gpio_init_mask(pins);  // inputs, with a low output behind them
  gpio_set_dir_out_masked(pins);
  for (const std::uint8_t pin : {config.emergency_stop_pin, config.driver_fault_pin}) {
    gpio_init(pin);
    gpio_pull_up(pin);
  }

  // Inverted and centred: an input is low for its share of the period, round the moment at which
  // the counter is 0. With both inputs high the winding is short-circuited, so the voltage is
  // exactly the share of the time in which one of them is low.
  pwm_config bridge = pwm_get_default_config();
  pwm_config_set_phase_correct(&bridge, true);
  pwm_config_set_output_polarity(&bridge, true, true);
  pwm_config_set_wrap(&bridge, static_cast<std::uint16_t>(pwm_steps_ - 1));
  for (const std::uint32_t unit : {motor_unit_, brake_unit_}) pwm_init(unit, &bridge, false);

  pwm_config step = pwm_get_default_config();
  pwm_config_set_wrap(&step, static_cast<std::uint16_t>(step_cycles_ - 1));
  pwm_init(step_unit_, &step, false);

  switch_off();
  for (const std::uint8_t pin : {config.motor_pin, config.brake_pin}) {
    gpio_set_function(pin, GPIO_FUNC_PWM);
    gpio_set_function(pin + 1U, GPIO_FUNC_PWM);
  }

  adc_init();
  adc_gpio_init(config.current_sense_pin);
  if (config.supply_sense_pin != 0) adc_gpio_init(config.supply_sense_pin);
}

void PowerStage::start(void (*handler)()) {
  const std::uint32_t irq = PWM_DEFAULT_IRQ_NUM();
  irq_set_exclusive_handler(irq, handler);
  irq_set_priority(irq, PICO_HIGHEST_IRQ_PRIORITY);
  pwm_clear_irq(step_unit_);
  pwm_set_irq_enabled(step_unit_, true);
  irq_set_enabled(irq, true);
  constexpr std::uint32_t kLeadsPerSecond = 1'000'000'000U / device::kMeasurementLeadNs;
  pwm_set_counter(step_unit_, static_cast<std::uint16_t>(clock_get_hz(clk_sys) / kLeadsPerSecond));
  pwm_set_mask_enabled(bridge_units | 1U << step_unit_);
}

void PowerStage::begin() {
  pwm_clear_irq(step_unit_);
  if (measures_supply_) [[unlikely]] {
    see_supply();
    return;
  }
  adc_hw->cs = measure_current_;
}

/// Out of line, or every other interrupt would save and restore its registers.
[[gnu::noinline]] void PowerStage::see_supply() {
  const std::int32_t supply = finish_measurement();
  adc_hw->cs = measure_current_;
  measures_supply_ = false;
  logic_.see_supply(supply);
}

std::uint16_t PowerStage::find_faults() const {
  return logic_.find_faults(!gpio_get(config_.driver_fault_pin));
}

/// @returns the converter's reading
std::int32_t PowerStage::finish_measurement() const {
  while ((adc_hw->cs & ADC_CS_READY_BITS) == 0) {
    // Two microseconds from begin() on: long over.
  }
  return static_cast<std::int32_t>(adc_hw->result);
}

void PowerStage::apply(const device::TickOutputs& outputs) {
  wanted_ = outputs;
  const device::PowerDrive drive = logic_.step(outputs, finish_measurement());
  if (logic_.wants_supply()) [[unlikely]] {
    // Between two measurements of the current; the next comes a fraction of a us later.
    adc_hw->cs = measure(config_.supply_sense_pin);
    measures_supply_ = true;
  }
  if (!drive.enabled) {
    if (enabled_) switch_off();
    return;
  }
  set_bridge(motor_unit_, drive.motor_share);
  set_bridge(brake_unit_, drive.brake_share);
  if (!enabled_) {
    gpio_put(config_.enable_pin, true);
    enabled_ = true;
  }
}

/// The brake's current is not measured, so the nearest step counts. Out of line: an RP2040 has its
/// code in RAM.
/// @param share of the supply's voltage; positive drives a current into the first pin
[[gnu::noinline]] void PowerStage::set_bridge(std::uint32_t unit, float share) {
  const auto half_steps =
      static_cast<std::uint32_t>(core::absolute(share) * static_cast<float>(2U * pwm_steps_));
  const auto steps = static_cast<std::uint16_t>((half_steps + 1U) / 2U);
  // The second input is low while the first drives.
  pwm_set_both_levels(unit, share < 0.0F ? steps : 0, share < 0.0F ? 0 : steps);
}

void PowerStage::switch_off() {
  gpio_put(config_.enable_pin, false);
  // All inputs low all the time: a bridge without an enable input lets go as well.
  pwm_set_both_levels(motor_unit_, pwm_steps_, pwm_steps_);
  pwm_set_both_levels(brake_unit_, pwm_steps_, pwm_steps_);
  enabled_ = false;
}

void cut_power() {
  gpio_clr_mask(output_pins);
  for (std::uint32_t pin = 0; pin < NUM_BANK0_GPIOS; ++pin) {
    if ((output_pins >> pin & 1U) != 0) gpio_set_function(pin, GPIO_FUNC_SIO);
  }
}

}  // namespace torsio::boards
