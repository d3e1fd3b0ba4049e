/// @file
/// Who plays besides the SDK: a game or the dial. A device has one guest for life.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/force_source.hpp"
#include "device/hid_function.hpp"
#include "protocol/enumerations.hpp"

namespace torsio::device {

/// State of the device that a guest reads.
struct Moment {
  std::uint64_t tick = 0;
  std::int64_t position_counts = 0;
  std::uint32_t zeroings = 0;  // how often this position was set to zero
  protocol::Owner owner = protocol::Owner::none;
};

/// Its wish for the actuator.
enum class Wish : std::uint8_t { nothing_new, take, let_go };

struct Config;

/// The control interrupt's side of it.
class Guest : public core::ForceSource {
 public:
  // Control interrupt, in ticks that decide.

  const protocol::Owner name;
  /// There may be something to do.
  bool awake() const { return awake_.load(std::memory_order_relaxed) != 0; }
  /// Takes what has arrived.
  /// @param may_play it may have the actuator, or has it
  /// @returns true if it wants the actuator
  virtual bool take_news(bool may_play, std::uint64_t tick) = 0;
  /// Once a tick while it has the actuator. @returns false if it has ended
  virtual bool play_on() = 0;
  /// Once a tick: else it sleeps. @returns true if it has a torque to give
  virtual bool stay_awake(bool has_actuator) = 0;
  /// Its torque fades.
  virtual void release() = 0;
  /// Its torque is gone at once: the actuator is off.
  virtual void drop() { wanted_.store(0, std::memory_order_relaxed); }
  /// What has ended does not come back by an update any more.
  virtual void forget() {}
  /// Takes the parameters that the main loop has prepared. Only while nobody plays.
  virtual void configure() = 0;
  /// @param attention becomes 1 as soon as there is something to do
  void call_by(std::atomic<std::uint32_t>& attention) { attention_ = &attention; }

  // Main loop.

  /// Somebody turns the knob, or nobody any more.
  void want(bool wanted) {
    wanted_.store(wanted ? 1 : 0, std::memory_order_relaxed);
    call();
  }

 protected:
  explicit Guest(protocol::Owner owner) : name(owner) {}
  ~Guest() = default;
  bool wanted() const { return wanted_.load(std::memory_order_relaxed) != 0; }
  void call() {
    awake_.store(1, std::memory_order_release);
    attention_->store(1, std::memory_order_release);
  }

  std::atomic<std::uint32_t> awake_{1};  // set by both contexts, cleared by the interrupt only

 private:
  std::atomic<std::uint32_t>* attention_ = &awake_;
  std::atomic<std::uint32_t> wanted_{0};
};

/// The main loop's side: its interface of USB.
class GuestFunction : public HidFunction {
 public:
  virtual Guest& player() = 0;
  /// In every round of the main loop.
  virtual Wish service(const Moment& now) = 0;
  /// The configuration has changed. The interrupt's side takes it later.
  virtual void configure(const Config& config) = 0;
  /// The bus comes or goes.
  virtual void settle(bool connected) = 0;
  /// A host begins that knows nothing.
  virtual void begin_anew() {}
  /// Buttons that are pressed, bit 0 the first.
  virtual void set_buttons(std::uint8_t pressed) = 0;

 protected:
  ~GuestFunction() = default;
};

}  // namespace torsio::device
