/// @file
/// A dial's notches, as the control interrupt renders them while somebody turns the knob.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/angle.hpp"
#include "core/force_source.hpp"
#include "device/config.hpp"
#include "device/dial/feel.hpp"

namespace torsio::device::dial {

/// Their configuration, prepared.
struct DetentParams {
  bool on = false;  // the device is a dial
  core::Pattern pattern;
  float torque_nm = 0;           // between two notches
  std::uint32_t ramp_ticks = 1;  // in which they rise or fall
  std::uint32_t pulse_ticks = 1;
  std::uint32_t pulse_step = 0;  // phase of a tick
};

/// @param personality that the device has started with
DetentParams make_detent_params(const Config& config, std::uint32_t period_ns,
                                protocol::Personality personality);

class Detents final : public core::ForceSource {
 public:
  explicit Detents(const DetentParams& params) : params_(params) {}

  // Control interrupt.

  /// Only while nothing is felt.
  void configure(const DetentParams& params) { params_ = params; }
  bool on() const { return params_.on; }
  /// Comes up from zero.
  void begin() { rises_ = true; }
  /// Goes to zero.
  void release() { rises_ = false; }
  /// Is gone at once: the actuator is off.
  void drop();
  bool wanted() const { return wanted_.load(std::memory_order_relaxed) != 0; }
  bool felt() const { return rises_ || level_ticks_ != 0; }
  float torque_nm(const core::Motion& motion, const core::Resolution& resolution,
                  std::uint64_t tick) override;

  // Main loop.

  /// The knob is turned, or at rest.
  void want(bool wanted) { wanted_.store(wanted ? 1 : 0, std::memory_order_relaxed); }
  void feel(Feel feel) { feel_.store(feel.word, std::memory_order_relaxed); }

 private:
  float pulse_nm(Feel feel);

  std::atomic<std::uint32_t> wanted_{0};  // cleared by the interrupt too
  std::atomic<std::uint32_t> feel_{Feel{}.word};
  DetentParams params_;
  bool rises_ = false;
  std::uint32_t level_ticks_ = 0;  // of params_.ramp_ticks
  std::uint32_t pulse_ticks_ = 0;  // left of the pulse
  std::uint32_t pulse_number_ = 0;
  float pulse_torque_nm_ = 0;
};

}  // namespace torsio::device::dial
