/// @file
/// Patterns of the light. Told apart at a glance: dark with a short flash, slow, steady, fast.
#pragma once

#include <cstdint>

#include "protocol/reports.hpp"

namespace torsio::boards {

/// @param connected a host has configured the device and is awake
/// @param time_ms   since power-up
/// @returns true for on: without a host a flash every two seconds, disarmed once a second, armed
///          steady, fault eight times a second
constexpr bool status_light(protocol::State state, bool connected, std::uint32_t time_ms) {
  switch (state) {
    case protocol::State::armed:
      return true;
    case protocol::State::fault:
      return time_ms % 125 < 62;
    case protocol::State::disarmed:
      break;
  }
  return connected ? time_ms % 1000 < 500 : time_ms % 2000 < 50;
}

}  // namespace torsio::boards
