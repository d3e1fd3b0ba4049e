#include "device/game/forces.hpp"

#include <utility>

#include "core/math.hpp"
#include "device/game/effect_torque.hpp"

namespace torsio::device::game {
namespace {

constexpr std::size_t at(Metric metric) { return static_cast<std::size_t>(metric); }

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

void Forces::call() {
  awake_.store(1, std::memory_order_release);
  attention_.store(1, std::memory_order_release);
}

void Forces::want(bool wanted) {
  wanted_.store(wanted ? 1 : 0, std::memory_order_relaxed);
  call();
}

bool Forces::stay_awake(bool wanted) {
  const bool stays = wanted || active_ != 0 || residual_nm_ != 0.0F || !orders_.empty();
  awake_.store(stays ? 1 : 0, std::memory_order_relaxed);
  return stays;
}

bool Forces::take_orders(bool may_play, std::uint64_t tick) {
  bool started = false;
  // No more than the ring holds: the main loop cannot make a tick longer than that.
  for (std::uint32_t n = 0; n < 4; ++n) {
    const ForceOrder* order = orders_.front();
    if (order == nullptr) break;
    if (order->kind == ForceOrder::Kind::settings) {
      if (order->paused && !paused_) paused_at_ = tick;
      if (!order->paused && paused_) pauses_ += tick - paused_at_;
      paused_ = order->paused;
      gain_ = order->gain;
      changed_ = changed_ || active_ != 0;
      started = enable(order->enabled, may_play, time(tick)) || started;
    } else if (order->kind == ForceOrder::Kind::stop_all) {
      gently_ = active_ != 0;
      stop_all();
    } else if (order->kind == ForceOrder::Kind::set_all_aside) {
      set_all_aside();
      for (Playing& play : play_) play.muted = false;
    } else {
      started = execute(*order, may_play, time(tick)) || started;
    }
    orders_.pop();
  }
  return started;
}

/// Without actuators effects go on unheard.
bool Forces::enable(bool enabled, bool may_play, std::uint64_t now) {
  if (enabled == enabled_) return false;
  enabled_ = enabled;
  if (!enabled) {
    for (std::uint8_t i = 0; i < active_; ++i) play_[order_[i]].muted = true;
    release(params_.release_ticks);
    return false;
  }
  bool heard = false;
  for (std::uint8_t block = 0; block < kBlocks; ++block) {
    if (!std::exchange(play_[block].muted, false) || !may_play) continue;
    heard = go_on(block, now) || heard;
  }
  return heard;
}

bool Forces::execute(const ForceOrder& order, bool may_play, std::uint64_t now) {
  const bool plays = play_[order.block].loops_left != 0;
  const bool restarts = order.play == ForceOrder::Play::start && goes_on(order);
  const bool updates = order.play == ForceOrder::Play::go_on && plays;
  const bool joined = (updates || restarts) && join(order, now);
  const std::uint32_t wave_phase = plays ? wave_so_far(order.block, now) : 0;
  Playing& play = play_[order.block];
  if (order.play == ForceOrder::Play::start) {
    play.wave_phase = wave_phase;
  } else if (play.sounding) {  // another period goes on from where the wave is
    play.wave_phase +=
        (effect_[order.block].timed.phase_per_tick - order.effect.timed.phase_per_tick) *
        static_cast<std::uint32_t>(now - play.start);
  }
  effect_[order.block] = order.effect;
  switch (order.play) {
    case ForceOrder::Play::as_it_is:
      changed_ = changed_ || plays;
      break;
    case ForceOrder::Play::go_on:
      changed_ = changed_ || (plays && !joined);
      return may_play && enabled_ && go_on(order.block, now);
    case ForceOrder::Play::start:
      if (!enabled_ || !(may_play || plays)) {
        start_unheard(order, now);
        return false;
      }
      start(order, now, restarts, joined);
      return true;
    case ForceOrder::Play::stop:
      stop(order.block);
      set_loops_aside(order.block, 0);
      break;
    case ForceOrder::Play::set_aside:
      set_aside(order.block);
      break;
  }
  return false;
}

/// A start changes only the time: games send one with each update.
bool Forces::goes_on(const ForceOrder& order) const {
  const Playing& play = play_[order.block];
  const PreparedEffect& effect = order.effect;
  return play.loops_left != 0 && play.sounding && is_steady(effect) && effect.delay_ticks == 0 &&
         effect.timed.attack_ticks == 0;
}

/// Games that start a wave with every frame want to feel it, and not its beginning again and again.
std::uint32_t Forces::wave_so_far(std::uint8_t block, std::uint64_t now) const {
  const Playing& play = play_[block];
  const std::uint64_t since = now - play.start;
  if (!play.sounding || since > params_.frame_max_ticks) return 0;
  return play.wave_phase + effect_[block].timed.phase_per_tick * static_cast<std::uint32_t>(since);
}

/// Joins an update to the one before it by a line that is a frame long, so half a frame late.
/// @returns false if it stands for itself: the first for long, a hit, or another kind of effect
bool Forces::join(const ForceOrder& order, std::uint64_t now) {
  Playing& play = play_[order.block];
  const PreparedEffect& old = effect_[order.block];
  const bool first = play.heard == 0 || now - play.heard > params_.frame_max_ticks;
  play.heard = now;
  if (first || !play.sounding || !is_steady(old) || !is_steady(order.effect)) {
    play.updated = now;
    play.frame_ticks = 0;
    play.change_nm = 0.0F;
    play.change_before_nm = 0.0F;
    play.late_nm = 0.0F;
    return false;
  }
  const auto value_nm = [](const PreparedEffect& effect, std::uint64_t elapsed) {
    return effect.gain * timed_nm(effect.timed, elapsed, effect.duration_ticks);
  };
  const std::uint64_t elapsed = now - play.start;
  const std::uint64_t elapsed_then = order.play == ForceOrder::Play::start ? 0 : elapsed;
  const float change_nm = value_nm(order.effect, elapsed_then) - value_nm(old, elapsed);
  if (change_nm == 0.0F) return true;
  const std::uint64_t gap = now - play.updated;
  if (2 * gap >= play.frame_ticks) {  // else another report of the same update
    const bool held = gap > params_.frame_max_ticks;
    play.updated = now;
    play.change_before_nm = held ? 0.0F : play.change_nm;
    play.change_nm = 0.0F;
    const auto frame = static_cast<std::uint32_t>(gap);
    if (!held) {
      play.frame_ticks = play.frame_ticks == 0 ? frame : (3 * play.frame_ticks + frame) / 4;
    }
  }
  play.change_nm += change_nm;
  float usual_nm = params_.hit_nm;
  if (play.change_nm * play.change_before_nm > 0.0F) {
    usual_nm += core::absolute(play.change_before_nm);
  }
  if (core::absolute(play.change_nm) > usual_nm || play.frame_ticks == 0) {
    play.late_nm = 0.0F;
    return false;
  }
  play.late_nm -= change_nm;
  play.late_step_nm = core::absolute(play.late_nm) / static_cast<float>(play.frame_ticks);
  return true;
}

/// @param restarts it goes on as it was, but its time begins anew
void Forces::start(const ForceOrder& order, std::uint64_t now, bool restarts, bool joined) {
  Playing& play = play_[order.block];
  const std::uint8_t loops = loops_of(order);
  if (restarts) {
    play.start = now;
    play.loops_left = loops;
    changed_ = changed_ || !joined;
    return;
  }
  std::uint32_t soft_left = play.soft_left;  // who starts it again and again wants to feel it
  if (play.loops_left == 0) {
    order_[active_++] = order.block;
    mark(playing_, order.block, true);
    soft_left = params_.soft_ticks;
  }
  set_loops_aside(order.block, 0);
  const std::uint32_t wave_phase = play.wave_phase;
  play = {};
  play.wave_phase = wave_phase;
  play.soft_left = soft_left;
  play.start = now;
  play.loops_left = loops;
  changed_ = true;
  gently_ = false;
  raise_walls();
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
  play.late_nm = 0.0F;
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

void Forces::release(std::uint32_t ticks) {
  set_all_aside();
  changed_ = false;
  walls_ = false;
  residual_nm_ = last_nm_;
  residual_step_nm_ =
      ticks == 0 ? core::absolute(last_nm_) : core::absolute(last_nm_) / static_cast<float>(ticks);
}

void Forces::drop() {
  walls_ = false;
  wanted_.store(0, std::memory_order_relaxed);
  if (active_ == 0 && last_nm_ == 0.0F && residual_nm_ == 0.0F) return;
  set_all_aside();
  changed_ = false;
  last_nm_ = 0.0F;
  residual_nm_ = 0.0F;
  shown_nm_.store(0.0F, std::memory_order_relaxed);
}

/// Several springs are as stiff as their sum, so they share the stable stiffness.
void Forces::share_out() {
  std::array<float, kMetrics> sum{};
  const OwnFeel& own = params_.own;
  if (active_ == 0) sum[at(Metric::angle)] = own.stiffness;
  sum[at(Metric::speed)] = own.damping;
  sum[at(Metric::acceleration)] = own.inertia;
  sum[at(Metric::slip)] = own.bristle;
  float slip_limit_nm = own.friction_nm;
  for (std::uint8_t i = 0; i < active_; ++i) {
    const PreparedEffect& effect = effect_[order_[i]];
    const Condition& condition = effect.condition;
    const float gain = effect.gain * gain_;
    sum[at(effect.metric)] += gain * core::larger(core::absolute(condition.positive_gain),
                                                  core::absolute(condition.negative_gain));
    if (effect.metric == Metric::slip) {
      slip_limit_nm +=
          gain * core::larger(condition.positive_limit_nm, condition.negative_limit_nm);
    }
  }
  const auto share = [](float wanted, float most) { return wanted > most ? most / wanted : 1.0F; };
  share_[at(Metric::angle)] = share(sum[at(Metric::angle)], params_.most.stiffness);
  share_[at(Metric::speed)] = share(sum[at(Metric::speed)], params_.most.damping);
  share_[at(Metric::acceleration)] = share(sum[at(Metric::acceleration)], params_.most.inertia);
  share_[at(Metric::slip)] =
      share(sum[at(Metric::slip)] * slip_limit_nm * slip_limit_nm, params_.most.bristle);
}

/// The walls at the ends of the axis, and the player's own feel. They act in every game.
/// Its gains and pauses do not scale them.
float Forces::own_nm(const core::Motion& motion, float period_s) {
  const float inside = core::clamp_symmetric(motion_angle_, params_.end_rad);
  float nm = core::clamp_symmetric(params_.end_stiffness * (inside - motion_angle_),
                                   params_.torque_max_nm);
  const OwnFeel& own = params_.own;
  const auto against = [&](float gain, Metric metric, float value) {
    if (gain != 0.0F) nm -= gain * share_[at(metric)] * value;
  };
  if (active_ == 0) against(own.stiffness, Metric::angle, motion_angle_);
  against(own.damping, Metric::speed, motion.speed_rad_s);
  against(own.inertia, Metric::acceleration, motion.acceleration_rad_s2);
  if (own.friction_nm != 0.0F) {
    const Condition friction{.positive_gain = own.bristle,
                             .positive_limit_nm = own.friction_nm,
                             .negative_limit_nm = own.friction_nm};
    nm += slip_nm(friction, motion, period_s, share_[at(Metric::slip)], own_slip_rad_);
  }
  if (walls_soft_left_ != 0) {
    nm *= static_cast<float>(params_.soft_ticks - walls_soft_left_) /
          static_cast<float>(params_.soft_ticks);
    --walls_soft_left_;
  }
  return nm;
}

float Forces::evaluate(std::uint8_t block, const core::Motion& motion, float period_s,
                       std::uint64_t now, bool& ended) {
  const PreparedEffect& effect = effect_[block];
  Playing& play = play_[block];
  if (!play.sounding) {
    if (now - play.start < effect.delay_ticks) return 0.0F;
    play.start += effect.delay_ticks;
    play.sounding = true;
    changed_ = true;
  }
  std::uint64_t elapsed = now - play.start;
  if (effect.duration_ticks != 0 && elapsed >= effect.duration_ticks) {
    const std::uint64_t loops =
        elapsed < std::uint64_t{2} * effect.duration_ticks ? 1 : elapsed / effect.duration_ticks;
    if (play.loops_left != kEndlessLoops) {
      if (loops >= play.loops_left) {
        ended = true;
        return 0.0F;
      }
      play.loops_left = static_cast<std::uint8_t>(play.loops_left - loops);
    }
    play.start += loops * effect.duration_ticks;
    elapsed = now - play.start;
  }
  const float share = share_[at(effect.metric)];
  switch (effect.metric) {
    case Metric::time:
      if (play.late_nm != 0.0F) {
        play.late_nm -= core::clamp_symmetric(play.late_nm, play.late_step_nm);
      }
      return effect.gain * timed_nm(effect.timed, elapsed, effect.duration_ticks, play.wave_phase) +
             play.late_nm;
    case Metric::angle: {
      // The hand may be anywhere when a game begins to centre.
      float gain = effect.gain;
      if (play.soft_left != 0) {
        gain *= static_cast<float>(params_.soft_ticks - play.soft_left) /
                static_cast<float>(params_.soft_ticks);
        --play.soft_left;
      }
      return gain * proportional_nm(effect.condition, motion_angle_, share);
    }
    case Metric::speed:
      return effect.gain * proportional_nm(effect.condition, motion.speed_rad_s, share);
    case Metric::acceleration:
      return effect.gain * proportional_nm(effect.condition, motion.acceleration_rad_s2, share);
    case Metric::slip:
      // A softer bristle bends further and holds as much.
      return effect.gain * slip_nm(effect.condition, motion, period_s, share, play.slip_rad);
  }
  return 0.0F;
}

/// A game may ask for more than there is. The monitor reports it.
float Forces::within_cap_nm(float asked_nm) {
  const float nm = core::clamp_symmetric(asked_nm, params_.torque_max_nm);
  const float size_nm = core::absolute(asked_nm);
  if (size_nm > asked_most_nm_.load(std::memory_order_relaxed)) {
    asked_most_nm_.store(size_nm, std::memory_order_relaxed);
  }
  if (nm != asked_nm) {
    clipped_ticks_.store(clipped_ticks() + 1, std::memory_order_relaxed);
  }
  return nm;
}

float Forces::torque_nm(const core::Motion& motion, const core::Resolution& resolution,
                        std::uint64_t tick) {
  float sum_nm = 0.0F;
  if (changed_) share_out();
  motion_angle_ = core::offset_rad(motion.position_counts, {}, resolution.rad_per_count);
  if (!paused_) {
    const std::uint64_t now = time(tick);
    for (std::uint8_t i = 0; i < active_;) {
      bool ended = false;
      const std::uint8_t block = order_[i];
      const float nm = evaluate(block, motion, resolution.period_s, now, ended);
      block_nm_[block].store(nm * gain_, std::memory_order_relaxed);
      sum_nm += nm;
      if (ended) {
        stop(block);  // the next one has moved into its place
      } else {
        ++i;
      }
    }
  } else {
    for (std::uint8_t i = 0; i < active_; ++i) {
      block_nm_[order_[i]].store(0.0F, std::memory_order_relaxed);
    }
  }
  sum_nm = within_cap_nm(sum_nm * gain_);
  if (walls_ && (params_.end_stiffness != 0.0F || params_.own.is_felt)) {
    sum_nm =
        core::clamp_symmetric(sum_nm + own_nm(motion, resolution.period_s), params_.torque_max_nm);
  }
  if (changed_) {
    changed_ = false;
    residual_nm_ = last_nm_ - sum_nm;
    const std::uint32_t ticks = gently_ ? params_.release_ticks : params_.blend_ticks;
    gently_ = false;
    residual_step_nm_ = core::absolute(residual_nm_) / static_cast<float>(ticks);
  }
  if (residual_nm_ != 0.0F) {
    residual_nm_ -= core::clamp_symmetric(residual_nm_, residual_step_nm_);
    // The rounding of the last step is not worth a tick.
    if (core::absolute(residual_nm_) < 1e-3F * residual_step_nm_) residual_nm_ = 0.0F;
  }
  last_nm_ = sum_nm + residual_nm_;
  shown_nm_.store(last_nm_, std::memory_order_relaxed);
  return last_nm_;
}

}  // namespace torsio::device::game
