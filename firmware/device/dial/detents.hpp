/// @file
/// A dial's notches, as the control interrupt renders them while somebody turns the knob.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/angle.hpp"
#include "device/config.hpp"
#include "device/dial/feel.hpp"
#include "device/guest.hpp"

namespace torsio::device::dial {

/// Their configuration, prepared.
struct DetentParams {
  core::Pattern pattern;
  float torque_nm = 0;           // between two notches
  std::uint32_t ramp_ticks = 1;  // in which they rise or fall
  std::uint32_t pulse_ticks = 1;
  std::uint32_t pulse_step = 0;  // phase of a tick
};

DetentParams make_detent_params(const Config& config, std::uint32_t period_ns);

class Detents final : public Guest {
 public:
  explicit Detents(const DetentParams& params)
      : Guest(protocol::Owner::dial), params_(params), prepared_(params) {}

  // Control interrupt.

  bool take_news(bool may_play, std::uint64_t tick) override;
  bool play_on() override;
  bool stay_awake(bool /*has_actuator*/) override { return rises_ || level_ticks_ != 0; }
  void release() override { rises_ = false; }
  void drop() override;
  void configure() override { params_ = prepared_; }
  float torque_nm(const core::Motion& motion, const core::Resolution& resolution,
                  std::uint64_t tick) override;

  // Main loop.

  void prepare(const DetentParams& params) { prepared_ = params; }
  /// What is to be felt.
  void feel(Feel feel) { feel_.store(feel.word, std::memory_order_relaxed); }

 private:
  float pulse_nm(Feel feel);

  std::atomic<std::uint32_t> feel_{Feel{}.word};
  DetentParams params_;
  DetentParams prepared_;
  bool rises_ = false;
  std::uint32_t level_ticks_ = 0;  // of params_.ramp_ticks
  std::uint32_t pulse_ticks_ = 0;  // left of the pulse
  std::uint32_t pulse_number_ = 0;
  float pulse_torque_nm_ = 0;
};

}  // namespace torsio::device::dial
