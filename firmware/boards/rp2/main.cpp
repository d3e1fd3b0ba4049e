// Start-up, the control interrupt and the main loop. The interrupt owns encoder, power stage and
// Device::tick(); the main loop owns everything else.
#include <hardware/clocks.h>
#include <hardware/gpio.h>
#include <hardware/structs/sio.h>
#include <hardware/structs/systick.h>
#include <hardware/sync.h>
#include <hardware/timer.h>
#include <pico/bootrom.h>
#include <pico/unique_id.h>

#include <atomic>
#include <cstdint>
#include <new>
#include <optional>

#include "boards/all.hpp"
#include "boards/rp2/buttons.hpp"
#include "boards/rp2/firmware_label.hpp"
#include "boards/rp2/flash_slots.hpp"
#include "boards/rp2/life_watch.hpp"
#include "boards/rp2/pins.hpp"
#include "boards/rp2/power_stage.hpp"
#include "boards/rp2/quadrature.hpp"
#include "boards/rp2/reset_cause.hpp"
#include "boards/rp2/status_light.hpp"
#include "core/encoder_watch.hpp"
#include "device/device.hpp"
#include "usb/usb_device.hpp"

namespace torsio::boards {
namespace {

constexpr const Board& kBoard = TORSIO_BOARD::kBoard;
constexpr std::uint32_t kControlPeriodUs = kBoard.control_period_ns / 1000;
constexpr std::uint32_t kStepsPerTick = kBoard.control_period_ns / kBoard.power.current_period_ns;
constexpr std::uint32_t kLongestFlipTicks = core::kLongestFlipNs / kBoard.control_period_ns;
constexpr std::uint32_t kForgetLostTicks = core::kForgetLostNs / kBoard.control_period_ns;
static_assert(kStepsPerTick * kBoard.power.current_period_ns == kBoard.control_period_ns);
constexpr std::uint32_t kGoodbyeUs = 100'000;       // for the bootloader's acknowledgement
constexpr std::uint32_t kSysTickMask = 0x00FFFFFF;  // counts down in 24 bits
constexpr std::uint32_t kSysTickOn = 0x5;           // enabled, from the processor's clock

constexpr FirmwareLabel kLabel = make_firmware_label(
    kBoard.name, {TORSIO_VERSION_MAJOR, TORSIO_VERSION_MINOR, TORSIO_VERSION_PATCH});

/// Room for an object that is made at start-up and never destroyed.
template <class T>
class Lasting {
 public:
  template <class... Arguments>
  T& make(Arguments&&... arguments) {
    return *new (bytes_) T(arguments...);
  }
  T& operator*() { return *std::launder(reinterpret_cast<T*>(bytes_)); }
  T* operator->() { return &**this; }

 private:
  alignas(T) unsigned char bytes_[sizeof(T)];
};

Lasting<device::Device> the_device;
Lasting<PowerStage> power;
Lasting<Quadrature<0>> encoder;
Lasting<usb::UsbDevice> usb_device;
LifeWatch life_watch{kBoard.power.predicts};
Buttons buttons;
bool has_buttons;

/// Power off, then the watchdog starts the chip anew.
[[noreturn]] void panic(protocol::ResetCause why) {
  cut_power();
  leave_reset_cause(why);
  for (;;) {
  }
}

// Control interrupt --------------------------------------------------------------------------

device::TickInputs inputs;
core::EncoderWatch encoder_watch;
core::LostSteps lost_steps;
std::uint8_t emergency_stop_pin;
std::uint32_t index_mask;  // of the encoder's index; 0: it has none
bool index_level;
TickClock tick_clock{0, kControlPeriodUs};
std::uint32_t cycles_to_ns_q16;
std::atomic<std::uint32_t> ticks_done{0};

std::uint32_t cycles_left() { return systick_hw->cvr; }

std::uint32_t ns_since(std::uint32_t start) {
  const std::uint32_t cycles = (start - cycles_left()) & kSysTickMask;
  return static_cast<std::uint32_t>((std::uint64_t{cycles} * cycles_to_ns_q16) >> 16);
}

void on_tick() {
  const std::uint32_t start = cycles_left();
  inputs.encoder_count = encoder->read();
  inputs.emergency_stop = gpio_get(emergency_stop_pin);
  // gpio_get_all() would ask a coprocessor on the RP2350.
  const bool index = (sio_hw->gpio_in & index_mask) != 0;
  if (index != index_level) {
    index_level = index;
    the_device->see_index(index);
  }
  inputs.power_faults = power->find_faults();
  if (core::finds_loose_plug(lost_steps, kForgetLostTicks, encoder->take_lost_step())) {
    inputs.power_faults |= protocol::fault::encoder;
  }
  if (core::finds_dead_channel(encoder_watch, kLongestFlipTicks, inputs.encoder_count) &&
      !the_device->shakes()) {
    inputs.power_faults |= protocol::fault::encoder;
  }
  inputs.actuator_fault = inputs.power_faults != 0;
  inputs.missed_ticks = tick_clock.count_missed(timer_hw->timerawl);
  const device::TickOutputs outputs = the_device->tick(inputs);
  power->set_speed(the_device->speed_rad_s());
  power->apply(outputs);
  if (!stack_is_whole()) panic(protocol::ResetCause::stack);
  ticks_done.store(ticks_done.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  inputs.step_time_ns = 0;
  inputs.tick_time_ns = ns_since(start);
}

/// Between two ticks only the current loop has something to do.
void on_step() {
  static std::uint32_t steps_left = 0;
  const std::uint32_t start = cycles_left();
  power->begin();
  if (steps_left == 0) {
    steps_left = kStepsPerTick;
    on_tick();
  } else {
    power->apply();
    inputs.step_time_ns += ns_since(start);
  }
  --steps_left;
}

// Start-up -----------------------------------------------------------------------------------

device::BoardInfo board_info() {
  device::BoardInfo info;
  info.board = kBoard.number;
  info.firmware_version = kLabel.version;
  info.control_period_ns = kBoard.control_period_ns;
  info.wiring_rule = kBoard.wiring_rule;
  info.motor_lag_s = kBoard.motor_lag_s;
  info.has_bootloader = true;
  info.moves_parts = true;
  info.reset_cause = take_reset_cause();
  pico_unique_board_id_t id;
  pico_get_unique_board_id(&id);
  constexpr char digits[] = "0123456789ABCDEF";
  static_assert(2 * sizeof(id.id) == sizeof(info.serial));
  for (std::size_t i = 0; i < info.serial.size(); ++i) {
    info.serial[i] =
        static_cast<std::uint8_t>(digits[(id.id[i / 2] >> (i % 2 == 0 ? 4 : 0)) & 0xF]);
  }
  return info;
}

void start_control(const protocol::BoardConfig& config, const protocol::ActuatorConfig& actuator) {
  encoder.make(config.encoder_pin);
  if (actuator.encoder_index_pin != 0) {
    index_mask = 1U << actuator.encoder_index_pin;
    gpio_init(actuator.encoder_index_pin);
    gpio_pull_up(actuator.encoder_index_pin);
  }
  has_buttons = !rp2::find_pin_conflict(config, actuator.encoder_index_pin, kButtonPins);
  for (std::uint8_t pin = kFirstButtonPin; has_buttons && pin < kFirstButtonPin + 2; ++pin) {
    gpio_init(pin);
    gpio_pull_up(pin);
  }
  power.make(config, kBoard.power, actuator.brake_time_constant_s);
  the_device->measure_by(power->logic());
  emergency_stop_pin = config.emergency_stop_pin;
  gpio_init(config.light_pin);
  gpio_set_dir(config.light_pin, GPIO_OUT);

  systick_hw->rvr = kSysTickMask;
  systick_hw->csr = kSysTickOn;
  cycles_to_ns_q16 =
      static_cast<std::uint32_t>((std::uint64_t{1'000'000'000} << 16) / clock_get_hz(clk_sys));
  tick_clock = {timer_hw->timerawl, kControlPeriodUs};
  power->start(on_step);
}

// Main loop ----------------------------------------------------------------------------------

void save_when_asked() {
  const std::optional<device::SlotWrite> write = the_device->take_slot_write();
  if (!write) return;
  if (life_watch.stand_by([&] { return write_slot(*write); })) {
    the_device->storage_written();
  } else {
    the_device->storage_failed();
  }
}

void read_buttons() {
  if (has_buttons && buttons.see(sio_hw->gpio_in, timer_hw->timerawl)) {
    the_device->set_buttons(buttons.pressed());
  }
}

void show_state(std::uint8_t pin) {
  gpio_put(pin, status_light(the_device->state(), usb_device->has_host(),
                             static_cast<std::uint32_t>(time_us_64() / 1000)));
}

[[noreturn]] void run(std::uint8_t light_pin) {
  std::uint32_t bootloader_us = 0;
  bool leaving = false;
  life_watch.start();
  for (;;) {
    read_buttons();
    usb_device->poll();
    the_device->service();
    save_when_asked();
    show_state(light_pin);
    life_watch.see(ticks_done.load(std::memory_order_relaxed));
    if (the_device->take_bootloader_request()) {
      leaving = true;
      bootloader_us = timer_hw->timerawl;
    }
    if (leaving && timer_hw->timerawl - bootloader_us > kGoodbyeUs) {
      cut_power();
      rom_reset_usb_boot(0, 0);
    }
    __wfi();  // the next tick wakes it at the latest
  }
}

}  // namespace
}  // namespace torsio::boards

/// A program that has lost its way.
extern "C" [[noreturn]] void torsio_panic(...) {
  torsio::boards::panic(torsio::protocol::ResetCause::hard_fault);
}
extern "C" [[noreturn]] void isr_hardfault() { torsio_panic(); }

int main() {
  using namespace torsio::boards;
  guard_stack();
  keep(kLabel);
  const torsio::device::BoardInfo info = board_info();
  torsio::device::Device& device = the_device.make(info, slots());
  start_control(device.board_config(), device.actuator_config());
  usb_device.make(device, info);
  run(device.board_config().light_pin);
}
