#include "device/power_logic.hpp"

#include "core/math.hpp"

namespace torsio::device {
namespace {

// Follows a sensor's slow drift, not its noise.
constexpr float kZeroShare = 1.0F / 256;

// Noise makes one high sample, a short circuit makes many.
constexpr std::uint8_t kOverCurrentSteps = 3;
constexpr float kOverCurrentFactor = 1.5F;
constexpr float kLeastTripA = 0.1F;

// A bridge that wakes up may say for a while that it does not work.
constexpr float kSettleS = 1e-3F;

// So many times as long a winding's current may flow on when the bridge has let go.
constexpr std::uint32_t kFadeTimes = 5;

// The speed estimate is some milliseconds late.
constexpr float kPatienceS = 4e-3F;

// Longer than any wall takes to be pushed in or let go.
constexpr float kSupplyPatienceS = 0.1F;

// Particle brakes keep some 5 % of their torque.
constexpr float kEraseShare = 0.05F;

// Of the smallest motors' windings; larger ones are slower.
constexpr float kWindingS = 10.0F;
constexpr std::uint32_t kLookSteps = 64;  // it need not be looked at more often, nor the supply

float seconds(std::uint32_t ns) { return static_cast<float>(ns) * 1e-9F; }

}  // namespace

PowerLogic::PowerLogic(const protocol::BoardConfig& config, const PowerBoard& board,
                       float brake_lag_s)
    : predicts_(board.predicts),
      predictive_params_(core::make_predictive_loop(
          config.motor_resistance_ohm, config.motor_inductance_h, config.current_bandwidth_hz,
          static_cast<float>(board.current_period_ns) * 1e-9F,
          static_cast<float>(board.output_delay_ns) * 1e-9F, config.supply_v)),
      loop_params_(core::make_current_loop(
          config.motor_resistance_ohm, config.motor_inductance_h, config.current_bandwidth_hz,
          static_cast<float>(board.current_period_ns) * 1e-9F, config.supply_v)),
      amperes_per_step_(board.converter_v_per_step / config.current_sense_v_per_a),
      direction_(config.motor_reversed == protocol::Toggle::on ? -1.0F : 1.0F),
      amperes_per_nm_(1.0F / config.motor_torque_constant_nm_per_a),
      current_max_a_(config.motor_current_max_a),
      brake_share_per_nm_(config.brake_resistance_ohm / config.brake_torque_constant_nm_per_a /
                          config.supply_v),
      brake_share_max_(core::smaller(
          config.brake_current_max_a * config.brake_resistance_ohm / config.supply_v, 1.0F)),
      coil_is_driven_(config.brake_inductance_h > 0.0F),
      coil_params_(core::make_coil(config.brake_resistance_ohm,
                                   core::larger(config.brake_inductance_h, 1e-6F), brake_lag_s,
                                   static_cast<float>(board.current_period_ns) * 1e-9F,
                                   config.supply_v, kEraseShare * config.brake_current_max_a)),
      coil_a_per_nm_(1.0F / config.brake_torque_constant_nm_per_a),
      coil_max_a_(config.brake_current_max_a),
      trip_a_(core::larger(kOverCurrentFactor * config.motor_current_max_a, kLeastTripA)),
      supply_v_(config.supply_v),
      converter_top_steps_(board.converter_top_steps),
      zero_margin_steps_(trip_a_ / amperes_per_step_),
      settle_steps_(core::round_to_u32(kSettleS / seconds(board.current_period_ns))),
      winding_params_(core::make_winding(
          config.motor_resistance_ohm, config.motor_inductance_h,
          config.motor_torque_constant_nm_per_a, config.motor_current_max_a,
          (board.predicts ? 1.0F : 2.0F) * seconds(board.current_period_ns), kPatienceS,
          static_cast<float>(kLookSteps) * seconds(board.current_period_ns), kSupplyPatienceS)),
      heat_params_(
          core::make_heat(config.motor_current_max_a, config.motor_current_continuous_a, kWindingS,
                          static_cast<float>(kLookSteps) * seconds(board.current_period_ns))) {
  amperes_per_step_ *= direction_;
}

bool PowerLogic::over_current() const { return over_current_steps_ >= kOverCurrentSteps; }

std::uint16_t PowerLogic::find_faults(bool bridge_reports) const {
  namespace fault = protocol::fault;
  const bool settled = !enabled_ || steps_enabled_ == settle_steps_;
  const bool zero_fits = !zero_known_ || (zero_steps_ >= zero_margin_steps_ &&
                                          zero_steps_ <= converter_top_steps_ - zero_margin_steps_);
  return static_cast<std::uint16_t>(
      (over_current() || (bridge_reports && settled) ? fault::actuator : 0) |
      (zero_fits ? 0 : fault::current_sensor) | (believed_ ? 0 : fault::winding));
}

void PowerLogic::measure(std::int32_t current_steps) {
  const auto steps = static_cast<float>(current_steps);
  if (steps_to_zero_ != 0) {
    --steps_to_zero_;
  } else if (!enabled_) {
    zero_steps_ = zero_known_ ? zero_steps_ + (steps - zero_steps_) * kZeroShare : steps;
    zero_known_ = true;
  }
  current_a_ = (steps - zero_steps_) * amperes_per_step_;

  if (core::absolute(current_a_) <= trip_a_) {
    over_current_steps_ = 0;
  } else if (over_current_steps_ < kOverCurrentSteps) {
    ++over_current_steps_;
  }
}

PowerDrive PowerLogic::step(const TickOutputs& wanted, std::int32_t current_steps) {
  measure(current_steps);
  if (!wanted.enabled) {
    if (enabled_) rest();
    look(0.0F);
    core::release_coil(coil_, coil_params_);
    return {};
  }
  if (!enabled_) predictive_.expected_a = current_a_;
  enabled_ = true;
  const float target_a =
      core::clamp_symmetric(wanted.motor_command_nm * amperes_per_nm_, current_max_a_);
  const float share =
      predicts_ ? core::hold_current(predictive_, predictive_params_, target_a, current_a_)
                : core::hold_current(loop_, loop_params_, target_a, current_a_);
  watch(share);
  look(current_a_);
  return {direction_ * share, drive_brake(wanted.brake_command_nm), true};
}

float PowerLogic::drive_brake(float command_nm) {
  if (!coil_is_driven_) {
    return core::smaller(command_nm * brake_share_per_nm_, brake_share_max_);
  }
  return core::drive_coil(coil_, coil_params_,
                          core::smaller(command_nm * coil_a_per_nm_, coil_max_a_));
}

/// Whether voltage and current fit together.
/// @param motor_share from now on
void PowerLogic::watch(float motor_share) {
  if (steps_enabled_ < settle_steps_) ++steps_enabled_;
  // Without floating point one half of it fits into a step.
  compares_ = predicts_ || !compares_;
  if (compares_) {
    believed_ = core::believe_current(winding_, winding_params_, current_a_) && believed_;
  }
  if (predicts_ || !compares_) {
    core::follow_winding(winding_, winding_params_, speed_rad_s_, motor_share * supply_v_);
  }
}

/// How much current there may be, after what there was, and whether the supply can be right.
void PowerLogic::look(float current_a) {
  if (steps_to_look_ == 0) {
    steps_to_look_ = kLookSteps;
    current_max_a_ = core::allow_current(heat_, heat_params_, current_a);
    believed_ =
        core::believe_supply(winding_, winding_params_, speed_rad_s_, current_a) && believed_;
  }
  --steps_to_look_;
}

/// Without power nothing is remembered but the sensor's zero, how warm the winding is, and what the
/// coil still has.
void PowerLogic::rest() {
  loop_ = {};
  predictive_ = {};
  winding_ = {};
  believed_ = true;
  steps_enabled_ = 0;
  steps_to_zero_ = kFadeTimes * settle_steps_;
  enabled_ = false;
}

}  // namespace torsio::device
