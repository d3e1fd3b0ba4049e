#include "device_state.hpp"

#include <utility>

#include "conversion/reading.hpp"
#include "protocol_names.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

State state_of(protocol::State state) { return static_cast<State>(state); }
static_assert(static_cast<int>(State::fault) == static_cast<int>(protocol::State::fault));

}  // namespace

State DeviceState::state() {
  const Link::Locked locked = link_.lock();
  link_.look(locked);  // a plug may have been pulled without any time passing
  return state_;
}

bool DeviceState::wait_for(State state, std::int64_t timeout_ns) {
  return link_.wait_until([&](const Link::Locked&) { return state_ == state; }, timeout_ns);
}

std::vector<Event> DeviceState::take_events(std::int64_t timeout_ns) {
  if (timeout_ns == 0) {
    (void)state();  // which takes in what is there
  } else {
    link_.wait_until([&](const Link::Locked&) { return !events.empty(); }, timeout_ns);
  }
  return events.take();
}

std::optional<Disarm> DeviceState::last_disarm() {
  (void)state();
  const Link::Locked locked = link_.lock();
  return last_disarm_;
}

std::optional<Disarm> DeviceState::disarm_since(const Link::Locked&, std::uint64_t disarms) const {
  if (disarms_ == disarms) return std::nullopt;
  return last_disarm_;
}

// News of the device -----------------------------------------------------------------------------

void DeviceState::take(const Link::Locked& locked, const protocol::Acknowledgement& answer) {
  // The event of the same tick came before, unless it was lost.
  become(locked, {state_of(answer.state), static_cast<Owner>(answer.owner), 0, answer.tick},
         arming.is_disarming() ? DisarmReason::order : DisarmReason::unknown);
}

void DeviceState::take(const Link::Locked& locked, const protocol::Event& event) {
  if (event.kind == protocol::EventKind::watchdog) fading_ = DisarmReason::watchdog;
  if (event.kind == protocol::EventKind::deadline_missed) fading_ = DisarmReason::deadline_missed;
  if (event.kind == protocol::EventKind::excitation_over) fading_ = DisarmReason::excitation_over;
  if (event.kind == protocol::EventKind::excitation_stopped) {
    fading_ = DisarmReason::excitation_stopped;
  }
  const State state = state_of(event.state);
  DisarmReason reason = DisarmReason::order;
  if (state == State::fault) {
    reason = DisarmReason::fault;
  } else if (fading_) {
    reason = *fading_;
  } else if (owner_ == Owner::game && !arming.is_disarming()) {
    reason = DisarmReason::game_idle;
  } else if (owner_ == Owner::dial && !arming.is_disarming()) {
    reason = DisarmReason::dial_idle;
  }
  become(locked, {state, static_cast<Owner>(event.owner), event.faults, event.tick}, reason);
  tell_event(event_kind_name(static_cast<std::uint8_t>(event.kind)), event.faults, event.tick);
}

/// The event may be lost: a computer that reads nothing for a while, because its program was
/// stopped, keeps what came first.
void DeviceState::take(const Link::Locked& locked, State state, std::uint64_t tick) {
  if (state_ == State::armed && state != State::armed && tick > said_tick_) {
    become(locked, {state, Owner::none, 0, tick},
           state == State::fault ? DisarmReason::fault : DisarmReason::unknown);
  }
}

void DeviceState::note(const protocol::Health& health) {
  const Link::Locked locked = link_.lock();
  if (link_.is_lost()) return;
  become(locked,
         {state_of(health.state), static_cast<Owner>(health.owner), health.faults,
          link_.newest_tick(locked)},
         DisarmReason::unknown);
}

void DeviceState::lose(const Link::Locked& locked) {
  become(locked, {State::disconnected, Owner::none, 0, link_.newest_tick(locked)},
         DisarmReason::disconnected);
  tell_event("state_changed", 0, link_.newest_tick(locked));
}

/// Whether this is the reason of a disarming that had none.
bool DeviceState::explains(const Said& said, DisarmReason why) const {
  return last_disarm_ && last_disarm_->reason == DisarmReason::unknown && state_ == said.state &&
         why != DisarmReason::unknown;
}

/// Takes over what the device has said about itself. If that means that its torque is gone, keeps
/// why.
void DeviceState::become(const Link::Locked& locked, const Said& said, DisarmReason why) {
  // Before it disarms for these reasons the device has said so.
  if (why == DisarmReason::unknown && fading_) why = *fading_;
  const bool falls = state_ == State::armed && said.state != State::armed;
  // A health report may have been quicker than the event that has the reason.
  if (falls || explains(said, why)) {
    last_disarm_ =
        Disarm{why, fault_names(said.faults), said.tick, conversion::time_s(said.tick, identity_)};
    if (falls) ++disarms_;
  }
  if (said.state != State::armed) fading_.reset();
  said_tick_ = said.tick;
  state_ = said.state;
  owner_ = said.owner;
  arming.hear(is_armed(locked), owner_ == Owner::sdk);
}

void DeviceState::tell_event(std::string kind, std::uint16_t faults, std::uint64_t tick) {
  events.add({std::move(kind), state_, owner_, fault_names(faults), tick,
              conversion::time_s(tick, identity_)});
}

}  // namespace torsio
