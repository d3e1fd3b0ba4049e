#include "device/game/forces.hpp"

#include <utility>

#include "core/math.hpp"
#include "device/game/effect_torque.hpp"

namespace torsio::device::game {
namespace {

std::uint8_t loops_of(const ForceOrder& order) { return order.loops == 0 ? 1 : order.loops; }

/// A force that stays as it is between two updates.
bool is_steady(const PreparedEffect& effect) {
  return effect.metric == Metric::time && effect.timed.slope_per_tick == 0.0F &&
         !(effect.timed.periodic && effect.timed.peak_nm != 0.0F);
}

}  // namespace

bool Forces::give(const ForceOrder& order) {
  if (!orders_.push(order)) return false;
  call();
  return true;
}

bool Forces::stay_awake(bool has_actuator) {
  const bool felt = has_actuator || active_ != 0 || fading() || !orders_.empty();
  awake_.store(felt ? 1 : 0, std::memory_order_relaxed);
  return felt;
}

bool Forces::take_news(bool may_play, std::uint64_t tick) {
  may_play = may_play && params_.allowed;
  bool started = false;
  // No more than the ring holds: the main loop cannot make a tick longer than that.
  for (std::uint32_t n = 0; n < 4; ++n) {
    const ForceOrder* order = orders_.front();
    if (order == nullptr) break;
    started = take(*order, may_play, tick) || started;
    orders_.pop();
  }
  const bool own = wanted() && may_play;
  if (own) raise_walls();
  return started || own;
}

bool Forces::play_on() {
  if (active_ != 0 || wanted()) {
    idle_ticks_ = 0;
    return true;
  }
  if (fading() || (enabled_ && ++idle_ticks_ < params_.idle_ticks)) return true;
  // A wall at an end may hold the knob still.
  release();
  return fading();
}

/// @returns true if an effect was started or brought back, as all that takes orders
bool Forces::take(const ForceOrder& order, bool may_play, std::uint64_t tick) {
  switch (order.kind) {
    case ForceOrder::Kind::effect:
      return take_effect(order, may_play, time(tick));
    case ForceOrder::Kind::settings:
      return take_settings(order, may_play, tick);
    case ForceOrder::Kind::stop_all:
      gently_ = active_ != 0;
      stop_all();
      return false;
    case ForceOrder::Kind::set_all_aside:
      set_all_aside();
      for (Playing& play : play_) play.muted = false;
      return false;
  }
  return false;
}

bool Forces::take_settings(const ForceOrder& order, bool may_play, std::uint64_t tick) {
  if (order.paused && !paused_) paused_at_ = tick;
  if (!order.paused && paused_) pauses_ += tick - paused_at_;
  paused_ = order.paused;
  gain_ = order.gain;
  changed_ = changed_ || active_ != 0;
  return enable(order.enabled, may_play, time(tick));
}

/// Without actuators effects go on unheard.
bool Forces::enable(bool enabled, bool may_play, std::uint64_t now) {
  if (enabled == enabled_) return false;
  enabled_ = enabled;
  if (!enabled) {
    for (std::uint8_t i = 0; i < active_; ++i) play_[order_[i]].muted = true;
    release();
    return false;
  }
  bool heard = false;
  for (std::uint8_t block = 0; block < kBlocks; ++block) {
    if (!std::exchange(play_[block].muted, false) || !may_play) continue;
    heard = go_on(block, now) || heard;
  }
  return heard;
}

bool Forces::take_effect(const ForceOrder& order, bool may_play, std::uint64_t now) {
  const bool plays = play_[order.block].loops_left != 0;
  const bool continues = plays_on(order);
  const bool joined = continues && join(order, now);
  carry_wave_on(order, now);
  effect_[order.block] = order.effect;
  switch (order.play) {
    case ForceOrder::Play::as_it_is:
      changed_ = changed_ || plays;
      return false;
    case ForceOrder::Play::go_on:
      changed_ = changed_ || (plays && !joined);
      return may_play && enabled_ && go_on(order.block, now);
    case ForceOrder::Play::start:
      return start(order, may_play, now, continues, joined);
    case ForceOrder::Play::stop:
      stop(order.block);
      set_loops_aside(order.block, 0);
      return false;
    case ForceOrder::Play::set_aside:
      set_aside(order.block);
      return false;
  }
  return false;
}

/// What plays goes on with other numbers. A start changes only the time: games send one with each
/// update.
bool Forces::plays_on(const ForceOrder& order) const {
  const Playing& play = play_[order.block];
  if (play.loops_left == 0) return false;
  if (order.play != ForceOrder::Play::start) return order.play == ForceOrder::Play::go_on;
  const PreparedEffect& effect = order.effect;
  return play.sounding && is_steady(effect) && effect.delay_ticks == 0 &&
         effect.timed.attack_ticks == 0;
}

/// Games that start a wave with every frame want to feel it, and not its beginning again and again.
/// With another period it goes on from where it is.
void Forces::carry_wave_on(const ForceOrder& order, std::uint64_t now) {
  Playing& play = play_[order.block];
  const std::uint32_t per_tick = effect_[order.block].timed.phase_per_tick;
  const std::uint64_t since = now - play.start;
  const auto ticks = static_cast<std::uint32_t>(since);
  if (order.play != ForceOrder::Play::start) {
    if (play.sounding) play.wave_phase += (per_tick - order.effect.timed.phase_per_tick) * ticks;
    return;
  }
  const bool is_heard = play.loops_left != 0 && play.sounding && since <= params_.frame_max_ticks;
  play.wave_phase = is_heard ? play.wave_phase + per_tick * ticks : 0;
}

/// Joins an update to the one before it.
/// @returns false if it stands for itself: the first for long, a hit, or another kind of effect
bool Forces::join(const ForceOrder& order, std::uint64_t now) {
  Playing& play = play_[order.block];
  const PreparedEffect& old = effect_[order.block];
  const bool first = play.updates.hear(now, params_.frame_max_ticks);
  if (first || !play.sounding || !is_steady(old) || !is_steady(order.effect)) {
    play.updates.begin(now);
    return false;
  }
  const auto value_nm = [](const PreparedEffect& effect, std::uint64_t elapsed) {
    return effect.gain * timed_nm(effect.timed, elapsed, effect.duration_ticks);
  };
  const std::uint64_t elapsed = now - play.start;
  const std::uint64_t elapsed_then = order.play == ForceOrder::Play::start ? 0 : elapsed;
  const float change_nm = value_nm(order.effect, elapsed_then) - value_nm(old, elapsed);
  return change_nm == 0.0F ||
         play.updates.join(change_nm, now, params_.frame_max_ticks, params_.hit_nm);
}

/// @param restarts it goes on as it was, but its time begins anew
bool Forces::start(const ForceOrder& order, bool may_play, std::uint64_t now, bool restarts,
                   bool joined) {
  Playing& play = play_[order.block];
  const bool plays = play.loops_left != 0;
  if (!enabled_ || !(may_play || plays)) {
    start_unheard(order, now);
    return false;
  }
  if (restarts) {
    play.start = now;
    play.loops_left = loops_of(order);
    changed_ = changed_ || !joined;
    return true;
  }
  std::uint32_t soft_left = play.soft_left;  // who starts it again and again wants to feel it
  if (!plays) {
    order_[active_++] = order.block;
    mark(playing_, order.block, true);
    soft_left = params_.soft_ticks;
  }
  set_loops_aside(order.block, 0);
  play = {.start = now,
          .loops_left = loops_of(order),
          .soft_left = soft_left,
          .wave_phase = play.wave_phase};
  changed_ = true;
  gently_ = false;
  raise_walls();
  return true;
}

/// Nothing may play now, or is to be heard; games that have started an effect only update it.
void Forces::start_unheard(const ForceOrder& order, std::uint64_t now) {
  Playing& play = play_[order.block];
  play = {};
  play.start = now;
  play.muted = true;
  set_loops_aside(order.block, loops_of(order));
}

/// Brings back what the device has ended. Its time has gone on meanwhile.
bool Forces::go_on(std::uint8_t block, std::uint64_t now) {
  Playing& play = play_[block];
  if (play.loops_aside == 0) return false;
  const PreparedEffect& effect = effect_[block];
  const std::uint64_t delay = play.sounding ? 0 : effect.delay_ticks;
  const bool has_end = effect.duration_ticks != 0 && play.loops_aside != kEndlessLoops;
  const std::uint64_t length = delay + std::uint64_t{effect.duration_ticks} * play.loops_aside;
  const std::uint8_t loops = play.loops_aside;
  set_loops_aside(block, 0);
  if (has_end && now - play.start >= length) return false;
  play.loops_left = loops;
  play.slip_rad = 0.0F;
  play.updates.late.nm = 0.0F;
  play.soft_left = params_.soft_ticks;
  order_[active_++] = block;
  mark(playing_, block, true);
  changed_ = true;
  raise_walls();
  return true;
}

/// The hand may be far beyond an end when a game begins.
void Forces::raise_walls() {
  if (walls_) return;
  walls_soft_left_ = params_.soft_ticks;
  walls_ = true;
  own_slip_rad_ = 0.0F;
  changed_ = true;
}

void Forces::set_aside(std::uint8_t block) {
  const std::uint8_t loops = play_[block].loops_left;
  if (loops == 0) return;
  stop(block);
  set_loops_aside(block, loops);
}

void Forces::stop(std::uint8_t block) {
  if (play_[block].loops_left == 0) return;
  play_[block].loops_left = 0;
  mark(playing_, block, false);
  block_nm_[block].store(0.0F, std::memory_order_relaxed);
  std::uint8_t kept = 0;
  for (std::uint8_t i = 0; i < active_; ++i) {
    if (order_[i] != block) order_[kept++] = order_[i];
  }
  active_ = kept;
  changed_ = true;
  // The player's own spring comes back, and the hand may be anywhere.
  if (active_ == 0 && params_.own.stiffness != 0.0F) gently_ = true;
}

void Forces::mark(BlockBits& bits, std::uint8_t block, bool on) {
  std::atomic<std::uint32_t>& word = bits[block / 32];
  const std::uint32_t bit = std::uint32_t{1} << (block % 32);
  const std::uint32_t now = word.load(std::memory_order_relaxed);
  word.store(on ? now | bit : now & ~bit, std::memory_order_relaxed);
}

void Forces::set_loops_aside(std::uint8_t block, std::uint8_t loops) {
  play_[block].loops_aside = loops;
  mark(aside_, block, loops != 0);
}

void Forces::set_all_aside() {
  while (active_ != 0) set_aside(order_[active_ - 1]);
}

void Forces::forget() {
  for (std::uint8_t block = 0; block < kBlocks; ++block) set_loops_aside(block, 0);
}

void Forces::stop_all() {
  while (active_ != 0) stop(order_[active_ - 1]);
  forget();
}

void Forces::release() {
  set_all_aside();
  changed_ = false;
  walls_ = false;
  residual_.begin(last_nm_, params_.release_ticks);
}

void Forces::drop() {
  Guest::drop();
  walls_ = false;
  idle_ticks_ = 0;
  if (active_ == 0 && last_nm_ == 0.0F && !fading()) return;
  set_all_aside();
  changed_ = false;
  last_nm_ = 0.0F;
  residual_.nm = 0.0F;
  shown_nm_.store(0.0F, std::memory_order_relaxed);
}

}  // namespace torsio::device::game
