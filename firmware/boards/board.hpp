/// @file
/// Every board's facts about itself, in the header of its own folder.
#pragma once

#include <cstdint>
#include <string_view>

#include "device/power_logic.hpp"
#include "device/wiring.hpp"

namespace torsio::boards {

struct Board {
  std::string_view name;    // its folder's
  std::uint8_t number = 0;  // what it calls itself on the wire, its own for ever; 0 is the emulated
  std::uint32_t control_period_ns = 0;
  device::WiringRule wiring_rule = nullptr;
  device::PowerBoard power;
  float motor_lag_s = protocol::ActuatorConfig{}.motor_time_constant_s;  // of its current loop
};

}  // namespace torsio::boards
