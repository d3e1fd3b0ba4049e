/// @file Shared by tests of safety: a torque that plays at once, and events counted.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "device/rig.hpp"

namespace torsio::test {

/// Arms with a constant torque and without a soft start.
inline void play(Rig& rig, float torque_nm, std::uint8_t slot = 0) {
  protocol::Constant constant;
  constant.target.slot = slot;
  constant.torque_nm = torque_nm;
  REQUIRE(rig.send_status(constant) == protocol::Status::ok);
  REQUIRE(rig.send_status(protocol::Commit{1, 0, static_cast<std::uint16_t>(1U << slot)}) ==
          protocol::Status::ok);
  if (rig.state() != protocol::State::armed)
    REQUIRE(rig.command(protocol::Op::arm) == protocol::Status::ok);
  rig.tick(3);
}

/// Arms without a soft start, with a law whose motor gives all of the scene.
inline void arm_at_once(Rig& rig) {
  protocol::ControlConfig config;
  config.law = protocol::Law::motor_only;
  config.passive_ramp_s = 0.0F;
  REQUIRE(rig.set(config).ok());
  REQUIRE(rig.command(protocol::Op::arm) == protocol::Status::ok);
}

/// A law without a soft start, or with one of so many s, and without a watchdog that matters.
inline protocol::ControlConfig at_once(protocol::Law law, float passive_ramp_s = 0.0F) {
  protocol::ControlConfig config;
  config.law = law;
  config.passive_ramp_s = passive_ramp_s;
  config.watchdog_s = 60.0F;
  return config;
}

inline std::size_t count(const Rig& rig, protocol::EventKind kind) {
  return static_cast<std::size_t>(std::ranges::count_if(
      rig.events, [&](const protocol::Event& event) { return event.kind == kind; }));
}

}  // namespace torsio::test
