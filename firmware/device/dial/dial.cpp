#include "device/dial/dial.hpp"

#include "core/math.hpp"
#include "device/dial/report_descriptor.hpp"

namespace torsio::device::dial {
namespace {

using protocol::DialUse;

// More than the flicker of an encoder that stands between two counts.
constexpr std::int64_t kTurnedCounts = 2;
// A dial that nobody turns for so long lets go of the actuator.
constexpr float kRestS = 1.0F;
// 1 of so many shares of a pitch, on either side of a notch, belongs to the notch.
constexpr std::int64_t kNotchShare = 8;

std::int64_t clamp(std::int64_t value, std::int64_t limit) {
  return value > limit ? limit : value < -limit ? -limit : value;
}

void put(std::span<std::uint8_t> report, std::size_t at, std::int64_t value) {
  report[at] = static_cast<std::uint8_t>(value);
  report[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

}  // namespace

std::int64_t units(std::int64_t position_counts, std::uint32_t counts_per_rev,
                   std::uint32_t detents_per_turn) {
  const std::int64_t pitch = counts_per_rev;  // in shares of a count: as many as there are detents
  std::int64_t turn = position_counts / pitch;
  std::int64_t rest = position_counts % pitch;
  if (rest < 0) {
    rest += pitch;
    --turn;
  }
  const std::int64_t place = rest * detents_per_turn;
  const std::int64_t notch = (2 * place + pitch) / (2 * pitch);
  const std::int64_t beyond = place - notch * pitch;  // from minus half a pitch to half of one
  const std::int64_t away = kNotchShare * (beyond < 0 ? -beyond : beyond) - pitch;
  // Half of the units on either side, over what the notch leaves of half a pitch.
  const std::int64_t part = away <= 0 ? 0 : away * (kUnits / 2) / ((kNotchShare / 2 - 1) * pitch);
  return (turn * detents_per_turn + notch) * kUnits + (beyond < 0 ? -part : part);
}

Dial::Dial(const Config& config, std::uint32_t period_ns) {
  rest_ticks_ = core::round_to_u32(kRestS * 1e9F / static_cast<float>(period_ns));
  configure(config);
}

void Dial::configure(const Config& config) {
  use_ = config.game.dial_use;
  counts_per_rev_ = config.actuator.counts_per_rev;
  detents_ = config.game.dial_detents;
  felt_ = config.game.dial_torque_nm > 0.0F;
  told_units_ = here();
}

std::int64_t Dial::here() const { return units(now_.position_counts, counts_per_rev_, detents_); }

void Dial::settle() {
  told_units_ = here();
  buttons_told_ = 0;
  keys_told_ = 0;
}

Wish Dial::service(const Moment& now) {
  const bool moved_origin = now.zeroings != now_.zeroings;
  now_ = now;
  if (moved_origin) rested_counts_ = now.position_counts;
  // What a program makes of the knob is not the desktop's.
  if (moved_origin || now.owner == protocol::Owner::sdk) told_units_ = here();
  const std::int64_t turned = now.position_counts - rested_counts_;
  if (turned >= kTurnedCounts || turned <= -kTurnedCounts) {
    rested_counts_ = now.position_counts;
    turned_tick_ = now.tick;
    turns_ = felt_;
    return felt_ ? Wish::take : Wish::nothing_new;
  }
  if (!turns_ || now.tick - turned_tick_ <= rest_ticks_) return Wish::nothing_new;
  turns_ = false;
  return Wish::let_go;
}

std::size_t Dial::get_feature(std::uint8_t id, std::span<std::uint8_t> report) const {
  if (id != kResolutionReport || report.size() < kShortReportSize) return 0;
  report[0] = kResolutionReport;
  report[1] = fine_;
  return kShortReportSize;
}

bool Dial::set_feature(std::span<const std::uint8_t> report) {
  if (report.size() != kShortReportSize || report[0] != kResolutionReport) return false;
  if ((report[1] & ~(kWheelFine | kPanFine)) != 0) return false;
  fine_ = report[1];
  return true;
}

std::size_t Dial::next_input(std::span<std::uint8_t> report) {
  if (report.size() < kMouseReportSize) return 0;
  if (use_ == DialUse::volume || keys_told_ != 0) {
    if (const std::size_t size = next_volume(report)) return size;
  }
  return next_mouse(report);
}

std::size_t Dial::next_mouse(std::span<std::uint8_t> report) {
  const std::uint8_t fine_bit = use_ == DialUse::pan ? kPanFine : kWheelFine;
  const std::int64_t step_units = (fine_ & fine_bit) != 0 ? 1 : kUnits;
  // Whole steps; what is left over is told with the next ones.
  std::int64_t steps = clamp((here() - told_units_) / step_units, kMost);
  if (use_ == DialUse::volume) steps = 0;
  if (steps == 0 && buttons_ == buttons_told_) return 0;
  told_units_ += steps * step_units;
  buttons_told_ = buttons_;
  report[0] = kMouseReport;
  report[1] = buttons_;
  report[2] = 0;
  report[3] = 0;
  // A wheel's positive way is away from the user, which scrolls up.
  put(report, 4, use_ == DialUse::pan ? 0 : -steps);
  put(report, 6, use_ == DialUse::pan ? steps : 0);
  return kMouseReportSize;
}

/// A key goes down for each detent, and up again.
std::size_t Dial::next_volume(std::span<std::uint8_t> report) {
  std::uint8_t keys = 0;
  if (keys_told_ == 0) {
    const std::int64_t detents = (here() - told_units_) / kUnits;
    if (detents == 0) return 0;
    keys = detents > 0 ? kLouder : kQuieter;
    told_units_ += detents > 0 ? kUnits : -kUnits;
  }
  keys_told_ = keys;
  report[0] = kVolumeReport;
  report[1] = keys;
  return kShortReportSize;
}

}  // namespace torsio::device::dial
