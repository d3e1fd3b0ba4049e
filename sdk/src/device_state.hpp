/// @file
/// Knowledge of one device: its state, its actuator's owner, and the torque's last end.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "arming.hpp"
#include "event_feed.hpp"
#include "link.hpp"
#include "protocol/reports.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

/// The link's lock guards it. Every member may be called from any thread.
class DeviceState {
 public:
  explicit DeviceState(Link& link) : events(!link.time_is_virtual()), link_(link) {}

  [[nodiscard]] State state();
  /// Waits for a state. @returns false if it does not come in time
  bool wait_for(State state, std::int64_t timeout_ns);
  /// Takes over what a health report says.
  void note(const protocol::Health& health);
  /// Takes the events that were not taken yet, and waits for one. @throws Disconnected, Closed
  std::vector<Event> take_events(std::int64_t timeout_ns);
  /// How the torque went the last time.
  [[nodiscard]] std::optional<Disarm> last_disarm();

  /// Units.
  void configure(const Link::Locked&, const protocol::Identity& identity) { identity_ = identity; }
  void take(const Link::Locked& locked, const protocol::Acknowledgement& answer);
  void take(const Link::Locked& locked, const protocol::Event& event);
  /// The state as telemetry of a tick has it.
  void take(const Link::Locked& locked, State state, std::uint64_t tick);
  void lose(const Link::Locked& locked);
  [[nodiscard]] bool is_armed(const Link::Locked&) const { return state_ == State::armed; }
  /// How the torque went the last time, if it did since it had gone `disarms` times.
  [[nodiscard]] std::optional<Disarm> disarm_since(const Link::Locked& locked,
                                                   std::uint64_t disarms) const;
  [[nodiscard]] std::uint64_t disarms(const Link::Locked&) const { return disarms_; }

  Arming arming;     // takes no lock
  EventFeed events;  // has locks of its own

 private:
  /// Facts about the device from a report.
  struct Said {
    State state;
    Owner owner;
    std::uint16_t faults;
    std::uint64_t tick;
  };

  [[nodiscard]] bool explains(const Said& said, DisarmReason why) const;
  void become(const Link::Locked& locked, const Said& said, DisarmReason why);
  void tell_event(std::string kind, std::uint16_t faults, std::uint64_t tick);

  Link& link_;
  protocol::Identity identity_;
  State state_ = State::disarmed;
  Owner owner_ = Owner::none;
  std::optional<DisarmReason> fading_;  // why the torque is going
  std::optional<Disarm> last_disarm_;
  std::uint64_t disarms_ = 0;
  std::uint64_t said_tick_ = 0;  // of the newest report that says the state
};

}  // namespace torsio
