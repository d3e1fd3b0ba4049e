/// @file
/// Between the desired torques and the bridges. The current sensor's reading becomes a current, a
/// current loop holds the motor's current, and the brake's coil gets the voltage that its
/// resistance needs. Passive as the device is: a board and the emulator both run it, the one with
/// pins and the other with simulated windings.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/current_loop.hpp"
#include "core/heat_model.hpp"
#include "core/winding_model.hpp"
#include "device/control_loop.hpp"
#include "protocol/reports.hpp"

namespace torsio::device {

/// A board begins to measure its current so long before the middle of the bridge's pulse, where the
/// current is at its mean. Interrupt and converter take about as long; no board was measured.
inline constexpr std::uint32_t kMeasurementLeadNs = 1000;

/// A board's facts for its power stage, apart from its wiring.
struct PowerBoard {
  std::uint32_t current_period_ns = 25'000;     // of the current loop
  std::uint32_t output_delay_ns = 25'000;       // from measurement to voltage; at most a period
  bool predicts = true;                         // false: the loop that costs less
  float converter_v_per_step = 3.3F / 4096.0F;  // of the current sensor's converter
  float converter_top_steps = 4095.0F;          // the most that it shows
};

/// Orders of the bridges until the next step.
struct PowerDrive {
  float motor_share = 0;  // of the supply's voltage, -1 to 1; positive into the motor's first pin
  float brake_share = 0;  // the same of the brake's coil
  bool enabled = false;   // false: the bridges let go
};

/// Sums of measurements and drive since the start, to measure the winding.
struct PowerSums {
  std::uint64_t periods = 0;
  std::int64_t readings = 0;  // of the converter
  std::int64_t shares = 0;    // of the bridge, 1 / kSharesPerSupply of the supply
  std::int32_t reading = 0;   // the newest
  std::int32_t share = 0;     // that answers it
  std::int32_t share_before = 0;
};
inline constexpr float kSharesPerSupply = 16384.0F;

/// A number from the main loop to the interrupt, whole. Code outside of both may copy it.
class HandedOver {
 public:
  explicit HandedOver(float value) : value_(value) {}
  HandedOver(const HandedOver& other) : value_(other.get()) {}
  HandedOver& operator=(const HandedOver& other) {
    give(other.get());
    return *this;
  }
  void give(float value) { value_.store(value, std::memory_order_relaxed); }
  float get() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<float> value_;
};

class PowerLogic {
 public:
  /// @param brake_lag_s with which the brake shall follow, if its inductance is configured
  PowerLogic(const protocol::BoardConfig& config, const PowerBoard& board, float brake_lag_s);

  /// For the main loop: another lag for the brake, from when the bridges let go.
  void set_brake_lag(float lag_s);

  /// One period of the current loop.
  /// @param wanted        of the newest tick
  /// @param current_steps the converter's reading of this period
  PowerDrive step(const TickOutputs& wanted, std::int32_t current_steps);

  /// After a step: whether the supply's divider is to be measured before the next one.
  bool wants_supply() const;
  /// @param supply_steps the converter's reading of the divider
  void see_supply(std::int32_t supply_steps);

  /// True while the current is far above its limit.
  bool over_current() const;

  /// Bits of `faults` for motor, sensor and bridges that cannot be trusted now.
  /// @param bridge_reports a bridge says that something is wrong; not believed for a moment after
  ///                       it was enabled
  std::uint16_t find_faults(bool bridge_reports) const;

  /// The knob's speed, for the voltage that the motor makes itself. Once a tick.
  void set_speed(float speed_rad_s) { speed_rad_s_ = speed_rad_s; }

  /// Current in the last step; positive turns the knob to larger angles.
  float current_a() const { return current_a_; }

  /// For the main loop, all of one moment.
  /// @param position of the newest tick, asked for at the same moment
  template <class Position>
  protocol::MotorCurrent sums(Position&& position) const {
    return between_ticks(sums_.periods, [&](std::uint64_t periods) {
      return protocol::MotorCurrent{protocol::Toggle::on,
                                    position(),
                                    period_ns_,
                                    delay_ns_,
                                    periods,
                                    sums_.readings,
                                    sums_.shares,
                                    sums_.reading,
                                    static_cast<std::int16_t>(sums_.share),
                                    static_cast<std::int16_t>(sums_.share_before),
                                    zero_steps_,
                                    amperes_per_step_,
                                    amperes_per_nm_};
    });
  }

 private:
  PowerDrive drive(const TickOutputs& wanted);
  void measure(std::int32_t current_steps);
  void count(std::int32_t current_steps, float motor_share);
  void watch(float motor_share);
  void look(float motor_a, float coil_a);
  float drive_brake(float command_nm);
  void rest();

  PowerSums sums_;
  std::uint32_t period_ns_;
  std::uint32_t delay_ns_;
  bool predicts_;
  core::PredictiveParams predictive_params_;
  core::PredictiveState predictive_;
  core::CurrentLoopParams loop_params_;
  core::CurrentLoopState loop_;
  // Prepared, because a tick has no time for divisions.
  float amperes_per_step_;  // with the motor's sense
  float direction_;         // of the motor: 1 or -1
  float shares_;            // its bridge's share as the sums count it, with that sign
  float amperes_per_nm_;
  float current_max_a_;
  float coil_share_per_a_;
  bool coil_is_driven_;
  core::CoilParams coil_params_;
  HandedOver next_follow_decay_;  // of `coil_params_`
  core::CoilState coil_;
  float coil_a_per_nm_;
  float coil_max_a_;
  float coil_a_ = 0;  // that the coil is taken to have
  float trip_a_;
  float converter_top_steps_;
  float zero_margin_steps_;  // to either end of the converter, or the trip level cannot be seen
  bool watches_supply_;
  std::int32_t supply_low_steps_;
  std::int32_t supply_high_steps_;
  std::uint32_t supply_period_steps_;  // from one measurement to the next
  std::uint32_t steps_to_supply_ = 0;
  std::uint8_t supply_contradictions_ = 0;  // of supply_fits_, on end
  bool supply_fits_ = true;
  std::uint32_t settle_steps_;
  std::uint32_t steps_enabled_ = 0;  // up to settle_steps_
  core::WindingParams winding_params_;
  core::WindingState winding_;
  bool believed_ = true;
  bool compares_ = false;  // in this step; else the model goes on
  core::HeatParams motor_heat_params_;
  core::HeatState motor_heat_;
  core::HeatParams coil_heat_params_;
  core::HeatState coil_heat_;
  std::uint32_t steps_to_look_ = 0;
  float speed_rad_s_ = 0;
  std::uint32_t steps_to_zero_ = 0;  // until what is measured without power is no current any more
  float zero_steps_ = 0;
  float zero_share_ = 1.0F;  // of the next reading
  float current_a_ = 0;
  std::uint8_t over_current_steps_ = 0;
  bool enabled_ = false;
};

}  // namespace torsio::device
