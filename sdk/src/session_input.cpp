// Session: reports of the device, and the state that follows from them.
#include <algorithm>
#include <utility>

#include "protocol/axis_samples.hpp"
#include "protocol_names.hpp"
#include "session.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

State state_of(protocol::State state) { return static_cast<State>(state); }
static_assert(static_cast<int>(State::fault) == static_cast<int>(protocol::State::fault));

}  // namespace

// In ---------------------------------------------------------------------------------------------

void Session::read_loop() {
  auto keep_alive_at = steady_clock::now();
  while (!closed_) {
    bool armed = false;
    try {
      protocol::ReportBytes report;
      const std::chrono::nanoseconds period(keep_alive_ns_);
      const bool got = transport_->read(report, std::min<std::chrono::nanoseconds>(period, 20ms));
      {
        const std::lock_guard lock(mutex_);
        if (got) dispatch(report);
        armed = state_ == State::armed;
      }
      // Without the lock, which those who are woken want at once.
      if (got) news_.notify_all();
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex_);
      lose(error.what());
      return;
    }
    const auto now = steady_clock::now();
    if (armed && now >= keep_alive_at && send_keep_alive()) {
      keep_alive_at = now + std::chrono::nanoseconds(keep_alive_ns_);
      const std::lock_guard lock(mutex_);
      log(true, keep_alive_report());
    }
  }
}

void Session::lose(const std::string& why) {
  if (lost_.empty()) {
    lost_ = why;
    if (state_ == State::armed && owner_ == Owner::sdk) may_drive_ = true;
    become({State::disconnected, Owner::none, 0, newest_tick_}, DisarmReason::disconnected);
    tell_event("state_changed", 0, newest_tick_);
  }
  news_.notify_all();
}

void Session::dispatch(const protocol::ReportBytes& report) {
  ++statistics_.reports_received;
  if (!taps_.empty()) log(false, report);
  const auto decode = [&]<class Report>(Report content) {
    if (protocol::decode(report, content).ok()) {
      dispatch(content);
    } else {
      ++statistics_.reports_undecodable;
    }
  };
  switch (report[0]) {
    case protocol::Layout<protocol::Telemetry>::id:
      decode(protocol::Telemetry{});
      break;
    case protocol::Layout<protocol::Acknowledgement>::id:
      decode(protocol::Acknowledgement{});
      break;
    case protocol::Layout<protocol::Event>::id:
      decode(protocol::Event{});
      break;
    default:
      ++statistics_.reports_undecodable;
  }
}

void Session::dispatch(const protocol::Telemetry& report) {
  const std::uint64_t samples = protocol::samples_of(report.axis_samples);
  const std::uint64_t last_tick = report.tick + report.decimation * (samples - 1);
  if (last_tick < stream_from_tick_) return;
  const auto take = [&](const TelemetrySample& sample) {
    if (sample.tick < stream_from_tick_) return;
    // A recording loses nothing.
    bool taken = false;
    for (Listener* listener : listeners_) taken |= listener->take(sample);
    if (!ring_.push(sample) && !taken) ++statistics_.samples_lost;
    ++statistics_.samples_received;
    if (sample.tick == last_tick) latest_ = sample;
    newest_tick_ = sample.tick;
  };
  statistics_.samples_lost += decoder_.decode(report, take);
  // The event may be lost: a computer that reads nothing for a while, because its program was
  // stopped, keeps what came first.
  const auto state = static_cast<State>(report.flags & protocol::flag::state_mask);
  if (state_ == State::armed && state != State::armed && last_tick > said_tick_) {
    become({state, Owner::none, 0, last_tick},
           state == State::fault ? DisarmReason::fault : DisarmReason::unknown);
  }
}

void Session::dispatch(const protocol::Acknowledgement& answer) {
  newest_tick_ = answer.tick;
  // The event of the same tick came before, unless it was lost.
  become({state_of(answer.state), static_cast<Owner>(answer.owner), 0, answer.tick},
         disarming_ > 0 ? DisarmReason::order : DisarmReason::unknown);
  if (answer.report == protocol::Layout<protocol::LocalModel>::id) {
    ++statistics_.local_models_refused;
    statistics_.last_refusal =
        status_name(answer.status) + ": " + std::string(status_advice(answer.status));
    return;
  }
  if (answer.report == protocol::Layout<protocol::Stream>::id && answer.status == 0 &&
      std::exchange(stream_starts_, false)) {
    // Here and not where somebody waits for it: the first samples may be right behind.
    decoder_.begin_stream();
    ring_.clear();
    stream_from_tick_ = answer.tick;
    latest_.reset();
  }
  const auto pending = std::ranges::find(pending_, answer.sequence, &Pending::sequence);
  if (pending != pending_.end()) pending->answer = answer;
}

void Session::dispatch(const protocol::Event& event) {
  newest_tick_ = event.tick;
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
  } else if (owner_ == Owner::game && disarming_ == 0) {
    reason = DisarmReason::game_idle;
  } else if (owner_ == Owner::dial && disarming_ == 0) {
    reason = DisarmReason::dial_idle;
  }
  become({state, static_cast<Owner>(event.owner), event.faults, event.tick}, reason);
  tell_event(event_kind_name(static_cast<std::uint8_t>(event.kind)), event.faults, event.tick);
}

/// Takes over what the device has said about itself. If that means that its torque is gone, keeps
/// why.
void Session::become(const Said& said, DisarmReason why) {
  // Before it disarms for these reasons the device has said so.
  if (why == DisarmReason::unknown && fading_) why = *fading_;
  const bool falls = state_ == State::armed && said.state != State::armed;
  // A health report may have been quicker than the event that has the reason.
  const bool explains = last_disarm_ && last_disarm_->reason == DisarmReason::unknown &&
                        state_ == said.state && why != DisarmReason::unknown;
  if (falls || explains) {
    last_disarm_ = Disarm{why, fault_names(said.faults), said.tick, decoder_.time_s(said.tick)};
    if (falls) ++disarms_;
  }
  if (said.state != State::armed) fading_.reset();
  said_tick_ = said.tick;
  state_ = said.state;
  owner_ = said.owner;
}

void Session::tell_event(std::string kind, std::uint16_t faults, std::uint64_t tick) {
  events_.add({std::move(kind), state_, owner_, fault_names(faults), tick, decoder_.time_s(tick)});
}

// Facts about the device
// ----------------------------------------------------------------------------------

State Session::state() {
  const std::lock_guard lock(mutex_);
  if (closed_) throw_if_gone();
  // A plug may have been pulled without any time passing.
  if (transport_->time_is_virtual() && lost_.empty()) take_in_virtual();
  return state_;
}

bool Session::drives() {
  if (state() != State::armed) return false;
  const std::lock_guard lock(mutex_);
  return owner_ == Owner::sdk;
}

void Session::note(const protocol::Health& health) {
  const std::lock_guard lock(mutex_);
  if (!lost_.empty()) return;
  become({state_of(health.state), static_cast<Owner>(health.owner), health.faults, newest_tick_},
         DisarmReason::unknown);
}

LinkStatistics Session::statistics() const {
  const std::lock_guard lock(mutex_);
  LinkStatistics statistics = statistics_;
  statistics.reports_sent = reports_sent_;
  statistics.events_lost = events_.lost();
  return statistics;
}

void Session::set_watchdog(double watchdog_s) {
  keep_alive_ns_ = static_cast<std::int64_t>(watchdog_s * 1e9 / 3.0);
}

std::vector<Event> Session::take_events(std::int64_t timeout_ns) {
  if (timeout_ns == 0) {
    (void)state();  // which takes in what is there
  } else {
    wait_until([&] { return !events_.empty(); }, timeout_ns);
  }
  return events_.take();
}

std::optional<Disarm> Session::last_disarm() {
  (void)state();
  const std::lock_guard lock(mutex_);
  return last_disarm_;
}

std::uint64_t Session::disarms() const {
  const std::lock_guard lock(mutex_);
  return disarms_;
}

}  // namespace torsio
