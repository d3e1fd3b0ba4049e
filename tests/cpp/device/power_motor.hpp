/// @file
/// A winding that is solved exactly, for tests of the power stage's logic.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include "device/power_logic.hpp"

namespace torsio::tests {

using device::PowerBoard;
using device::PowerDrive;
using device::PowerLogic;
using protocol::BoardConfig;

inline constexpr PowerBoard kFast{25'000, 25'000, true};
inline constexpr PowerBoard kSlow{100'000, 100'000, false};

/// A winding with its bridge and its sensor. Its values are the configured ones unless a
/// test says otherwise.
struct Motor {
  explicit Motor(const PowerBoard& on, BoardConfig of = {})
      : config(of), board(on), logic(config, board, 0.06F) {
    run(0.0, 0.1);
  }

  double period_s() const { return 1e-9 * board.current_period_ns; }
  double honest_steps() const { return zero_steps + amperes * volts_per_a / 3.3 * 4096.0; }

  /// Wants a torque for so long, or lets go of the bridges with 0 N m at rest.
  /// @returns when a fault was seen, in s; negative: never
  double run(double torque_nm, double time_s, bool enabled = false) {
    const double decay = std::exp(-period_s() * ohm / henry);
    for (double now_s = 0.0; now_s < time_s; now_s += period_s()) {
      const double steps = sensor ? sensor(*this) : honest_steps();
      logic.set_speed(static_cast<float>(seen_speed));
      const PowerDrive drive =
          logic.step({static_cast<float>(torque_nm), 0.0F, enabled},
                     static_cast<std::int32_t>(std::clamp(std::round(steps), 0.0, 4095.0)));
      const double lost_v = std::clamp(amperes / 0.02, -1.0, 1.0) * dead_time_v;
      const double volts =
          enabled ? supply * static_cast<double>(acting) - emf_v_s * speed - lost_v : 0.0;
      const double end = enabled ? volts / ohm : 0.0;
      amperes = end + (amperes - end) * decay;  // flows on when the bridge has let go
      if (inertia > 0.0) turn();
      most = std::max(most, std::abs(amperes));
      acting = drive.motor_share;
      if (logic.find_faults(bridge_reports) != 0) return now_s + period_s();
    }
    return -1.0;
  }
  /// A period of a knob that nobody holds, with the friction of the reference actuator.
  void turn() {
    const double pushed = speed + period_s() * emf_v_s * amperes / inertia;
    const double friction = period_s() * 8e-3 / inertia;
    speed = pushed - std::clamp(pushed, -friction, friction);
    look();
  }
  /// The estimate of 100 Hz after a period of such speed.
  void look() {
    const double pole = 2 * 3.14159265 * 100.0;
    behind += period_s() * (speed - seen_speed - 2 * pole * behind);
    seen_speed += period_s() * pole * pole * behind;
  }
  void shift_zero(double by_a) { zero_steps += by_a * volts_per_a / 3.3 * 4096.0; }
  double push(double torque_nm, double time_s) { return run(torque_nm, time_s, true); }

  BoardConfig config;
  PowerBoard board;
  PowerLogic logic;
  double ohm = 2.5;
  double henry = 1.5e-3;
  double supply = 12.0;
  double volts_per_a = 0.2;
  double emf_v_s = 0.05;
  double speed = 0.0;        // rad/s
  double seen_speed = 0.0;   // from the encoder
  double behind = 0.0;       // the estimate's position, in rad
  double inertia = 0.0;      // 0: the test turns the knob
  double dead_time_v = 0.0;  // lost in the bridge
  double zero_steps = 2048.0;
  double amperes = 0.0;
  double most = 0.0;
  float acting = 0.0F;
  bool bridge_reports = false;
  std::function<double(const Motor&)> sensor;
};

}  // namespace torsio::tests
