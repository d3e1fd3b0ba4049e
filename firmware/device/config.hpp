/// @file
/// The configuration as the host sees it, and what the control loop makes of it.
#pragma once

#include <cstdint>
#include <limits>

#include "core/controller.hpp"
#include "device/actuator_limits.hpp"
#include "device/wiring.hpp"
#include "protocol/configurations.hpp"
#include "protocol/reports.hpp"
#include "protocol/status.hpp"

namespace torsio::device {

struct Config : protocol::Configurations {
  std::uint32_t calibrated_values = 0;  // checksum of those that `calibration` is about
};

/// Everything that the control loop needs to know, prepared.
struct LoopConfig {
  core::ControllerParams controller;
  std::uint32_t watchdog_ticks = 1;      // 0: none, plays on without a host
  std::uint32_t passive_ramp_ticks = 0;  // also the length of the soft start
  std::uint32_t let_go_ticks = 0;        // of the motor's way to zero when somebody disarms
  float passive_brake_nm = 0;
  float speed_limit_rad_s = std::numeric_limits<float>::infinity();
  float excitation_speed_limit_rad_s = std::numeric_limits<float>::infinity();
  std::int32_t jump_limit_counts = 0;  // more in one tick is an encoder fault
  std::uint32_t tick_budget_ns = 0;    // a longer tick leaves too little to the main loop
};

LoopConfig make_loop_config(const Config& config, std::uint32_t period_ns,
                            Trust trust = Trust::all);

/// The most that the motor gives: what it can, and no more than its cap.
float motor_max_nm(const Config& config);

/// Checks what no single field's range can say.
protocol::Verdict check_consistent(const protocol::ActuatorConfig& config);

/// The torque of the shaft's spring grows all the way.
protocol::Verdict check_consistent(const protocol::ShaftConfig& config);

/// Each pin can do its job on this board.
protocol::Verdict check_consistent(const protocol::BoardConfig& config, WiringRule rule);

/// Those of a report that has such a check.
template <class Report>
protocol::Verdict check_rules(const Report& report, [[maybe_unused]] WiringRule rule) {
  if constexpr (requires { check_consistent(report); }) {
    return check_consistent(report);
  } else if constexpr (requires { check_consistent(report, rule); }) {
    return check_consistent(report, rule);
  }
  return {};
}

/// Unit of torque in telemetry: the finest of 1, 2, 5 times a power of ten that shows one and a
/// half times what motor and brake can give together.
float torque_step_nm(const protocol::ActuatorConfig& config);

}  // namespace torsio::device
