/// @file The game interface: a HID PID device's pool of effect blocks, its reports in and out, and
/// the knob as a joystick's axis. It belongs to the main loop; the control interrupt gets orders
/// (forces.hpp).
///
/// Parameters may come in any order and over either endpoint, each names its block. A report that
/// does not fit (a free block, another kind of effect, a value without meaning) changes nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "device/game/effect_block.hpp"
#include "device/game/forces.hpp"
#include "device/game/params.hpp"
#include "device/turn_watch.hpp"
#include "protocol/reports.hpp"

namespace torsio::device::game {

class PidEngine final : public GuestFunction {
 public:
  PidEngine(const Config& config, std::uint32_t period_ns);

  // Reports. They begin with their id.

  /// Answers a request for a feature report.
  /// @returns its size; 0 stalls the request
  std::size_t get_feature(std::uint8_t id, std::span<std::uint8_t> report) override;
  /// Takes a feature report.
  /// @returns false to stall the request; nothing has changed then
  bool set_feature(std::span<const std::uint8_t> report) override;
  /// Takes an output report at once: there is no queue. One that cannot be read is ignored.
  bool receive(std::span<const std::uint8_t> report) override;
  /// Writes an input report as things are.
  /// @returns its size; 0 stalls the request
  std::size_t get_input(std::uint8_t id, std::span<std::uint8_t> report) override;
  /// Writes the next input report: the axis when it moved, and now and then for new listeners; then
  /// effects that have begun or ended.
  /// @returns its size; 0 if nothing is new
  std::size_t next_input(std::span<std::uint8_t> report) override;

  // The rest of the device.

  /// Effects of games, for watchers; the next effects in turns.
  protocol::GameMonitor monitor(float torque_step_nm);
  Guest& player() override { return forces_; }
  /// @returns what the player's own feel wants of the actuator
  Wish service(const Moment& now) override;
  void configure(const Config& config) override;
  /// When nobody is on the bus any more everything is set aside. The blocks are kept.
  void settle(bool connected) override;
  /// A press starts the effects it triggers.
  void set_buttons(std::uint8_t pressed) override { buttons_ = pressed; }

 private:
  template <class Report>
  void take(const Report& report);
  void take(const EffectOperation& operation);
  void take(const BlockFree& free);
  void take(const DeviceControl& report);
  void take(const DeviceGain& gain);
  Block* find(std::uint8_t index);
  void touch(Block& block);
  void count(Block& block);
  void create(EffectType type);
  void play(Block& block, std::uint8_t loops);
  void stop_all();
  void send_orders();
  bool send_endings();
  bool send_settings();
  void send_blocks();
  void watch_silence();
  void watch_reader();
  void set_all_aside();
  void watch_triggers();
  static bool triggers(const Block& block, std::uint8_t buttons);
  std::size_t next_joystick(std::span<std::uint8_t> report);
  std::size_t next_state(std::span<std::uint8_t> report);
  std::size_t send(const PidState& state, std::span<std::uint8_t> report);
  std::int16_t axis() const;
  std::uint8_t status() const;
  bool plays(std::size_t index) const;
  void leave_all();
  bool plays_any() const;
  bool holds_any() const;
  bool is_aside(std::size_t index) const;
  std::uint16_t pool_available() const;
  bool friction_holds() const;

  Forces forces_;
  std::uint32_t period_ns_;
  GameScale scale_;
  Moment now_;
  TurnWatch turn_watch_;

  std::array<Block, kBlocks> blocks_;
  BlockLoad block_load_;

  std::uint32_t controls_ = 0;  // the last four device controls with no other report between them
  bool host_folds_ = false;     // the negative saturation, maybe; see effect_block.cpp

  float gain_ = 1;
  bool paused_ = false;
  bool enabled_ = true;
  bool settings_dirty_ = true;
  bool stop_all_dirty_ = false;
  bool all_aside_dirty_ = false;
  bool blocks_dirty_ = false;    // some may be; there are too many to ask in every round
  std::uint8_t next_dirty_ = 0;  // block to look at first, so that each gets its turn

  std::uint32_t updates_ = 0;   // reports, ever
  std::uint8_t monitored_ = 0;  // block that was shown last, from 1
  std::uint64_t asked_since_tick_ = 0;
  float asked_nm_ = 0;  // the most that effects asked for in the half second before that

  std::uint8_t buttons_ = 0;
  std::uint8_t buttons_seen_ = 0;
  std::uint64_t heard_tick_ = 0;
  bool heard_ = false;
  std::uint64_t asked_tick_ = 0;  // for an input report
  bool asked_ = false;
  bool offered_ = false;  // a report waits to be fetched
  bool reader_ = false;   // somebody fetches them

  Joystick joystick_;
  bool joystick_sent_ = false;
  std::uint64_t joystick_tick_ = 0;
  bool joystick_turn_ = false;
  std::uint8_t status_sent_ = 0;
  bool state_due_ = true;
  std::array<std::uint32_t, 2> playing_sent_{};
};

/// Where friction holds the knob, its own spring need not.
inline bool PidEngine::friction_holds() const {
  const std::int64_t held = scale_.hold_counts;
  return held != 0 && (now_.position_counts > held || now_.position_counts < -held);
}

// Inline, with calls only when there is work: nearly all rounds find none.
inline Wish PidEngine::service(const Moment& now) {
  const bool origin_moved = now.zeroings != now_.zeroings;
  now_ = now;
  if (heard_) heard_tick_ = now.tick;
  heard_ = false;
  if (asked_) asked_tick_ = now.tick;
  asked_ = false;
  const bool hears = scale_.silence_ticks == 0 || now_.tick - heard_tick_ <= scale_.silence_ticks;
  if (!hears) watch_silence();
  if (reader_) watch_reader();
  if (now.tick - asked_since_tick_ >= scale_.abandoned_ticks) {
    asked_since_tick_ = now.tick;
    asked_nm_ = forces_.take_asked_nm();
  }
  if ((buttons_ | buttons_seen_) != 0) watch_triggers();
  if (settings_dirty_ || blocks_dirty_ || stop_all_dirty_ || all_aside_dirty_) send_orders();
  return turn_watch_.see(now, origin_moved, scale_.own_is_felt, friction_holds());
}

}  // namespace torsio::device::game
