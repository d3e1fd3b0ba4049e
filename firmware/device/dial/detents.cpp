#include "device/dial/detents.hpp"

#include "core/math.hpp"

namespace torsio::device::dial {

void Detents::begin(const DetentParams& params) {
  params_ = params;
  rises_ = true;
}

void Detents::drop() {
  rises_ = false;
  level_ticks_ = 0;
  wanted_.store(0, std::memory_order_relaxed);
}

float Detents::torque_nm(const core::Motion& motion, const core::Resolution&, std::uint64_t) {
  if (rises_ && level_ticks_ < params_.ramp_ticks) ++level_ticks_;
  if (!rises_ && level_ticks_ > 0) --level_ticks_;
  const float level = static_cast<float>(level_ticks_) / static_cast<float>(params_.ramp_ticks);
  const std::uint32_t phase = core::pattern_phase(motion.position_counts, params_.pattern);
  return -level * params_.torque_nm * core::sin_phase(phase);
}

}  // namespace torsio::device::dial
