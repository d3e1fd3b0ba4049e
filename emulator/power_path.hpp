/// @file The way from the device's commands to the windings and back: the board's own power stage,
/// current sensor and bridges. It replaces a motor and a brake that are mere lags.
#pragma once

#include <cstdint>
#include <optional>

#include "device/power_logic.hpp"
#include "emulator/plant/circuit.hpp"
#include "emulator/plant/plant.hpp"
#include "emulator/random.hpp"
#include "protocol/reports.hpp"

namespace torsio::emulator {

/// Options of such a board's power stage.
[[nodiscard]] device::PowerBoard power_board_of(const Electrics& electrics,
                                                std::int64_t control_period_ns);

/// The configuration that tells a board the truth about such electrics.
[[nodiscard]] protocol::BoardConfig matching_board(const Electrics& electrics);

class PowerPath {
 public:
  /// @param seed of the current sensor's noise
  PowerPath(const Electrics& electrics, std::int64_t control_period_ns, std::uint64_t seed);

  /// The board starts, with this configuration.
  void power_up(const protocol::BoardConfig& config, float brake_lag_s);
  /// The board stands without a command until it knows its current sensor's zero. No time passes.
  void rest(const Plant& plant);
  void power_down();

  /// Bits of `faults` for the parts that the board cannot trust now; see device::PowerLogic.
  /// @param bridge_reports a bridge says that something is wrong
  [[nodiscard]] std::uint16_t find_faults(bool bridge_reports) const {
    return logic_ ? logic_->find_faults(bridge_reports) : std::uint16_t{0};
  }
  /// The board's logic; the board has power.
  [[nodiscard]] device::PowerLogic& logic() { return *logic_; }
  /// As the board's own device has it. Once a tick.
  void set_speed(float speed_rad_s) {
    if (logic_) logic_->set_speed(speed_rad_s);
  }

  /// A control period in which the board follows what its newest tick wanted.
  void run(Plant& plant, const device::TickOutputs& wanted);
  /// A control period in which its program does not get on: the bridges go on as they are.
  void stand_still(Plant& plant);

  void set_sensor_state(CurrentSensorState state) { electrics_.sensor_state = state; }
  void set_supply(double supply_v) { circuit_.set_supply(supply_v); }
  [[nodiscard]] const Circuit& circuit() const { return circuit_; }
  /// How long the plant's steps are.
  [[nodiscard]] std::int64_t step_ns() const { return board_.current_period_ns; }

 private:
  [[nodiscard]] std::int32_t read_current(const Plant& plant);
  [[nodiscard]] std::int32_t read_supply(const Plant& plant) const;
  [[nodiscard]] std::int32_t converted(double shown_v) const;
  [[nodiscard]] BridgeShares shares_of(const device::PowerDrive& drive) const;

  Electrics electrics_;
  std::int64_t control_period_ns_;
  device::PowerBoard board_;
  std::optional<device::PowerLogic> logic_;
  Circuit circuit_;
  Random random_;
  BridgeShares acting_;
};

/// Nothing for a plant without electrics.
[[nodiscard]] inline std::optional<PowerPath> make_power_path(const PlantParams& plant,
                                                              std::int64_t control_period_ns,
                                                              std::uint64_t seed) {
  if (!plant.electrics) return {};
  return PowerPath(*plant.electrics, control_period_ns, seed);
}

}  // namespace torsio::emulator
