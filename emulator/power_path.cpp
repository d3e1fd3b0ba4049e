#include "emulator/power_path.hpp"

#include <algorithm>
#include <cmath>

#include "emulator/plant/portable_math.hpp"

namespace torsio::emulator {
namespace {

std::int64_t rounded_ns(double time_s) { return std::llround(1e9 * time_s); }

/// The nearest of a PWM unit's steps.
double quantised(double share, int steps) {
  return std::round(std::clamp(share, -1.0, 1.0) * steps) / steps;
}

}  // namespace

device::PowerBoard power_board_of(const Electrics& electrics, std::int64_t control_period_ns) {
  const std::int64_t wanted_ns = rounded_ns(electrics.current_period_s);
  const std::int64_t parts =
      wanted_ns > 0 ? std::max<std::int64_t>(1, (control_period_ns + wanted_ns / 2) / wanted_ns)
                    : 1;
  const std::int64_t period_ns = control_period_ns / parts;
  device::PowerBoard board;
  board.current_period_ns = static_cast<std::uint32_t>(period_ns);
  board.output_delay_ns =
      static_cast<std::uint32_t>(std::min(rounded_ns(electrics.output_delay_s), period_ns));
  board.predicts = electrics.predictive;
  board.converter_v_per_step =
      static_cast<float>(std::ldexp(electrics.sensor_range_v, -electrics.sensor_bits));
  board.converter_top_steps = static_cast<float>(std::ldexp(1.0, electrics.sensor_bits) - 1.0);
  return board;
}

protocol::BoardConfig matching_board(const Electrics& electrics) {
  const auto f = [](double value) { return static_cast<float>(value); };
  protocol::BoardConfig config;
  config.supply_v = f(electrics.supply_v);
  config.motor_torque_constant_nm_per_a = f(electrics.torque_constant_nm_per_a);
  // The plant does not know the winding's continuous torque: nothing is held back.
  config.motor_current_continuous_a = config.motor_current_max_a;
  config.motor_resistance_ohm = f(electrics.winding_resistance_ohm);
  config.motor_inductance_h = f(electrics.winding_inductance_h);
  config.current_sense_v_per_a = f(electrics.sensor_v_per_a);
  config.brake_torque_constant_nm_per_a = f(electrics.coil_torque_constant_nm_per_a);
  config.brake_resistance_ohm = f(electrics.coil_resistance_ohm);
  config.motor_reversed = electrics.motor_reversed ? protocol::Toggle::on : protocol::Toggle::off;
  return config;
}

PowerPath::PowerPath(const Electrics& electrics, std::int64_t control_period_ns, std::uint64_t seed)
    : electrics_(electrics),
      control_period_ns_(control_period_ns),
      board_(power_board_of(electrics, control_period_ns)),
      circuit_(electrics),
      random_(seed) {}

void PowerPath::power_up(const protocol::BoardConfig& config, float brake_lag_s) {
  logic_.emplace(config, board_, brake_lag_s);
  acting_ = {};
}

void PowerPath::rest(const Plant& plant) {
  constexpr int kReadings = 1000;
  for (int i = 0; i < kReadings; ++i) logic_->step({}, read_current(plant));
}

void PowerPath::power_down() {
  logic_.reset();
  acting_ = {};
}

void PowerPath::run(Plant& plant, const device::TickOutputs& wanted) {
  if (!logic_) {
    stand_still(plant);
    return;
  }
  std::int64_t left_ns = control_period_ns_;
  while (left_ns > 0) {
    // The last period gets the rest of the division into whole nanoseconds.
    const std::int64_t period_ns =
        left_ns < 2 * std::int64_t{board_.current_period_ns} ? left_ns : board_.current_period_ns;
    const device::PowerDrive drive = logic_->step(wanted, read_current(plant));
    if (logic_->wants_supply()) logic_->see_supply(read_supply(plant));
    const std::int64_t delay_ns = std::min<std::int64_t>(board_.output_delay_ns, period_ns);
    // Switching off goes past the PWM, by the enable line.
    if (!drive.enabled) acting_ = {};
    circuit_.advance(plant, acting_, delay_ns);
    acting_ = shares_of(drive);
    if (delay_ns < period_ns) circuit_.advance(plant, acting_, period_ns - delay_ns);
    left_ns -= period_ns;
  }
}

void PowerPath::stand_still(Plant& plant) {
  for (std::int64_t left_ns = control_period_ns_; left_ns > 0;) {
    const std::int64_t piece_ns = std::min<std::int64_t>(left_ns, board_.current_period_ns);
    circuit_.advance(plant, acting_, piece_ns);
    left_ns -= piece_ns;
  }
}

/// The converter's reading of the current sensor now.
std::int32_t PowerPath::read_current(const Plant& plant) {
  double noise_v = 0.0;
  if (electrics_.sensor_noise_v > 0.0) {
    const double radius = std::sqrt(-2.0 * log_of(1.0 - random_.uniform()));
    noise_v = electrics_.sensor_noise_v * radius * cos_of_turns(random_.uniform());
  }
  const double direction = electrics_.motor_reversed ? -1.0 : 1.0;
  const double after_middle_s = electrics_.sample_offset_s - 1e-9 * device::kMeasurementLeadNs;
  const double current_a = circuit_.current_a(plant) + circuit_.ripple_a(acting_, after_middle_s);
  double shown_v = electrics_.sensor_zero_v + noise_v;
  switch (electrics_.sensor_state) {
    case CurrentSensorState::works:
      shown_v += direction * electrics_.sensor_v_per_a * current_a;
      break;
    case CurrentSensorState::dead:
      shown_v = 0.0;
      break;
    case CurrentSensorState::stuck:
      break;
    case CurrentSensorState::saturated:
      shown_v = electrics_.sensor_range_v;
      break;
  }
  return converted(shown_v);
}

/// The converter's reading of the divider.
std::int32_t PowerPath::read_supply(const Plant& plant) const {
  return converted(circuit_.state(plant).supply_v / electrics_.supply_divider_ratio);
}

std::int32_t PowerPath::converted(double shown_v) const {
  const double most = std::ldexp(1.0, electrics_.sensor_bits) - 1.0;
  return static_cast<std::int32_t>(std::clamp(
      std::floor(std::ldexp(shown_v / electrics_.sensor_range_v, electrics_.sensor_bits)), 0.0,
      most));
}

BridgeShares PowerPath::shares_of(const device::PowerDrive& drive) const {
  const double direction = electrics_.motor_reversed ? -1.0 : 1.0;
  return {direction * quantised(static_cast<double>(drive.motor_share), electrics_.pwm_steps),
          quantised(static_cast<double>(drive.brake_share), electrics_.pwm_steps), drive.enabled};
}

}  // namespace torsio::emulator
