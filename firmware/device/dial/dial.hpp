/// @file
/// The knob as a wheel of the desktop: where it stands becomes units of scrolling, and its notches
/// are asked for while somebody turns it. It belongs to the main loop; what the control interrupt
/// renders is in detents.hpp.
///
/// A notch is exactly 120 units, whatever way and however fast the knob comes to it: units are told
/// from the position and not from its changes. Within an eighth of a pitch of a notch they do not
/// change, so that wherever friction lets the knob rest in it, it is in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "device/config.hpp"
#include "protocol/reports.hpp"

namespace torsio::device::dial {

/// What the dial reads of the rest of the device.
struct Moment {
  std::uint64_t tick = 0;
  std::int64_t position_counts = 0;
  std::uint32_t zeroings = 0;  // how often this position was set to zero
  protocol::Owner owner = protocol::Owner::none;
};

/// What the dial wants of the actuator.
enum class Wish : std::uint8_t { nothing_new, take, let_go };

/// Where the knob stands, in units, 120 to a detent.
std::int64_t units(std::int64_t position_counts, std::uint32_t counts_per_rev,
                   std::uint32_t detents_per_turn);

class Dial {
 public:
  Dial(const Config& config, std::uint32_t period_ns);

  // Reports. They begin with their id.

  /// Answers a request for a feature report.
  /// @returns its size; 0 stalls the request
  std::size_t get_feature(std::uint8_t id, std::span<std::uint8_t> report) const;
  /// Takes a feature report.
  /// @returns false to stall the request; nothing has changed then
  bool set_feature(std::span<const std::uint8_t> report);
  /// Writes the next input report.
  /// @returns its size; 0 if nothing is new
  std::size_t next_input(std::span<std::uint8_t> report);

  // The rest of the device.

  /// In every round of the main loop.
  Wish service(const Moment& now);
  /// The configuration has changed.
  void configure(const Config& config);
  /// The bus comes or goes: what has happened so far is told to nobody.
  void settle();
  /// A host begins anew: it has not asked for the fine resolution yet.
  void reset() { fine_ = 0; }
  /// Buttons that are pressed, bit 0 the first.
  void set_buttons(std::uint8_t pressed) { buttons_ = pressed; }

 private:
  std::int64_t here() const;
  std::size_t next_mouse(std::span<std::uint8_t> report);
  std::size_t next_volume(std::span<std::uint8_t> report);

  protocol::DialUse use_ = protocol::DialUse::wheel;
  std::uint32_t counts_per_rev_ = 1;
  std::uint32_t detents_ = 1;
  bool felt_ = false;  // it has notches
  std::uint64_t rest_ticks_ = 1;

  Moment now_;
  std::int64_t told_units_ = 0;  // where the host believes the knob to be
  std::uint8_t fine_ = 0;        // bits of the resolution report
  std::uint8_t buttons_ = 0;
  std::uint8_t buttons_told_ = 0;
  std::uint8_t keys_told_ = 0;

  std::int64_t rested_counts_ = 0;
  std::uint64_t turned_tick_ = 0;
  bool turns_ = false;
};

}  // namespace torsio::device::dial
