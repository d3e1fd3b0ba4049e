#include "device/control_loop.hpp"

#include <algorithm>

#include "core/math.hpp"

namespace torsio::device {
namespace {

namespace fault = protocol::fault;
namespace flag = protocol::flag;
using protocol::EventKind;
using protocol::Owner;
using protocol::State;

// A tick that takes longer than its budget, or was missed, costs four; one in time earns one back.
// Up to one late tick in five is jitter. Sixteen in a row mean too much load: the motor has held
// stale torques, and the interrupt has kept the main loop from running.
constexpr std::uint32_t kLateTickCost = 4;
constexpr std::uint32_t kLatenessLimit = 16 * kLateTickCost;

constexpr std::uint32_t kForever = 0xFFFFFFFFU;

// Reports of bridges, sensor and divider without supply.
constexpr std::uint32_t kUnpowered = fault::supply | fault::actuator | fault::current_sensor;

// Bits that only reported_by() and hold_back() make of the inputs.
constexpr std::uint32_t kReported = fault::emergency_stop | fault::actuator |
                                    fault::current_sensor | fault::winding | fault::temperature |
                                    fault::supply;

/// Faults that inputs report.
std::uint32_t reported_by(const TickInputs& in) {
  return (in.emergency_stop ? fault::emergency_stop : 0U) |
         (in.actuator_fault ? fault::actuator : 0U);
}

}  // namespace

bool Faults::latch(std::uint32_t now, Phase phase) {
  present = static_cast<std::uint16_t>(now);
  if ((now & ~latched) == 0) return false;
  latched = static_cast<std::uint16_t>(latched | now);
  // The computer is often on before the supply. Then nobody has to clear these faults: they go
  // when the supply comes.
  unpowered = (phase == Phase::fault ? unpowered : phase == Phase::disarmed) &&
              (latched & ~kUnpowered) == 0;
  return true;
}

// Nearly every tick finds nothing to decide: nobody has said anything, nothing fades, nobody has
// been silent for too long. Then the last decision stands, and only motion and torques are new.
TickOutputs ControlLoop::tick(const TickInputs& in) {
  const std::uint32_t news = attention_.load(std::memory_order_relaxed) | in.missed_ticks;
  if (news != 0 || silent_ticks_left_ == 0 || in.tick_time_ns > usual_tick_ns_) [[unlikely]] {
    decide(in);
  }
  --silent_ticks_left_;
  const core::ControllerOutputs out =
      core::control(controller_, config_.controller, plan_, in.encoder_count);
  const std::uint32_t causes = find_causes(in, out);
  TickOutputs given{out.motor_command_nm, out.brake_command_nm, enabled_};
  if ((causes | after_) != 0) [[unlikely]] {
    if ((causes | (after_ & kHoldBack)) != 0) given = hold_back(causes, in.power_faults);
    if ((after_ & kSample) != 0 && ticks_to_sample_-- == 0) {
      sample(out.motion.speed_rad_s, out.desired_torque_nm,
             static_cast<std::uint8_t>((out.motor_saturated ? flag::motor_saturated : 0) |
                                       (out.brake_saturated ? flag::brake_saturated : 0)));
    }
  }
  counters_.tick_time_ns = in.tick_time_ns;
  return given;
}

/// Everything that may change the torque: missed ticks, orders, a game, silence, a fade. Out of
/// line, or the ticks without it would save and restore its registers.
[[gnu::noinline]] void ControlLoop::decide(const TickInputs& in) {
  attention_.store(0, std::memory_order_relaxed);
  watch_time(in);
  // An order sees the inputs of its own tick: a stop that is let go can be cleared at once.
  faults_.present = static_cast<std::uint16_t>((faults_.present & ~kReported) | reported_by(in));
  if (faults_.forgives()) (void)clear_fault();
  take_order();
  if (index_.awake) [[unlikely]]
    watch_index();
  if (excitation_.end != core::ExcitationEnd::none) end_excitation();
  core::ForceSource* const guest_force = serve_guest();
  if (plays()) watch_host();
  const bool playing = plays();
  choose_torque(playing, guest_force);
  faults_.present = 0;
  enabled_ = playing;
  const bool held_back = overruns() || !(playing || at_rest());
  after_ = (held_back ? kHoldBack : 0U) | (decimation_ != 0 ? kSample : 0U);
  if (held_back || plan_.once || lateness_ != 0) call();
}

/// Once the controller knows that its commands came to nothing they stay zero by themselves.
bool ControlLoop::at_rest() const {
  return !fades() && controller_.slew.motor_command_nm == 0.0F &&
         controller_.brake_command_nm == 0.0F;
}

void ControlLoop::give(const Order& order) {
  (void)orders_.push(order);
  call();
}

void ControlLoop::set_connected(bool connected) {
  connected_.store(connected, std::memory_order_relaxed);
  call();
}

void ControlLoop::see_index(bool level) {
  index_.told = level;
  index_.awake = true;
  call();
}

[[gnu::noinline]] void ControlLoop::watch_index() {
  const bool again = index_.watch(controller_.motion.position_counts, config_.turn_counts);
  if (again) call();
  if (index_.found() && takes_centre_ && !armed()) keep_centre();
  index_.awake = again || (index_.found() && takes_centre_);
}

/// Moves angle 0 by less than a turn, to where it was when it was saved. A hand that feels a torque
/// would be pushed, so it waits until there is none.
void ControlLoop::keep_centre() {
  takes_centre_ = false;
  if (config_.index_counts == kNoPlace) return;
  move_origin(within_turn(config_.index_counts - index_.at_counts, config_.turn_counts));
}

void ControlLoop::move_origin(std::int64_t counts) {
  controller_.motion.position_counts += counts;
  index_.at_counts += counts;
  index_.before_counts += counts;
  index_.from_counts += counts;
  ++counters_.zeroings;
}

void ControlLoop::watch_time(const TickInputs& in) {
  const std::uint32_t budget_ns =
      config_.tick_budget_ns - std::min(in.step_time_ns, config_.tick_budget_ns);
  if (in.missed_ticks != 0 || in.tick_time_ns > budget_ns) {
    fall_behind(in.missed_ticks);
  } else if (lateness_ != 0) {
    --lateness_;
  }
  if (in.tick_time_ns > counters_.tick_time_max_ns) counters_.tick_time_max_ns = in.tick_time_ns;
  usual_tick_ns_ = std::min(counters_.tick_time_max_ns, budget_ns);
}

bool ControlLoop::overruns() const { return lateness_ >= kLatenessLimit; }

void ControlLoop::fall_behind(std::uint32_t missed_ticks) {
  controller_.tick += missed_ticks;
  counters_.tick_overruns += missed_ticks;
  const std::uint32_t late_ticks = missed_ticks == 0 ? 1 : missed_ticks;
  const bool at_once = late_ticks >= kLatenessLimit / kLateTickCost;
  lateness_ = at_once ? kLatenessLimit : lateness_ + kLateTickCost * late_ticks;
  if (lateness_ > kLatenessLimit) lateness_ = kLatenessLimit;
}

Snapshot ControlLoop::snapshot() const {
  return between_ticks(controller_.tick, [&](std::uint64_t tick) {
    LoopCounters counters = counters_;
    counters.unexpected_swings = controller_.bound.unexpected_swings;
    return Snapshot{
        tick,  controller_.motion.position_counts, state(), owner_, faults_.latched, counters,
        index_};
  });
}

protocol::Ledger ControlLoop::ledger() const {
  core::ShaftParams shaft;
  protocol::Ledger ledger = between_ticks(controller_.tick, [&](std::uint64_t tick) {
    const core::ControllerParams& params = config_.controller;
    shaft = params.shaft;
    const bool kept = core::traits(params.partition.law).bounds;
    const bool bounds = plan_.bounds && !controller_.bound.new_scene;
    const core::Ledger& sums = controller_.ledger;
    return protocol::Ledger{
        tick,
        kept ? protocol::Toggle::on : protocol::Toggle::off,
        sums.motor,
        sums.spring_twice,
        sums.spring,
        0.0F,
        bounds ? controller_.bound.slope_nm_per_count / params.motion.resolution.rad_per_count
               : 0.0F};
  });
  // Not between two ticks: on a processor without floating point it may take longer than there is.
  ledger.stored_j =
      core::stored_energy_j(shaft, static_cast<float>(ledger.spring) / core::kLedgerTorquesPerNm);
  return ledger;
}

/// Whether somebody who is there may have the actuator, or share it.
bool ControlLoop::may_take() const {
  return !fades() && mail.barred.load(std::memory_order_relaxed) == 0;
}

/// While somebody's torque is let go nobody else is served.
core::ForceSource* ControlLoop::serve_guest() {
  if (phase_ == Phase::letting_go || !guest.awake()) return nullptr;
  const bool may_play = phase_ != Phase::fault && owner_ != Owner::sdk && connected() && may_take();
  const bool asks = guest.take_news(may_play, controller_.tick);
  if (asks && owner_ == Owner::none) enter(Phase::playing, guest.name);
  if (owner_ == guest.name && !fades() && !guest.play_on()) enter(Phase::disarmed);
  return guest.stay_awake(owner_ == guest.name) ? &guest : nullptr;
}

void ControlLoop::end_excitation() {
  const bool over = excitation_.end == core::ExcitationEnd::over;
  report_event(over ? EventKind::excitation_over : EventKind::excitation_stopped);
  enter(Phase::disarmed);
}

/// Ends a torque that nobody is there to end.
void ControlLoop::watch_host() {
  // A game says nothing for as long as nothing changes, and an autonomous device needs nobody.
  const bool other_plays = owner_ != Owner::sdk;
  const bool autonomous = !other_plays && config_.watchdog_ticks == 0;
  if (other_plays || autonomous) silent_ticks_left_ = kForever;
  if (!autonomous && (silent_ticks_left_ == 0 || !connected())) {
    begin_passive(EventKind::watchdog);
  } else if (local_model_ticks_left_ == 1) {
    begin_passive(EventKind::deadline_missed);
  } else if (streams()) {
    --local_model_ticks_left_;
  }
}

void ControlLoop::begin_passive(EventKind why) {
  change(Phase::passive, owner_, config_.passive_ramp_ticks);
  report_event(why);
}

void ControlLoop::choose_torque(bool playing, core::ForceSource* guest_force) {
  // Also while it is let go: it still turns as fast.
  speed_limit_rad_s_ =
      excitation_.on ? config_.excitation_speed_limit_rad_s : config_.speed_limit_rad_s;
  if (playing && !excitation_.on) {
    core::Play play{.scene = owner_ == Owner::sdk ? scene_ : nullptr, .extra = guest_force};
    if (streams()) play.local = &local_model_;
    if (phase_ == Phase::rising) play.gain = rise();
    plan_ = core::plan_of(config_.controller, controller_.bound, play);
    return;
  }
  core::release_count(controller_.motion);
  plan_ = playing ? core::plan_of(excitation_) : core::idle_plan(config_.controller);
}

/// @returns how far the torque has come up
float ControlLoop::rise() {
  const std::uint32_t all = config_.passive_ramp_ticks;
  const std::uint32_t gone = all - phase_ticks_left_;
  if (--phase_ticks_left_ == 0) change(Phase::playing, owner_, 0);
  return static_cast<float>(gone) / static_cast<float>(all);
}

std::uint32_t ControlLoop::find_causes(const TickInputs& in,
                                       const core::ControllerOutputs& out) const {
  std::uint32_t causes = reported_by(in);
  if (out.numeric_error) causes |= fault::numeric;
  // Both directions in one comparison.
  const auto limit_counts = static_cast<std::uint32_t>(config_.jump_limit_counts);
  const bool jumps =
      static_cast<std::uint32_t>(out.motion.delta_counts) + limit_counts > 2 * limit_counts;
  if (jumps) causes |= fault::encoder;
  if (core::absolute(out.motion.speed_rad_s) > speed_limit_rad_s_) causes |= fault::over_speed;
  return causes;
}

/// Latches the faults, and gives what is left where the controller's commands are not followed.
[[gnu::noinline]] TickOutputs ControlLoop::hold_back(std::uint32_t causes,
                                                     std::uint16_t power_faults) {
  if ((causes & fault::actuator) != 0 && power_faults != 0) {
    causes = (causes & ~std::uint32_t{fault::actuator}) | power_faults;
  }
  if (overruns()) causes |= fault::overrun;
  // These endanger only somebody who feels a torque.
  if (!armed()) causes &= ~std::uint32_t{fault::overrun | fault::over_speed};
  if (causes != 0) call();
  if (faults_.latch(causes, phase_)) {
    enter(Phase::fault);
    guest.forget();
  }
  const TickOutputs given = fades() ? fade() : TickOutputs{};
  // The controller must know what became of its commands.
  controller_.slew.motor_command_nm = given.motor_command_nm;
  controller_.brake_command_nm = given.brake_command_nm;
  return given;
}

TickOutputs ControlLoop::fade() {
  if (phase_ticks_left_ == 0) {
    enter(Phase::disarmed);
    return {};
  }
  --phase_ticks_left_;
  motor_fade_.step();
  return {motor_fade_.nm, phase_ == Phase::passive ? config_.passive_brake_nm : 0.0F, true};
}

State ControlLoop::state() const {
  if (phase_ == Phase::disarmed) return State::disarmed;
  return phase_ == Phase::fault ? State::fault : State::armed;
}

/// Nothing else changes phase and owner. A guest that does not play gives no torque.
/// @param ticks until what rises or fades has done so
void ControlLoop::change(Phase phase, Owner owner, std::uint32_t ticks) {
  phase_ = phase;
  owner_ = owner;
  phase_ticks_left_ = ticks;
  if (!plays()) guest.drop();
  if (fades()) motor_fade_.begin(controller_.slew.motor_command_nm, ticks);
}

/// Begins or ends a torque.
void ControlLoop::enter(Phase phase, Owner owner, std::uint32_t ticks) {
  change(phase, owner, ticks);
  controller_.bound.new_scene = true;  // a hand may have turned the knob meanwhile
  lateness_ = 0;
  local_model_ticks_left_ = 0;
  excitation_.on = false;
  excitation_.end = core::ExcitationEnd::none;
  call();
  report_event(EventKind::state_changed);
}

void ControlLoop::report_event(EventKind kind) {
  Answer answer;
  answer.is_event = true;
  answer.event = {kind, state(), faults_.latched, controller_.tick, owner_};
  // With a host that reads nothing the event is lost; the health report still tells the state.
  (void)mail.answers.push(answer);
}

/// Takes from the controller's state what is there: a tick without a sample keeps less at hand.
[[gnu::noinline]] void ControlLoop::sample(float speed_rad_s, float desired_torque_nm,
                                           std::uint8_t saturated) {
  ticks_to_sample_ = static_cast<std::uint8_t>(decimation_ - 1);
  auto flags = static_cast<std::uint8_t>(static_cast<std::uint8_t>(state()) | saturated);
  if (streams()) flags |= flag::local_model;
  if (phase_ == Phase::passive) flags |= flag::passive;
  if (owner_ == Owner::game) flags |= flag::game;
  if (plan_.bounds) desired_torque_nm = core::asked_torque(controller_, plan_);
  if (plan_.bounds && controller_.bound.bounded) flags |= flag::bounded;
  const LoopSample sample{controller_.tick - 1,
                          controller_.motion.position_counts,
                          speed_rad_s,
                          desired_torque_nm,
                          controller_.slew.motor_command_nm,
                          controller_.brake.capacity_nm,
                          controller_.sensor.spring_torque_nm,
                          flags,
                          decimation_};
  if (!mail.samples.push(sample)) ++counters_.samples_dropped;
}

}  // namespace torsio::device
