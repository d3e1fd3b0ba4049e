#include "game/lock.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace game {
namespace {

constexpr float kSpeedSmoothing_s = 0.05F;
constexpr float kOpenTurn = 0.97F;  // a little before the end stop, which a hand cannot pass

/// The next number of a linear congruential generator (ANSI C's constants): small, and the same
/// everywhere, which std::uniform_int_distribution is not.
std::uint32_t next_random(std::uint32_t& state) {
  state = state * 1103515245U + 12345U;
  return (state >> 16U) & 0x7FFFU;
}

}  // namespace

Lock make_lock(std::uint32_t seed) {
  Lock lock{};
  for (int i = 0; i < kPins; ++i) {
    lock.pins[i] = {0.35F + 0.05F * static_cast<float>(next_random(seed) % 9U), i};
  }
  for (int i = kPins - 1; i > 0; --i) {
    const int j = static_cast<int>(next_random(seed) % static_cast<std::uint32_t>(i + 1));
    std::swap(lock.pins[i].order, lock.pins[j].order);
  }
  return lock;
}

bool is_binding(const Lock& lock) {
  return !is_free(lock) && lock.pins[lock.selected].order == lock.set_count &&
         lock.lift >= kLowered;
}

Event step(Lock& lock, const Input& input, float dt_s) {
  const float before = lock.lift;
  lock.lift = std::clamp(input.lift, -0.25F, 1.25F);
  const float blend = std::min(1.0F, dt_s / kSpeedSmoothing_s);
  lock.speed_per_s += blend * ((lock.lift - before) / dt_s - lock.speed_per_s);
  if (is_open(lock)) return Event::none;
  lock.time_s += dt_s;

  if (is_free(lock)) {
    lock.turn = std::max(lock.turn, (lock.lift - lock.turn_from) / (1 - lock.turn_from));
    if (lock.turn < kOpenTurn) return Event::none;
    lock.turn = 1;
    return Event::opened;
  }
  if (input.move != 0 && lock.lift < kLowered) {
    lock.selected = (lock.selected + input.move + kPins) % kPins;
    return Event::moved;
  }

  const Pin& pin = lock.pins[lock.selected];
  if (is_set(lock, lock.selected)) {
    lock.forced_s = lock.lift > pin.shear_lift + kGive ? lock.forced_s + dt_s : 0;
    if (lock.forced_s < kPatience_s) return Event::none;
    // What was set after it hung on it.
    lock.dropped += lock.set_count - pin.order;
    lock.set_count = pin.order;
    lock.forced_s = 0;
    return Event::dropped;
  }
  const bool passed = before < pin.shear_lift && lock.lift >= pin.shear_lift;
  if (pin.order != lock.set_count || !passed) return Event::none;
  ++lock.set_count;
  if (!is_free(lock)) return Event::set;
  lock.turn_from = std::min(lock.lift, 0.9F);
  return Event::freed;
}

Forces forces(const Lock& lock) {
  Forces felt{.low = lock.lift < kLowered};
  if (is_open(lock)) return felt;
  if (is_free(lock)) {
    felt.friction = 0.25F;
    felt.damping = 0.4F;
    // In four steps, so that it changes seldom.
    const float speed = std::min(1.0F, std::abs(lock.speed_per_s));
    felt.grind = 0.2F * std::round(4 * speed) / 4;
    return felt;
  }
  if (is_set(lock, lock.selected)) {
    // Its lower half hangs loose, up to the upper half that rests on the shear line.
    felt.ceiling_lift = lock.pins[lock.selected].shear_lift;
    return felt;
  }
  felt.spring = 0.2F;
  if (is_binding(lock)) {
    felt.friction = 0.35F;
    felt.damping = 0.3F;
  }
  return felt;
}

Input Autopilot::next(const Forces& felt, float dt_s) {
  constexpr float kSpeed = 0.7F;  // lifts a second
  constexpr float kProbe = 0.25F;
  if (up_) {
    lift_ += kSpeed * dt_s;
    // Nothing but a spring that gives way: not this pin.
    const bool loose = lift_ > kProbe && felt.friction == 0;
    if (loose || lift_ >= felt.ceiling_lift + 0.02F) up_ = false;
    return {lift_, 0};
  }
  lift_ = std::max(0.0F, lift_ - 2 * kSpeed * dt_s);
  if (lift_ > 0) return {lift_, 0};
  up_ = true;
  return {0, 1};
}

}  // namespace game
