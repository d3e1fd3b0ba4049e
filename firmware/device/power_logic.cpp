#include "device/power_logic.hpp"

#include "core/math.hpp"

namespace torsio::device {
namespace {

// Follows a sensor's slow drift, not its noise. Of the first 256 readings the zero is the mean.
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

// Particle brakes keep some 5 % of their torque.
constexpr float kEraseShare = 0.05F;

// Time constants of the smallest windings and coils; larger ones are slower.
constexpr float kWindingS = 10.0F;
constexpr float kCoilS = 100.0F;
constexpr std::uint32_t kLookSteps = 64;  // it need not be looked at more often, nor the supply

// Resistors that are 5 % off make a divider 10 % off; the converter adds 3 %. Supplies are 5 % off
// and sag by as much.
constexpr float kSupplyBand = 0.25F;
constexpr float kSupplyPeriodS = 0.5e-3F;
constexpr std::uint8_t kSupplyReadings = 3;   // noise makes one that is wrong
constexpr std::uint8_t kSupplyReturns = 100;  // at the edge of the band it must not flutter

float seconds(std::uint32_t ns) { return static_cast<float>(ns) * 1e-9F; }

/// The converter's reading at this share of the configured supply; below the end of its range.
std::int32_t supply_steps(const protocol::BoardConfig& config, const PowerBoard& board,
                          float share) {
  const float pin_v = share * config.supply_v / static_cast<float>(config.supply_sense_ratio);
  return static_cast<std::int32_t>(
      core::smaller(pin_v / board.converter_v_per_step, board.converter_top_steps - 1.0F));
}

}  // namespace

PowerLogic::PowerLogic(const protocol::BoardConfig& config, const PowerBoard& board,
                       float brake_lag_s)
    : period_ns_(board.current_period_ns),
      delay_ns_(board.output_delay_ns),
      predicts_(board.predicts),
      predictive_params_(core::make_predictive_loop(
          config.motor_resistance_ohm, config.motor_inductance_h, config.current_bandwidth_hz,
          seconds(board.current_period_ns), seconds(board.output_delay_ns), config.supply_v)),
      loop_params_(core::make_current_loop(config.motor_resistance_ohm, config.motor_inductance_h,
                                           config.current_bandwidth_hz,
                                           seconds(board.current_period_ns), config.supply_v)),
      amperes_per_step_(board.converter_v_per_step / config.current_sense_v_per_a),
      direction_(config.motor_reversed == protocol::Toggle::on ? -1.0F : 1.0F),
      shares_(direction_ * kSharesPerSupply),
      amperes_per_nm_(1.0F / config.motor_torque_constant_nm_per_a),
      current_max_a_(config.motor_current_max_a),
      coil_share_per_a_(config.brake_resistance_ohm / config.supply_v),
      coil_is_driven_(config.brake_inductance_h > 0.0F),
      coil_params_(core::make_coil(config.brake_resistance_ohm,
                                   core::larger(config.brake_inductance_h, 1e-6F), brake_lag_s,
                                   seconds(board.current_period_ns), config.supply_v,
                                   kEraseShare * config.brake_current_max_a)),
      next_follow_decay_(coil_params_.follow_decay),
      coil_a_per_nm_(1.0F / config.brake_torque_constant_nm_per_a),
      coil_max_a_(config.brake_current_max_a),
      trip_a_(core::larger(kOverCurrentFactor * config.motor_current_max_a, kLeastTripA)),
      converter_top_steps_(board.converter_top_steps),
      zero_margin_steps_(trip_a_ / amperes_per_step_),
      watches_supply_(config.supply_sense_pin != 0),
      supply_low_steps_(supply_steps(config, board, 1.0F - kSupplyBand)),
      supply_high_steps_(supply_steps(config, board, 1.0F + kSupplyBand)),
      supply_period_steps_(core::round_to_u32(kSupplyPeriodS / seconds(board.current_period_ns))),
      settle_steps_(core::round_to_u32(kSettleS / seconds(board.current_period_ns))),
      winding_params_(core::make_winding(
          config.motor_resistance_ohm, config.motor_inductance_h,
          config.motor_torque_constant_nm_per_a, config.motor_current_max_a, config.supply_v,
          (board.predicts ? 1.0F : 2.0F) * seconds(board.current_period_ns), kPatienceS,
          static_cast<float>(kLookSteps) * seconds(board.current_period_ns))),
      motor_heat_params_(core::make_heat(
          config.motor_current_max_a, config.motor_current_continuous_a, config.ambient_c,
          kWindingS, static_cast<float>(kLookSteps) * seconds(board.current_period_ns))),
      motor_heat_(core::cold_winding(motor_heat_params_)),
      coil_heat_params_(core::make_heat(
          config.brake_current_max_a,
          0.01F * config.brake_continuous_percent * config.brake_current_max_a, config.ambient_c,
          kCoilS, static_cast<float>(kLookSteps) * seconds(board.current_period_ns))),
      coil_heat_(core::cold_winding(coil_heat_params_)) {
  amperes_per_step_ *= direction_;
}

/// Out of line: who calls it is where the stack is deepest.
[[gnu::noinline]] void PowerLogic::set_brake_lag(float lag_s) {
  next_follow_decay_.give(core::coil_follow_decay(lag_s, seconds(period_ns_)));
}

bool PowerLogic::over_current() const { return over_current_steps_ >= kOverCurrentSteps; }

std::uint16_t PowerLogic::find_faults(bool bridge_reports) const {
  namespace fault = protocol::fault;
  const bool settled = !enabled_ || steps_enabled_ == settle_steps_;
  const bool zero_fits =
      zero_share_ == 1.0F || (zero_steps_ >= zero_margin_steps_ &&
                              zero_steps_ <= converter_top_steps_ - zero_margin_steps_);
  return static_cast<std::uint16_t>(
      (over_current() || (bridge_reports && settled) ? fault::actuator : 0) |
      (zero_fits ? 0 : fault::current_sensor) | (believed_ ? 0 : fault::winding) |
      (motor_heat_.too_hot || coil_heat_.too_hot ? fault::temperature : 0) |
      (supply_fits_ ? 0 : fault::supply));
}

void PowerLogic::measure(std::int32_t current_steps) {
  const auto steps = static_cast<float>(current_steps);
  if (steps_to_zero_ != 0) {
    --steps_to_zero_;
  } else if (!enabled_) {
    zero_steps_ += (steps - zero_steps_) * zero_share_;
    if (zero_share_ > kZeroShare) zero_share_ /= 1.0F + zero_share_;
  }
  current_a_ = (steps - zero_steps_) * amperes_per_step_;

  if (core::absolute(current_a_) <= trip_a_) {
    over_current_steps_ = 0;
  } else if (over_current_steps_ < kOverCurrentSteps) {
    ++over_current_steps_;
  }
}

bool PowerLogic::wants_supply() const { return watches_supply_ && steps_to_supply_ == 0; }

/// One that is too low for a moment sags; one that is wrong stays so.
void PowerLogic::see_supply(std::int32_t supply_steps) {
  steps_to_supply_ = supply_period_steps_;
  const bool fits = supply_steps >= supply_low_steps_ && supply_steps <= supply_high_steps_;
  if (fits == supply_fits_) {
    supply_contradictions_ = 0;
  } else if (++supply_contradictions_ == (fits ? kSupplyReturns : kSupplyReadings)) {
    supply_fits_ = fits;
    supply_contradictions_ = 0;
  }
}

PowerDrive PowerLogic::step(const TickOutputs& wanted, std::int32_t current_steps) {
  measure(current_steps);
  if (steps_to_supply_ != 0) --steps_to_supply_;
  const PowerDrive given = drive(wanted);
  count(current_steps, given.motor_share);
  return given;
}

PowerDrive PowerLogic::drive(const TickOutputs& wanted) {
  if (!wanted.enabled) {
    if (enabled_) rest();
    look(0.0F, 0.0F);
    coil_params_.follow_decay = next_follow_decay_.get();
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
  const float brake_share = drive_brake(wanted.brake_command_nm);
  look(current_a_, coil_a_);
  return {direction_ * share, brake_share, true};
}

/// In whole numbers, so that long sums lose nothing.
void PowerLogic::count(std::int32_t current_steps, float motor_share) {
  sums_.reading = current_steps;
  sums_.share_before = sums_.share;
  sums_.share = static_cast<std::int32_t>(motor_share * shares_);
  sums_.readings += current_steps;
  sums_.shares += sums_.share;
  ++sums_.periods;
}

float PowerLogic::drive_brake(float command_nm) {
  const float wanted_a = core::smaller(command_nm * coil_a_per_nm_, coil_max_a_);
  if (!coil_is_driven_) {
    coil_a_ = wanted_a;
    return core::smaller(wanted_a * coil_share_per_a_, 1.0F);
  }
  const float share = core::drive_coil(coil_, coil_params_, wanted_a);
  coil_a_ = coil_.current_a;
  return share;
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
    core::follow_winding(winding_, winding_params_, speed_rad_s_,
                         motor_share * predictive_params_.supply_v);
  }
}

/// How much current there may be after the past current, and whether a lasting current can be true.
void PowerLogic::look(float motor_a, float coil_a) {
  if (steps_to_look_ == 0) {
    steps_to_look_ = kLookSteps;
    core::warm_up(motor_heat_, motor_heat_params_, motor_a);
    current_max_a_ = core::allow_current(motor_heat_, motor_heat_params_);
  } else if (steps_to_look_ == kLookSteps / 2) {  // not all in one step
    core::warm_up(coil_heat_, coil_heat_params_, coil_a);
    coil_max_a_ = core::allow_current(coil_heat_, coil_heat_params_);
  } else if (steps_to_look_ == kLookSteps / 4) {
    believed_ = core::believe_means(winding_, winding_params_, speed_rad_s_) && believed_;
  } else if (steps_to_look_ == kLookSteps / 8) {
    believed_ = core::believe_change(winding_, winding_params_) && believed_;
  }
  --steps_to_look_;
}

/// Without power nothing is remembered but the sensor's zero, how warm winding and coil are, and
/// what the coil still has.
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
