/// @file
/// Orders to arm and to disarm, and whether the SDK may still drive.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "protocol/reports.hpp"

namespace torsio {

/// Takes no lock: the order to disarm waits for nobody. Every member may be called from any thread.
class Arming {
 public:
  /// From the SDK's orders and the device's reports. tests/cpp/sdk/test_arming.cpp has the table.
  enum class Phase : std::uint8_t {
    off,      // not told to arm since an order to disarm was answered
    ordered,  // told to arm
    drives,   // said to be armed by the SDK
    fell,     // told to arm, and at rest at some time since, if that was no nonsense
    another,  // and then armed by a game or the dial
  };
  enum class Event : std::uint8_t {
    order,       // to arm
    settled,     // one to arm refused, or one to disarm answered
    ours,        // the device says that it is armed by the SDK,
    others,      // by somebody else,
    rest,        // or not armed,
    early_rest,  // maybe because an order to arm is still under way
  };
  [[nodiscard]] static Phase after(Phase phase, Event event);

  [[nodiscard]] Phase phase() const { return word_.load().phase; }
  [[nodiscard]] bool may_drive() const {
    return phase() != Phase::off && phase() != Phase::another;
  }
  /// Takes over what the device says.
  void hear(bool is_armed, bool is_ours);
  /// From here on an order to arm throws Closed.
  void forbid() noexcept;
  /// Another thread gives an order to arm.
  [[nodiscard]] bool is_under_way() const noexcept;
  /// Waits for such orders, but not for ever.
  void outlast() const noexcept;
  /// An order to disarm is under way.
  [[nodiscard]] bool is_disarming() const { return disarming_ > 0; }
  class Order;

 private:
  struct Word {
    Phase phase = Phase::off;
    bool is_forbidden = false;
    std::uint16_t under_way = 0;  // orders to arm,
    std::uint32_t begun = 0;      // and how many ever
  };
  static_assert(std::atomic<Word>::is_always_lock_free);

  template <class Change>
  Word change(Change&& change);

  std::atomic<Word> word_{};
  std::atomic<int> disarming_{0};  // orders to disarm that are under way
  // Who gave the newest order to arm, while it is under way: a signal's handler may close there.
  std::atomic<std::thread::id> armer_{};
};

/// An order to arm or disarm while it is under way.
class Arming::Order {
 public:
  Order(Arming& arming, protocol::Op op);
  Order(const Order&) = delete;
  Order& operator=(const Order&) = delete;
  ~Order();
  [[nodiscard]] bool disarms() const { return disarms_; }
  void taken();
  void refused();

 private:
  void settle();

  Arming& arming_;
  const bool arms_;
  const bool disarms_;
  Word begin_;
};

}  // namespace torsio
