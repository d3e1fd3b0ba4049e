#include "device/dial/haptics.hpp"

#include <algorithm>
#include <array>

#include "device/dial/report_descriptor.hpp"

namespace torsio::device::dial {
namespace {

std::uint8_t strength(std::uint8_t intensity_percent) {
  return static_cast<std::uint8_t>(intensity_percent * kFullFeel / 100);
}

}  // namespace

Haptics::Settings Haptics::read(std::span<const std::uint8_t> report) {
  const auto retrigger_ms = static_cast<std::uint16_t>(report[4] | report[5] << 8);
  return {report[1], report[2], report[3], retrigger_ms};
}

std::size_t Haptics::get_feature(std::uint8_t id, std::span<std::uint8_t> report) const {
  if (id == kHapticsReport && report.size() >= kHapticsReportSize) {
    const std::array<std::uint8_t, kHapticsReportSize> bytes{id,
                                                             defaults_.waveform,
                                                             defaults_.intensity_percent,
                                                             defaults_.repeats,
                                                             hid::low(defaults_.retrigger_ms),
                                                             hid::high(defaults_.retrigger_ms)};
    std::copy(bytes.begin(), bytes.end(), report.begin());
    return bytes.size();
  }
  if (id == kWaveformsReport && report.size() >= kWaveformsReportSize) {
    constexpr std::array<std::uint8_t, kWaveformsReportSize> kBytes{
        kWaveformsReport,     0x37,   0x00,  0x01,     0x00, hid::low(kCutoffMs),
        hid::high(kCutoffMs), kClick, kBuzz, kClickMs, 0};
    std::copy(kBytes.begin(), kBytes.end(), report.begin());
    return kBytes.size();
  }
  return 0;
}

bool Haptics::set_feature(std::span<const std::uint8_t> report) {
  if (report.size() != kHapticsReportSize || report[0] != kHapticsReport) return false;
  const Settings asked = read(report);
  if (asked.waveform > kBuzz || asked.intensity_percent > 100) return false;
  if (asked.retrigger_ms > kMostRetriggerMs) return false;
  defaults_ = asked;
  return true;
}

void Haptics::receive(std::span<const std::uint8_t> report) {
  if (report.size() != kHapticsReportSize || report[0] != kHapticsReport) return;
  const Settings asked = read(report);
  if (asked.waveform == kStop) stop();
  if (asked.waveform != kClick && asked.waveform != kBuzz) return;
  // HID: a value outside its range is none.
  const bool has_intensity = asked.intensity_percent <= 100;
  const bool has_period = asked.retrigger_ms <= kMostRetriggerMs;
  waveform_ = asked.waveform;
  strength_ = strength(has_intensity ? asked.intensity_percent : defaults_.intensity_percent);
  left_ = asked.repeats;
  const std::uint16_t period_ms = has_period ? asked.retrigger_ms : defaults_.retrigger_ms;
  retrigger_ticks_ = std::max<std::uint32_t>(period_ms, kClickMs) * ms_ticks_;
  next_tick_ = tick_;
  end_tick_ = tick_ + std::uint64_t{kCutoffMs} * ms_ticks_;
}

bool Haptics::service(std::uint64_t tick) {
  tick_ = tick;
  if (tick >= end_tick_) stop();
  if (waveform_ == 0) return false;
  if (waveform_ == kBuzz || tick < next_tick_) return true;
  ++pulses_;
  next_tick_ = tick + retrigger_ticks_;
  if (left_-- == 0) stop();
  return true;
}

void Haptics::begin_anew() {
  stop();
  defaults_ = kDefaults;
}

Feel Haptics::feel(bool radial) const {
  // The waveform that the device plays of itself is its detents.
  const bool automatic = defaults_.waveform == kClick || defaults_.waveform == kBuzz;
  const std::uint32_t asked = automatic ? strength(defaults_.intensity_percent) : 0;
  return Feel::make(radial ? asked : kFullFeel, strength_, waveform_ == kBuzz, pulses_);
}

}  // namespace torsio::device::dial
