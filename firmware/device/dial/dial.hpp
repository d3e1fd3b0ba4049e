/// @file The knob as a wheel of the desktop: where it stands becomes units of scrolling, and its
/// notches are asked for while somebody turns it. It belongs to the main loop; detents.hpp has the
/// control interrupt's part.
///
/// A notch is exactly 120 units at any speed and in both directions, because units follow from the
/// position and not from its changes. Within an eighth of a pitch of a notch they do not change. So
/// a knob that friction holds in a notch counts as in it. A radial controller tells the
/// same units as an angle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "device/config.hpp"
#include "device/dial/detents.hpp"
#include "device/dial/haptics.hpp"
#include "device/turn_watch.hpp"
#include "protocol/reports.hpp"

namespace torsio::device::dial {

/// Where the knob stands, in units, 120 to a detent.
std::int64_t units(std::int64_t position_counts, std::uint32_t counts_per_rev,
                   std::uint32_t detents_per_turn);

class Dial final : public GuestFunction {
 public:
  Dial(const Config& config, std::uint32_t period_ns);

  // Reports. They begin with their id.

  /// Answers a request for a feature report.
  /// @returns its size; 0 stalls the request
  std::size_t get_feature(std::uint8_t id, std::span<std::uint8_t> report) override;
  /// Takes a feature report.
  /// @returns false to stall the request; nothing has changed then
  bool set_feature(std::span<const std::uint8_t> report) override;
  /// Takes an output report.
  bool receive(std::span<const std::uint8_t> report) override {
    if (free_use_ == protocol::DialUse::radial) haptics_.receive(report);
    return true;
  }
  /// Writes an input report as it stands. A wheel tells changes, so it stands still.
  /// @returns its size; 0 stalls the request
  std::size_t get_input(std::uint8_t id, std::span<std::uint8_t> report) override;
  /// Writes the next input report.
  /// @returns its size; 0 if nothing is new
  std::size_t next_input(std::span<std::uint8_t> report) override;
  /// The host has taken the last input report, or never will.
  void input_over(bool taken) override;

  // The rest of the device.

  Guest& player() override { return notches_; }
  Wish service(const Moment& now) override;
  void configure(const Config& config) override;
  /// Turns so far are told to nobody, and the state is told anew.
  void settle(bool connected) override;
  /// The host has not asked for the fine resolution yet.
  void begin_anew() override;
  void set_buttons(std::uint8_t pressed) override;

 private:
  /// A part of a detent that the host has not heard of: of where the knob still is, or of before.
  enum class Debt : std::uint8_t { none, fresh, due };
  enum class Listener : std::uint8_t { unknown, prompt, late };

  bool takes_button() const;
  std::uint8_t mouse_buttons() const;
  std::uint8_t puck_button() const;
  protocol::DialUse next_use() const;
  std::int64_t here() const;
  void skip();
  bool listens() const;
  void repeat(std::uint8_t state);
  std::int64_t next_units(bool fine);
  std::int64_t speed_bonus(std::int64_t passed_units);
  void change_use();
  std::size_t tell_news(std::span<std::uint8_t> report);
  std::size_t tell_state(std::span<std::uint8_t> report);
  std::size_t tell_buttons(std::span<std::uint8_t> report, std::uint8_t id);
  std::size_t next_mouse(std::span<std::uint8_t> report);
  std::size_t next_volume(std::span<std::uint8_t> report);
  std::size_t next_radial(std::span<std::uint8_t> report);

  const std::uint32_t period_ns_;
  Detents notches_;
  protocol::DialUse use_ = protocol::DialUse::wheel;          // now
  protocol::DialUse free_use_ = protocol::DialUse::wheel;     // without a button
  protocol::DialUse pressed_use_ = protocol::DialUse::wheel;  // while the first one is pressed
  std::uint32_t counts_per_rev_ = 1;
  std::uint32_t detents_ = 1;
  bool felt_ = false;  // it has notches
  bool reversed_ = false;
  bool coarse_ = false;
  std::int64_t fast_steps_ = 1;
  std::int64_t second_ticks_ = 1;
  std::uint32_t prompt_ticks_ = 1;
  std::uint32_t listen_ticks_ = 1;
  std::uint32_t deaf_ticks_ = 1;

  Moment now_;
  // Where the host believes the knob to be, apart from whole detents that it was never told of. The
  // host sums up units and counts a detent at every 120. So its sum must be full in the notches.
  std::int64_t told_units_ = 0;
  std::int32_t given_units_ = 0;  // of them, in the report that is on its way
  Debt debt_ = Debt::none;
  std::uint8_t state_due_ = 7;  // news for the host: buttons, keys, the puck's button
  std::uint8_t repeat_ = 0;     // of it, what is told once more
  Listener listener_ = Listener::unknown;
  std::uint64_t given_tick_ = 0;    // when the last report was given
  std::uint64_t over_tick_ = 0;     // when it was taken
  std::uint64_t changed_tick_ = 0;  // when a button's change was last told
  std::uint64_t passed_tick_ = 0;   // when the last notch was told
  std::uint8_t fine_ = 0;           // bits of the resolution report
  std::uint8_t buttons_ = 0;
  std::uint8_t buttons_told_ = 0;
  std::uint8_t keys_told_ = 0;
  std::uint8_t puck_told_ = 0;
  bool turned_ = false;   // since the first button was pressed
  bool clicked_ = false;  // it was pressed and let go, which the host has not heard of

  Haptics haptics_;
  TurnWatch turn_watch_;
};

}  // namespace torsio::device::dial
