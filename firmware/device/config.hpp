/// @file
/// The configuration as the host sees it, and what the control loop makes of it.
#pragma once

#include <cstdint>
#include <limits>

#include "core/controller.hpp"
#include "device/actuator_limits.hpp"
#include "device/config_rules.hpp"
#include "device/index_watch.hpp"
#include "device/wiring.hpp"
#include "protocol/configurations.hpp"
#include "protocol/reports.hpp"
#include "protocol/status.hpp"

namespace torsio::device {

struct Config : protocol::Configurations {
  std::uint32_t calibrated_values = 0;   // checksum of those that `calibration` is about
  std::int32_t index_counts = kNoPlace;  // of the encoder's index, from the centre
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
  std::int32_t turn_counts = 0;
  std::int32_t index_counts = kNoPlace;  // as it was saved
};

LoopConfig make_loop_config(const Config& config, std::uint32_t period_ns,
                            Trust trust = Trust::all);

/// The most that the motor gives: its ability, and at most its cap.
float motor_max_nm(const Config& config);

/// Rules of a report, if there are any.
/// @param others that it must go with
template <class Report>
protocol::Verdict check_rules(const Report& report, const protocol::Configurations&, WiringRule) {
  if constexpr (requires { check_consistent(report); }) return check_consistent(report);
  return {};
}
/// The encoder's index has a pin for itself.
protocol::Verdict check_rules(const protocol::ActuatorConfig& report,
                              const protocol::Configurations& others, WiringRule rule);
/// Each pin can do its job on this board.
protocol::Verdict check_rules(const protocol::BoardConfig& report,
                              const protocol::Configurations& others, WiringRule rule);

/// Unit of torque in telemetry: the finest of 1, 2, 5 times a power of ten. It shows one and a half
/// times the torque of motor and brake together.
float torque_step_nm(const protocol::ActuatorConfig& config);

}  // namespace torsio::device
