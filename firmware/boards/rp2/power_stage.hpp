/// @file
/// Two H-bridges and a current sensor on the chip's units: what device/power_logic.hpp measures and
/// drives. Everything here belongs to the control interrupt.
#pragma once

#include <cstdint>

#include "device/control_loop.hpp"
#include "device/power_logic.hpp"
#include "protocol/reports.hpp"

namespace torsio::boards {

class PowerStage {
 public:
  /// Claims the pins, all outputs off.
  /// @param brake_lag_s see device::PowerLogic
  PowerStage(const protocol::BoardConfig& config, const device::PowerBoard& board,
             float brake_lag_s);

  /// Starts the PWM units in step. They call `handler` once a period of the current loop, just
  /// before the middle of the motor's pulse: see device::kMeasurementLeadNs.
  void start(void (*handler)());

  /// First thing in the handler: acknowledges it and starts to measure the current.
  void begin();

  /// Faults of parts now, as bits of `faults`.
  std::uint16_t find_faults() const;

  device::PowerLogic& logic() { return logic_; }

  /// Once a tick; see device::PowerLogic.
  void set_speed(float speed_rad_s) { logic_.set_speed(speed_rad_s); }

  /// Last thing in the handler: ends the measurement and sets the outputs for the next period.
  void apply(const device::TickOutputs& outputs);
  /// The same between two ticks, with the outputs of the last one.
  void apply() { apply(wanted_); }

 private:
  void see_supply();
  std::int32_t finish_measurement() const;
  void set_bridge(std::uint32_t unit, float share);
  void switch_off();

  protocol::BoardConfig config_;
  device::PowerLogic logic_;
  device::TickOutputs wanted_;
  std::uint32_t motor_unit_;
  std::uint32_t brake_unit_;
  std::uint32_t step_unit_;
  std::uint32_t measure_current_;  // written to the converter
  std::uint32_t step_cycles_;
  std::uint16_t pwm_steps_;
  bool enabled_ = false;
  bool measures_supply_ = false;  // since the end of the last handler
};

/// Outputs off, from any state of the program.
void cut_power();

}  // namespace torsio::boards
