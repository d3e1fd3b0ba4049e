/// @file
/// The chip's watchdog, what keeps it quiet, and how late a tick is.
#pragma once

#include <hardware/watchdog.h>

#include <cstdint>

namespace torsio::boards {

/// Starts the chip anew, outputs off, unless interrupt and main loop both get on.
class LifeWatch {
 public:
  /// @param predicts the chip has floating point; without it the main loop's work takes longer with
  ///                 the largest scene that fits
  explicit constexpr LifeWatch(bool predicts) : time_ms_(predicts ? 8 : 10) {}

  void start() const { watchdog_enable(time_ms_, false); }

  /// In every round of the main loop. @param ticks_done counted by the interrupt
  void see(std::uint32_t ticks_done) {
    if (ticks_done != last_seen_) watchdog_update();
    last_seen_ = ticks_done;
  }

  /// Lets the main loop stand still for as long as `write` takes. @returns what it returns
  template <class Write>
  bool stand_by(Write&& write) const {
    watchdog_enable(kFlashMs, false);
    const bool done = write();
    start();
    return done;
  }

 private:
  static constexpr std::uint32_t kFlashMs = 2000;  // an erase may take half a second

  std::uint32_t time_ms_;
  std::uint32_t last_seen_ = 0;
};

/// When ticks are due. The chip's timer and its PWM run from the same crystal.
class TickClock {
 public:
  TickClock(std::uint32_t now_us, std::uint32_t period_us)
      : period_us_(period_us), due_us_(now_us + period_us) {}

  /// In every tick. @returns whole periods by which it is late
  std::uint32_t count_missed(std::uint32_t now_us) {
    const std::uint32_t late_us = now_us - due_us_;
    due_us_ += period_us_;
    if (static_cast<std::int32_t>(late_us) < 0) return 0;
    const std::uint32_t missed = late_us < period_us_ ? 0 : late_us / period_us_;
    due_us_ += missed * period_us_;
    return missed;
  }

 private:
  std::uint32_t period_us_;
  std::uint32_t due_us_;
};

}  // namespace torsio::boards
