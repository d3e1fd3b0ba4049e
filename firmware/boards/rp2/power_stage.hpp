/// @file
/// Two H-bridges: the motor's current is held by a current loop, the brake's coil gets the voltage
/// that its resistance needs. Everything here belongs to the control interrupt.
#pragma once

#include <cstdint>

#include "core/current_loop.hpp"
#include "device/control_loop.hpp"
#include "protocol/reports.hpp"

namespace torsio::boards {

class PowerStage {
 public:
  /// Claims the pins, all outputs off.
  PowerStage(const protocol::BoardConfig& config, std::uint32_t control_period_ns);

  /// Starts the PWM units in step, and with them `handler` once a control period, in the middle of
  /// the time in which the motor is driven: there the current is at its average.
  void start(void (*handler)());

  /// First thing in a tick: acknowledges it and starts to measure the current.
  void begin_tick();

  /// True while a bridge reports an error or the current is far above its limit.
  bool has_fault() const;

  /// Last thing in a tick: ends the measurement and sets the outputs for the next period.
  void apply(const device::TickOutputs& outputs);

 private:
  void measure_current();
  void set_motor(float share);
  void set_brake(float share);
  void switch_off();

  protocol::BoardConfig config_;
  core::CurrentLoopParams loop_params_;
  core::CurrentLoopState loop_;
  std::uint32_t motor_unit_;
  std::uint32_t brake_unit_;
  std::uint32_t tick_unit_;
  std::uint32_t tick_cycles_;
  std::uint16_t pwm_steps_;
  // Prepared, because a tick has no time for divisions.
  float amperes_per_step_;
  float amperes_per_nm_;
  float brake_share_per_nm_;
  float brake_share_max_;
  float trip_a_;
  float zero_steps_ = 0;
  bool zero_known_ = false;
  float current_a_ = 0;
  std::uint8_t over_current_ticks_ = 0;
  bool enabled_ = false;
};

/// Outputs off, from any state of the program.
void cut_power();

}  // namespace torsio::boards
