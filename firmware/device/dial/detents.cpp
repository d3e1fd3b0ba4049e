#include "device/dial/detents.hpp"

#include "core/math.hpp"
#include "device/dial/report_descriptor.hpp"
#include "device/stable_limits.hpp"

namespace torsio::device::dial {
namespace {

constexpr std::uint32_t kPulseNs = 1'000'000U * kClickMs;

}  // namespace

DetentParams make_detent_params(const Config& config, std::uint32_t period_ns) {
  const float period_s = core::make_resolution(config.actuator.counts_per_rev, period_ns).period_s;
  const auto detents = static_cast<float>(config.game.dial_detents);
  DetentParams params;
  params.pattern = core::make_pattern(0, std::uint64_t{config.game.dial_detents} << 32,
                                      config.actuator.counts_per_rev);
  // -T sin(n angle) is in its notch as stiff as n T.
  params.torque_nm = core::smaller(core::smaller(config.game.dial_torque_nm, motor_max_nm(config)),
                                   make_stable_limits(config, period_s).stiffness / detents);
  const std::uint32_t ramp_ticks = core::round_to_u32(config.control.passive_ramp_s / period_s);
  if (ramp_ticks != 0) params.ramp_ticks = ramp_ticks;
  params.pulse_ticks = kPulseNs / period_ns;
  params.pulse_step = 0xFFFF'FFFFU / params.pulse_ticks;
  return params;
}

bool Detents::take_news(bool may_play, std::uint64_t /*tick*/) {
  const bool begins = may_play && wanted();
  if (begins) rises_ = true;
  return begins;
}

bool Detents::play_on() {
  if (!wanted()) rises_ = false;
  return stay_awake(true);
}

void Detents::drop() {
  Guest::drop();
  rises_ = false;
  level_ticks_ = 0;
  pulse_ticks_ = 0;
}

float Detents::torque_nm(const core::Motion& motion, const core::Resolution&, std::uint64_t) {
  const Feel feel{feel_.load(std::memory_order_relaxed)};
  const std::uint32_t most = rises_ ? params_.ramp_ticks * feel.detents() / kFullFeel : 0;
  if (level_ticks_ < most) ++level_ticks_;
  if (level_ticks_ > most) --level_ticks_;
  const float level = static_cast<float>(level_ticks_) / static_cast<float>(params_.ramp_ticks);
  const std::uint32_t phase = core::pattern_phase(motion.position_counts, params_.pattern);
  const float detents_nm = -level * params_.torque_nm * core::sin_phase(phase);
  return detents_nm + (rises_ ? 1.0F : level) * pulse_nm(feel);
}

/// One period of a sine. The next one begins when it is over.
float Detents::pulse_nm(Feel feel) {
  if (pulse_ticks_ == 0) {
    if (!feel.goes_on() && feel.number() == pulse_number_) return 0;
    pulse_number_ = feel.number();
    pulse_ticks_ = params_.pulse_ticks;
    pulse_torque_nm_ = params_.torque_nm * static_cast<float>(feel.pulse()) / kFullFeel;
  }
  --pulse_ticks_;
  return pulse_torque_nm_ * core::sin_phase(pulse_ticks_ * params_.pulse_step);
}

}  // namespace torsio::device::dial
