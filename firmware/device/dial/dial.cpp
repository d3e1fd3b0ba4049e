#include "device/dial/dial.hpp"

#include <algorithm>

#include "core/math.hpp"
#include "device/dial/report_descriptor.hpp"

namespace torsio::device::dial {
namespace {

using protocol::DialUse;

// 1 of so many shares of a pitch, on either side of a notch, belongs to the notch.
constexpr std::int64_t kNotchShare = 8;
// A host that listens takes a report in the next frame or two. One that takes it later has just
// begun, and Linux throws away what comes in the 50 ms after that.
constexpr std::uint32_t kPromptNs = 30'000'000;
constexpr std::uint32_t kDeafNs = 60'000'000;
// So long a host that has taken a report is sure to listen still.
constexpr std::uint32_t kListenNs = 100'000'000;
// Turns in a second from which on a detent counts for all the steps of a fast one.
constexpr std::int64_t kFastTurns = 2;
// State that the host may not know.
constexpr std::uint8_t kButtons = 1;
constexpr std::uint8_t kKeys = 2;
constexpr std::uint8_t kPuck = 4;
constexpr std::uint8_t kAll = kButtons | kKeys | kPuck;
constexpr std::uint8_t kFirst = 1;  // bit of a button

struct Uses {
  DialUse free;
  DialUse pressed;
};

Uses uses_of(DialUse use) {
  if (use == DialUse::wheel_or_pan) return {DialUse::wheel, DialUse::pan};
  if (use == DialUse::wheel_or_volume) return {DialUse::wheel, DialUse::volume};
  if (use == DialUse::volume_or_wheel) return {DialUse::volume, DialUse::wheel};
  return {use, use};
}

/// The nearest multiple of a detent; of two the larger.
[[gnu::noinline]] std::int64_t whole_detents(std::int64_t units) {
  const std::int64_t shifted = units + kUnits / 2;
  const std::int64_t part = shifted % kUnits;
  return shifted - (part < 0 ? part + kUnits : part);
}

std::int64_t clamp(std::int64_t value, std::int64_t limit) {
  return value > limit ? limit : value < -limit ? -limit : value;
}

/// An angle in tenths of a degree, cut off downward.
std::int64_t tenths(std::int64_t units, std::int64_t detents) {
  const std::int64_t turn = detents * kUnits;
  const std::int64_t rest = units % turn;
  const std::int64_t part = rest < 0 ? rest + turn : rest;
  return (units - part) / turn * kTurnTenths + part * kTurnTenths / turn;
}

void put(std::span<std::uint8_t> report, std::size_t at, std::int64_t value) {
  report[at] = static_cast<std::uint8_t>(value);
  report[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

bool scrolls(DialUse use) { return use == DialUse::wheel || use == DialUse::pan; }

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

Dial::Dial(const Config& config, std::uint32_t period_ns)
    : period_ns_(period_ns),
      notches_(make_detent_params(config, period_ns)),
      haptics_(period_ns),
      turn_watch_(period_ns) {
  prompt_ticks_ = kPromptNs / period_ns;
  listen_ticks_ = kListenNs / period_ns;
  deaf_ticks_ = kDeafNs / period_ns;
  second_ticks_ = 1'000'000'000 / period_ns;
  configure(config);
}

void Dial::configure(const Config& config) {
  const Uses uses = uses_of(config.game.dial_use);
  free_use_ = uses.free;
  pressed_use_ = uses.pressed;
  clicked_ = false;
  haptics_.stop();
  counts_per_rev_ = config.actuator.counts_per_rev;
  detents_ = config.game.dial_detents;
  felt_ = config.game.dial_torque_nm > 0.0F;
  reversed_ = config.game.reversed == protocol::Toggle::on;
  coarse_ = config.game.dial_coarse == protocol::Toggle::on;
  fast_steps_ = config.game.dial_fast_steps;
  notches_.prepare(make_detent_params(config, period_ns_));
  skip();
}

/// The first button is not the mouse's.
bool Dial::takes_button() const {
  return free_use_ == DialUse::radial || pressed_use_ != free_use_;
}

std::uint8_t Dial::mouse_buttons() const {
  const std::uint8_t taken = takes_button() ? kFirst : 0;
  return static_cast<std::uint8_t>((buttons_ & ~taken) | (clicked_ ? kFirst : 0));
}

std::uint8_t Dial::puck_button() const {
  return free_use_ == DialUse::radial ? buttons_ & kFirst : 0;
}

DialUse Dial::next_use() const { return (buttons_ & kFirst) != 0 ? pressed_use_ : free_use_; }

void Dial::set_buttons(std::uint8_t pressed) {
  const bool was_down = (buttons_ & kFirst) != 0;
  const bool is_down = (pressed & kFirst) != 0;
  if (is_down && !was_down) turned_ = false;
  if (was_down && !is_down) clicked_ = pressed_use_ != free_use_ && !turned_;
  buttons_ = pressed;
}

std::int64_t Dial::here() const {
  const std::int64_t place = units(now_.position_counts, counts_per_rev_, detents_);
  return reversed_ ? -place : place;
}

/// The host never hears of the whole detents up to here.
void Dial::skip() {
  const std::int64_t place = here();
  // Nobody counts a radial controller's detents, so it has no sum to fill.
  told_units_ = use_ == DialUse::radial ? place : told_units_ + whole_detents(place - told_units_);
  debt_ = told_units_ == place ? Debt::none : place % kUnits == 0 ? Debt::fresh : Debt::due;
}

void Dial::settle(bool /*connected*/) {
  skip();
  given_tick_ = now_.tick;  // a report that slept with the bus is not late
  state_due_ = kAll;
  listener_ = Listener::unknown;
}

void Dial::begin_anew() {
  fine_ = 0;
  told_units_ = whole_detents(told_units_);
  haptics_.begin_anew();
  settle(false);
}

Wish Dial::service(const Moment& now) {
  const bool moved_origin = now.zeroings != now_.zeroings;
  now_ = now;
  // A program's use of the knob is not the desktop's.
  if (moved_origin || now.owner == protocol::Owner::sdk) skip();
  if (now.owner == protocol::Owner::sdk || !felt_) haptics_.stop();
  const bool plays = haptics_.service(now.tick);
  if (plays) turn_watch_.touch(now.tick);
  notches_.feel(haptics_.feel(free_use_ == DialUse::radial));
  const Wish wish = turn_watch_.see(now, moved_origin, felt_);
  return plays ? Wish::take : wish;
}

std::size_t Dial::get_feature(std::uint8_t id, std::span<std::uint8_t> report) {
  if (id != kResolutionReport) return haptics_.get_feature(id, report);
  if (report.size() < kShortReportSize) return 0;
  report[0] = kResolutionReport;
  report[1] = fine_;
  return kShortReportSize;
}

bool Dial::set_feature(std::span<const std::uint8_t> report) {
  if (report.size() != kShortReportSize || report[0] != kResolutionReport) {
    return haptics_.set_feature(report);
  }
  if ((report[1] & ~(kWheelFine | kPanFine)) != 0) return false;
  if ((fine_ & ~report[1]) != 0) told_units_ = whole_detents(told_units_);
  fine_ = report[1];
  return true;
}

std::size_t Dial::get_input(std::uint8_t id, std::span<std::uint8_t> report) {
  if (report.size() < kMouseReportSize) return 0;
  if (id == kVolumeReport) {
    report[0] = kVolumeReport;
    report[1] = keys_told_;
    return kShortReportSize;
  }
  if (id != kMouseReport && id != kRadialReport) return 0;
  const bool radial = id == kRadialReport;
  std::fill_n(report.begin(), kMouseReportSize, std::uint8_t{0});
  report[0] = id;
  report[1] = radial ? puck_button() : mouse_buttons();
  return radial ? kRadialReportSize : kMouseReportSize;
}

std::size_t Dial::next_input(std::span<std::uint8_t> report) {
  if (report.size() < kMouseReportSize) return 0;
  if (listener_ == Listener::late && now_.tick - over_tick_ < deaf_ticks_) return 0;
  if (repeat_ != 0 && now_.tick - changed_tick_ >= deaf_ticks_ + prompt_ticks_) {
    state_due_ |= repeat_;
    repeat_ = 0;
  }
  change_use();
  const std::size_t size = state_due_ != 0 ? tell_state(report) : tell_news(report);
  if (size != 0) given_tick_ = now_.tick;
  return size;
}

/// A use whose host sums up units ends where the sum is full.
void Dial::change_use() {
  if (use_ == next_use() || (use_ != DialUse::radial && told_units_ % kUnits != 0)) return;
  told_units_ = whole_detents(told_units_);
  use_ = next_use();
  skip();
}

std::size_t Dial::tell_news(std::span<std::uint8_t> report) {
  std::size_t size = 0;
  if (use_ == DialUse::volume || keys_told_ != 0) size = next_volume(report);
  if (size == 0 && (use_ == DialUse::radial || puck_told_ != 0)) size = next_radial(report);
  return size != 0 ? size : next_mouse(report);
}

void Dial::input_over(bool taken) {
  const bool late = !taken || now_.tick - given_tick_ > prompt_ticks_;
  // A host that did hear them, but after more than kPromptNs, counts them twice.
  if (late) told_units_ -= given_units_;
  given_units_ = 0;
  if (late) state_due_ = kAll;
  listener_ = late ? Listener::late : Listener::prompt;
  over_tick_ = now_.tick;
}

/// Turns are for a host that is sure to hear them: its sum would be wrong for good.
bool Dial::listens() const {
  return listener_ == Listener::prompt && now_.tick - over_tick_ <= listen_ticks_;
}

/// What is pressed, without any turn.
std::size_t Dial::tell_state(std::span<std::uint8_t> report) {
  if ((state_due_ & kKeys) != 0) {
    state_due_ &= static_cast<std::uint8_t>(~kKeys);
    keys_told_ = 0;
    return get_input(kVolumeReport, report);
  }
  return tell_buttons(report, (state_due_ & kPuck) != 0 ? kRadialReport : kMouseReport);
}

void Dial::repeat(std::uint8_t state) {
  repeat_ |= state;
  changed_tick_ = now_.tick;
}

std::size_t Dial::tell_buttons(std::span<std::uint8_t> report, std::uint8_t id) {
  const std::size_t size = get_input(id, report);
  if (id == kRadialReport) {
    state_due_ &= static_cast<std::uint8_t>(~kPuck);
    if (report[1] != puck_told_) repeat(kPuck);
    puck_told_ = report[1];
    return size;
  }
  state_due_ &= static_cast<std::uint8_t>(~kButtons);
  if (report[1] != buttons_told_) repeat(kButtons);
  buttons_told_ = report[1];
  clicked_ = false;
  return size;
}

/// Whole steps; the rest goes out with the next ones.
std::int64_t Dial::next_units(bool fine) {
  // Each use has a sum of its own in the host, which is to stay full.
  if (use_ != next_use()) return whole_detents(told_units_) - told_units_;
  const std::int64_t place = here();
  const std::int64_t away = place - told_units_;
  if (!fine || coarse_) return away / kUnits * kUnits;
  // The part is paid in the next notch, but not before the knob is turned.
  const bool in_notch = place % kUnits == 0;
  if (debt_ == Debt::fresh && (!in_notch || whole_detents(away) != 0)) debt_ = Debt::due;
  if (debt_ == Debt::due && in_notch) debt_ = Debt::none;
  return debt_ == Debt::none ? away : 0;
}

/// Extra steps for fast notches. Whole detents, so the host's sum stays full in the notches.
std::int64_t Dial::speed_bonus(std::int64_t passed_units) {
  if (fast_steps_ == 1 || passed_units == 0) return 0;
  const auto elapsed = static_cast<std::int64_t>(now_.tick - passed_tick_);
  passed_tick_ = now_.tick;
  const std::int64_t passed = (passed_units < 0 ? -passed_units : passed_units) / kUnits;
  const std::int64_t turns = kFastTurns * std::int64_t{detents_} * (elapsed == 0 ? 1 : elapsed);
  const std::int64_t steps = std::min(fast_steps_ * passed * second_ticks_ / turns, fast_steps_);
  return steps <= 1 ? 0 : (steps - 1) * passed_units;
}

std::size_t Dial::next_mouse(std::span<std::uint8_t> report) {
  const bool fine = (fine_ & (use_ == DialUse::pan ? kPanFine : kWheelFine)) != 0;
  const std::int64_t unit = fine ? 1 : kUnits;
  std::int64_t steps = scrolls(use_) ? clamp(next_units(fine) / unit, kMost) : 0;
  if (steps == 0 && mouse_buttons() == buttons_told_) return 0;
  const std::size_t size = tell_buttons(report, kMouseReport);
  if (!listens()) return size;
  given_units_ = static_cast<std::int32_t>(steps * unit);
  if (steps != 0 && use_ == next_use()) turned_ = true;
  const std::int64_t notch = whole_detents(told_units_);
  told_units_ += given_units_;
  const std::int64_t bonus = speed_bonus(whole_detents(told_units_) - notch) / unit;
  if (clamp(steps + bonus, kMost) == steps + bonus) steps += bonus;
  // A wheel's positive way is away from the user, which scrolls up.
  put(report, 4, use_ == DialUse::pan ? 0 : -steps);
  put(report, 6, use_ == DialUse::pan ? steps : 0);
  return size;
}

/// A key goes down for each detent, and up again.
std::size_t Dial::next_volume(std::span<std::uint8_t> report) {
  std::uint8_t keys = 0;
  if (keys_told_ == 0) {
    const std::int64_t detents = (here() - told_units_) / kUnits;
    if (detents == 0) return 0;
    if (!listens()) return tell_state(report);
    keys = detents > 0 ? kLouder : kQuieter;
    given_units_ = detents > 0 ? kUnits : -kUnits;
    told_units_ += given_units_;
    turned_ = true;
  }
  keys_told_ = keys;
  return get_input(kVolumeReport, report);
}

/// The change of an angle in tenths of a degree, which the host sums up without an error.
std::size_t Dial::next_radial(std::span<std::uint8_t> report) {
  const std::int64_t turn_units = std::int64_t{kUnits} * detents_;
  const std::int64_t place = coarse_ ? whole_detents(here()) : here();
  const std::int64_t away = use_ == DialUse::radial ? clamp(place - told_units_, turn_units) : 0;
  const std::int64_t steps = tenths(told_units_ + away, detents_) - tenths(told_units_, detents_);
  if (steps == 0 && puck_button() == puck_told_) return 0;
  const std::size_t size = tell_buttons(report, kRadialReport);
  if (!listens()) return size;
  given_units_ = static_cast<std::int32_t>(away);
  told_units_ += away;
  put(report, 2, steps);
  return size;
}

}  // namespace torsio::device::dial
