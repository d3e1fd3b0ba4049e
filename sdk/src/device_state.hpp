/// @file
/// Knowledge of one device: its state, its actuator's owner, and the torque's last end.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "event_feed.hpp"
#include "link.hpp"
#include "protocol/reports.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

/// The link's lock guards it. Every member may be called from any thread; the link's reader calls
/// those that ask for the lock.
class DeviceState {
 public:
  explicit DeviceState(Link& link) : events(!link.time_is_virtual()), link_(link) {}

  [[nodiscard]] State state();
  /// Armed by the SDK, or told to arm with no answered order to disarm since: what came meanwhile
  /// may be nonsense. False if a game or the dial has it. Takes no lock: the order to disarm waits.
  [[nodiscard]] bool may_drive() const { return drives_ || (told_to_arm_ && !is_others_); }
  /// From here on an order to arm throws Closed.
  void forbid_arming() noexcept { closing_ = true; }
  /// Another thread gives an order to arm.
  [[nodiscard]] bool is_arming() const noexcept;
  /// Waits for such orders, but not for ever.
  void outlast_arming() const noexcept;
  /// Waits for a state. @returns false if it does not come in time
  bool wait_for(State state, std::int64_t timeout_ns);
  /// Takes over what a health report says.
  void note(const protocol::Health& health);
  /// Takes the events that were not taken yet, and waits for one. @throws Disconnected, Closed
  std::vector<Event> take_events(std::int64_t timeout_ns);
  /// How the torque went the last time.
  [[nodiscard]] std::optional<Disarm> last_disarm();

  /// An order to arm or disarm while it is under way.
  class Order {
   public:
    Order(DeviceState& device, protocol::Op op);
    Order(const Order&) = delete;
    Order& operator=(const Order&) = delete;
    ~Order();
    [[nodiscard]] bool disarms() const { return disarms_; }
    void taken();
    void refused();

   private:
    /// No order to arm was under way at its begin or has begun since.
    [[nodiscard]] bool decides() const { return was_alone_ && device_.arms_ == arms_before_; }

    DeviceState& device_;
    const bool arms_;
    const bool disarms_;
    std::uint64_t arms_before_ = 0;
    bool was_alone_ = false;
  };

  // With the link's lock held:
  /// Units.
  void configure(const protocol::Identity& identity) { identity_ = identity; }
  void take(const protocol::Acknowledgement& answer);
  void take(const protocol::Event& event);
  /// The state as telemetry of a tick has it.
  void take(State state, std::uint64_t tick);
  void lose();
  [[nodiscard]] bool is_armed() const { return state_ == State::armed; }
  /// How the torque went the last time, if it did since it had gone `disarms` times.
  [[nodiscard]] std::optional<Disarm> disarm_since(std::uint64_t disarms) const;
  [[nodiscard]] std::uint64_t disarms() const { return disarms_; }

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
  void become(const Said& said, DisarmReason why);
  void note_owner();
  void tell_event(std::string kind, std::uint16_t faults, std::uint64_t tick);

  Link& link_;
  std::atomic<int> disarming_{0};         // orders to disarm that are under way
  std::atomic<int> arming_{0};            // and to arm
  std::atomic<std::uint64_t> arms_{0};    // orders to arm that have begun
  std::atomic<bool> closing_{false};      // none may begin
  std::atomic<bool> drives_{false};       // armed, as last heard of, and the SDK owns it
  std::atomic<bool> is_others_{false};    // armed, and somebody else does
  std::atomic<bool> rested_{true};        // disarmed at some time since the last order to arm
  std::atomic<bool> told_to_arm_{false};  // and no order to disarm was answered since
  protocol::Identity identity_;
  State state_ = State::disarmed;
  Owner owner_ = Owner::none;
  std::optional<DisarmReason> fading_;  // why the torque is going
  std::optional<Disarm> last_disarm_;
  std::uint64_t disarms_ = 0;
  std::uint64_t said_tick_ = 0;  // of the newest report that says the state
};

}  // namespace torsio
