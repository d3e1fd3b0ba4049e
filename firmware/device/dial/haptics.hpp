/// @file
/// Feedback that a host asks a radial controller for: clicks, a buzz, and weaker detents or none
/// (HID Usage Tables 1.4, chapter 14, and Microsoft's guidelines for radial controllers). It
/// belongs to the main loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "device/dial/feel.hpp"

namespace torsio::device::dial {

class Haptics {
 public:
  explicit Haptics(std::uint32_t period_ns) : ms_ticks_(1'000'000 / period_ns) {}

  /// Answers a request for a feature report.
  /// @returns its size; 0 stalls the request
  std::size_t get_feature(std::uint8_t id, std::span<std::uint8_t> report) const;
  /// Takes a feature report.
  /// @returns false to stall the request; nothing has changed then
  bool set_feature(std::span<const std::uint8_t> report);
  /// Takes an output report: a waveform begins, or stops.
  void receive(std::span<const std::uint8_t> report);
  /// In every round of the main loop.
  /// @returns whether a waveform plays
  bool service(std::uint64_t tick);
  /// Nothing plays any more.
  void stop() { waveform_ = 0; }
  /// A host begins that has asked for nothing yet.
  void begin_anew();
  /// @param radial the host decides on the detents
  Feel feel(bool radial) const;

 private:
  struct Settings {
    std::uint8_t waveform;  // ordinal
    std::uint8_t intensity_percent;
    std::uint8_t repeats;
    std::uint16_t retrigger_ms;
  };
  static Settings read(std::span<const std::uint8_t> report);

  static constexpr Settings kDefaults{3, 100, 0, 0};
  std::uint32_t ms_ticks_;
  std::uint64_t tick_ = 0;
  Settings defaults_ = kDefaults;
  std::uint8_t waveform_ = 0;  // that plays
  std::uint8_t strength_ = 0;  // of kFullFeel
  std::uint8_t left_ = 0;      // clicks after the next one
  std::uint32_t retrigger_ticks_ = 0;
  std::uint64_t next_tick_ = 0;
  std::uint64_t end_tick_ = 0;
  std::uint32_t pulses_ = 0;
};

}  // namespace torsio::device::dial
