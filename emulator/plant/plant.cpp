#include "emulator/plant/plant.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "emulator/plant/portable_math.hpp"
#include "emulator/plant/require.hpp"

namespace torsio::emulator {
namespace {

constexpr double kFastestRadS = 1e6;
constexpr double kNothingNm = 1e-12;  // of the brake's current before the end of its play

/// The profile that a hand follows, if it has one.
const Profile* profile_of(const Hand& hand) {
  if (const auto* torque = std::get_if<TorqueHand>(&hand)) return &torque->torque_nm;
  if (const auto* impedance = std::get_if<ImpedanceHand>(&hand)) {
    return &impedance->intended_angle_rad;
  }
  if (const auto* prescribed = std::get_if<PrescribedMotion>(&hand)) return &prescribed->angle_rad;
  return nullptr;
}

}  // namespace

Plant::Plant(const PlantParams& params, Hand hand, std::int64_t step_ns, MakeStepper make_stepper)
    : params_(params), step_ns_(step_ns), make_stepper_(std::move(make_stepper)) {
  require(step_ns > 0, "plant: step_ns must be > 0");
  attach(std::move(hand));
}

void Plant::attach(Hand hand) {
  make_steppers(hand);
  hand_ = std::move(hand);
  if (const auto* prescribed = std::get_if<PrescribedMotion>(&hand_)) {
    state_.knob_angle = Angle::from_rad(prescribed->angle_rad.value(state_.time_ns));
  }
  refresh_hand_segment();
  start_from_here();
}

void Plant::ask_hand(const FeedbackHand& hand) {
  constexpr double kMostNm = 100.0;
  const std::int64_t since_ns = state_.time_ns - hand.start_ns;
  // The plant can go on after any failure of the function: without a torque, until the next call.
  inputs_.hand = {Profile::kAlwaysNs,
                  hand.start_ns + (since_ns / hand.period_ns + 1) * hand.period_ns, 0.0, 0.0};
  const double since_s = 1e-9 * static_cast<double>(since_ns);
  const double torque_nm =
      hand.torque_nm(since_s, state_.knob_angle_rad(), state_.knob_speed_rad_s());
  if (!(std::abs(torque_nm) <= kMostNm)) {
    throw std::runtime_error("the hand's function gave " + std::to_string(torque_nm) + " N m at " +
                             std::to_string(since_s) + " s; it must give -100 to 100 N m");
  }
  inputs_.hand.begin_value = torque_nm;
}

void Plant::make_steppers(const Hand& hand) {
  PlantModel model = make_model(params_, hand);
  std::shared_ptr<Stepper> stepper = make_stepper_(model, step_ns_);
  if (params_.electrics) {
    disconnected_ = make_stepper_(make_model(params_, hand, false), step_ns_);
  }
  model_ = std::move(model);
  stepper_ = std::move(stepper);
  coil_step_share_ = model_.brake_time_constant_s > 0.0 ? coil_share(step_ns_) : 0.0;
}

void Plant::set_resistances(double winding_ohm, double coil_ohm) {
  params_.electrics->winding_resistance_ohm = winding_ohm;
  params_.electrics->coil_resistance_ohm = coil_ohm;
  make_steppers(hand_);
}

void Plant::refresh_hand_segment() {
  if (const auto* feedback = std::get_if<FeedbackHand>(&hand_)) {
    ask_hand(*feedback);
    return;
  }
  const Profile* profile = profile_of(hand_);
  inputs_.hand = profile != nullptr ? profile->segment(state_.time_ns)
                                    : ProfileSegment{Profile::kAlwaysNs, Profile::kForeverNs, 0, 0};
  if (model_.knob_is_driven()) {
    state_.speed_rad_s[0] = inputs_.hand.slope_per_s;
    make_consistent();
  }
}

void Plant::make_consistent() {
  for (int shaft = model_.shafts; shaft < 3; ++shaft) {
    const auto s = static_cast<std::size_t>(shaft);
    state_.speed_rad_s[s] = state_.speed_rad_s[s - 1];
    state_.twist_rad[s - 1] = 0.0;
  }
}

void Plant::start_from_here() {
  between_ = false;
  grid_ns_ = (state_.time_ns / step_ns_ + 1) * step_ns_;
}

void Plant::follow_coil() {
  coil_arrives_ns_ = Profile::kForeverNs;
  const double play_nm = params_.brake_hysteresis->half_width_nm;
  const double lag_s = model_.brake_time_constant_s;
  double& coil_nm = state_.brake_coil_nm;
  if (lag_s == 0.0) coil_nm = coil_target_nm_;
  double& torque_nm = state_.brake_magnetic_nm;
  torque_nm = std::clamp(torque_nm, coil_nm - play_nm, coil_nm + play_nm);
  state_.brake_target_nm = torque_nm;
  const double way = coil_target_nm_ < coil_nm ? -1.0 : 1.0;
  const double edge_nm = torque_nm + way * play_nm;
  if (way * (coil_target_nm_ - edge_nm) <= 0.0) return;  // it stays within the play
  if (way * (edge_nm - coil_nm) <= kNothingNm) {
    state_.brake_target_nm = coil_target_nm_ - way * play_nm;
    return;
  }
  const double after_s = lag_s * log_of((coil_target_nm_ - coil_nm) / (coil_target_nm_ - edge_nm));
  coil_arrives_ns_ = state_.time_ns + std::max<std::int64_t>(1, std::llround(1e9 * after_s));
}

double Plant::coil_share(std::int64_t duration_ns) const {
  return expm1_of(-(1e-9 * static_cast<double>(duration_ns) / model_.brake_time_constant_s));
}

void Plant::step_to(std::int64_t time_ns) {
  Stepper& stepper = connected_ ? *stepper_ : *disconnected_;
  const std::int64_t duration_ns = time_ns - state_.time_ns;
  stepper.step(state_, inputs_, duration_ns);
  if (plays() && model_.brake_time_constant_s > 0.0) {
    const double share = duration_ns == step_ns_ ? coil_step_share_ : coil_share(duration_ns);
    state_.brake_coil_nm += (state_.brake_coil_nm - coil_target_nm_) * share;
  }
}

void Plant::set_drive(const Drive& drive) {
  connected_ = drive.motor_connected;
  inputs_.motor_command_nm = drive.motor_connected ? drive.motor_target_nm : 0.0;
  if (!connected_) state_.motor_torque_nm = 0.0;
  state_.brake_target_nm = drive.brake_target_nm;
  between_ = false;
}

void Plant::set_hand(Hand hand) { attach(std::move(hand)); }

void Plant::set_hand_torque(double torque_nm) {
  require(model_.hand == HandKind::torque, "plant: only a TorqueHand's torque can be set");
  require(std::abs(torque_nm) <= 100.0, "plant: hand_torque_nm must be within -100 and 100");
  inputs_.hand = {Profile::kAlwaysNs, Profile::kForeverNs, torque_nm, 0.0};
  between_ = false;  // the next step starts from here
}

void Plant::set_state(const PlantState& state) {
  require(state.time_ns >= 0 && state.time_ns < Profile::kForeverNs - step_ns_,
          "plant: time_ns must be >= 0 and leave room for a step");
  for (const double value :
       {state.knob_angle.fraction_rad, state.speed_rad_s[0], state.speed_rad_s[1],
        state.speed_rad_s[2], state.twist_rad[0], state.twist_rad[1], state.motor_torque_nm}) {
    require(std::isfinite(value), "plant: every value of the state must be finite");
  }
  require(std::isfinite(state.brake_magnetic_nm) && state.brake_magnetic_nm >= 0.0,
          "plant: brake_magnetic_nm must be finite and >= 0");
  require(std::isfinite(state.brake_target_nm) && state.brake_target_nm >= 0.0,
          "plant: brake_target_nm must be finite and >= 0");
  require(std::isfinite(state.brake_coil_nm) && state.brake_coil_nm >= 0.0,
          "plant: brake_coil_nm must be finite and >= 0");
  state_ = state;
  if (plays()) follow_coil();
  make_consistent();
  refresh_hand_segment();
  start_from_here();
}

void Plant::advance(std::int64_t duration_ns) {
  require(duration_ns >= 0, "plant: advance needs a duration >= 0");
  require(duration_ns < Profile::kForeverNs - step_ns_ - state_.time_ns,
          "plant: advance runs past the end of 64-bit time");
  if (duration_ns == 0) return;
  const std::int64_t target_ns = state_.time_ns + duration_ns;
  // Steps start at grid times, corners of the hand's profile and changes of inputs. They never
  // start where a call ends: the next call goes back to the begin of the step.
  if (between_) state_ = anchor_;
  between_ = false;
  do {
    const std::int64_t boundary_ns = std::min({grid_ns_, inputs_.hand.end_ns, coil_arrives_ns_});
    if (boundary_ns > target_ns) [[unlikely]] {
      anchor_ = state_;
      between_ = true;
    }
    step_to(std::min(boundary_ns, target_ns));
    if (between_) [[unlikely]]
      return;
    if (boundary_ns == coil_arrives_ns_) follow_coil();
    if (boundary_ns == grid_ns_) grid_ns_ += step_ns_;
    // False for NaN. No encoder counts what turns faster.
    if (!(std::abs(state_.speed_rad_s[0]) <= kFastestRadS)) [[unlikely]] {
      throw std::runtime_error(
          "the emulated knob turns faster than 1e6 rad/s: the torques on it "
          "are too large for its inertia and friction");
    }
    if (boundary_ns == inputs_.hand.end_ns) refresh_hand_segment();
  } while (state_.time_ns < target_ns);
}

}  // namespace torsio::emulator
