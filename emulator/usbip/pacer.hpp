/// @file
/// Keeps virtual time in step with real time: when the next USB frame is due.
#pragma once

#include <chrono>
#include <utility>

namespace torsio::emulator::usbip {

/// Frames of 1 ms against a steady clock. A late pacer catches up. Later than kMostBehind, because
/// the machine stalled or slept, it lets the world slip behind the clock instead. While it catches
/// up, a driver on the same processor may not come to ask for anything. The ring of samples bears
/// that: telemetry at its fastest fills it in 16 frames. Half of them are left for the driver's own
/// lateness.
class Pacer {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;
  static constexpr Duration kFrame = std::chrono::milliseconds(1);
  static constexpr Duration kMostBehind = std::chrono::milliseconds(8);

  explicit Pacer(Time now) : next_(now + kFrame) {}

  /// @returns true if a frame is due, which the caller runs then
  bool take(Time now) {
    if (now < next_) return false;
    next_ += kFrame;
    if (now - next_ > kMostBehind) {
      slipped_ += now - next_;
      next_ = now;
    }
    return true;
  }

  /// How long to wait for the next frame; 0 if it is due.
  [[nodiscard]] Duration until_next(Time now) const {
    return now < next_ ? next_ - now : Duration::zero();
  }

  /// How much of the frame that runs is over; all of it once the next one is due.
  [[nodiscard]] Duration in_frame(Time now) const { return kFrame - until_next(now); }

  /// How far the world has slipped since the last call.
  Duration take_slipped() { return std::exchange(slipped_, Duration::zero()); }

 private:
  Time next_;
  Duration slipped_{};
};

}  // namespace torsio::emulator::usbip
