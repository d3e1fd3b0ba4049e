#include "core/excitation.hpp"

#include "core/math.hpp"

namespace torsio::core {

void begin_excitation(ExcitationState& state, const Excitation& next,
                      std::int64_t position_counts) {
  if (!state.on) {
    state = {};
    state.on = true;
    state.begin_counts = position_counts;
  }
  // A servo that goes on keeps its reference, and with it its torque.
  if (state.now.servo_stiffness_nm_per_rad == 0.0F) {
    state.reference_q32 = (position_counts - state.begin_counts) * (std::int64_t{1} << 32);
  }
  state.now = next;
  state.ticks = 0;
  state.sine_phase_q64 = 0;
  state.sine_step_q64 = next.sine_step_q64;
  state.from_motor_command_nm = state.motor_command_nm;
  state.from_brake_command_nm = state.brake_command_nm;
}

namespace {

/// Whether a servo has pulled with all it may for too long, and nothing moves: the encoder has
/// failed, or the knob is held. Without this, a servo whose encoder dies makes the knob ever
/// faster, and nobody sees it.
bool pulls_in_vain(ExcitationState& state, bool pulls, std::int64_t position_counts) {
  const std::int64_t moved = position_counts - state.still_counts;
  // On the border of two counts a knob that stands still shows one of them, then the other.
  if (!pulls || moved > 1 || moved < -1) {
    state.still_counts = position_counts;
    state.still_ticks = 0;
    return false;
  }
  return ++state.still_ticks > state.now.still_ticks;
}

}  // namespace

Shares excite(ExcitationState& state, const PartitionParams& limits, const Motion& motion,
              float rad_per_count) {
  const Excitation& now = state.now;
  const std::int64_t moved_counts = motion.position_counts - state.begin_counts;
  if (moved_counts > now.travel_counts || moved_counts < -now.travel_counts ||
      absolute(motion.speed_rad_s) > now.speed_limit_rad_s) {
    state.end = ExcitationEnd::out_of_bounds;
  } else if (state.ticks >= now.duration_ticks) {
    state.end = ExcitationEnd::over;
  }
  if (state.end != ExcitationEnd::none) return {};

  const float share =
      state.ticks < now.ramp_ticks ? now.share_per_tick * static_cast<float>(state.ticks) : 1.0F;
  state.motor_command_nm =
      state.from_motor_command_nm + (now.motor_command_nm - state.from_motor_command_nm) * share;
  state.brake_command_nm =
      state.from_brake_command_nm + (now.brake_command_nm - state.from_brake_command_nm) * share;
  // To 2^-16 counts; further away than 2^14 of them it holds.
  constexpr std::int64_t most_q16 = std::int64_t{1} << 30;
  std::int64_t stretch_q16 = (state.reference_q32 - moved_counts * (std::int64_t{1} << 32)) / 65536;
  if (stretch_q16 > most_q16) stretch_q16 = most_q16;
  if (stretch_q16 < -most_q16) stretch_q16 = -most_q16;
  const float stretch_rad =
      static_cast<float>(static_cast<std::int32_t>(stretch_q16)) * 0x1p-16F * rad_per_count;
  const float motor_nm =
      state.motor_command_nm +
      now.sine_nm * sin_phase(static_cast<std::uint32_t>(state.sine_phase_q64 >> 32)) +
      now.servo_stiffness_nm_per_rad * stretch_rad +
      now.servo_damping_nm_s_per_rad * (now.servo_rad_s - motion.speed_rad_s);

  const float most_nm = smaller(now.torque_limit_nm, limits.motor_torque_max_nm);
  const bool saturated = absolute(motor_nm) > most_nm;
  const bool servo =
      now.servo_stiffness_nm_per_rad != 0.0F || now.servo_damping_nm_s_per_rad != 0.0F;
  if (pulls_in_vain(state, servo && saturated, motion.position_counts)) {
    state.end = ExcitationEnd::out_of_bounds;
    return {};
  }

  ++state.ticks;
  state.reference_q32 += now.servo_counts_q32;
  state.sine_phase_q64 += state.sine_step_q64;
  state.sine_step_q64 += static_cast<std::uint64_t>(now.sine_growth_q64);

  return {clamp_symmetric(motor_nm, most_nm),
          smaller(state.brake_command_nm, limits.brake_torque_max_nm), saturated,
          state.brake_command_nm > limits.brake_torque_max_nm};
}

}  // namespace torsio::core
