#include "game/haptics.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace game {
namespace {

constexpr float kFull = 32767;
// A change costs the driver up to three USB reports. One in 15 ms is as good as one a frame at
// 60 Hz, and keeps a display of 240 Hz from flooding slow devices. What comes sooner waits for
// the next frame, and the newest wins.
constexpr Uint32 kUpdate_ms = 15;
constexpr std::size_t kErrorsKept = 20;

Sint16 level(float share) { return static_cast<Sint16>(std::lround(kFull * share)); }

SDL_HapticEffect condition(Uint32 type, int centre, float below, float above, float limit) {
  SDL_HapticEffect effect;
  std::memset(&effect, 0, sizeof effect);  // bytes between members too: effects are compared
  effect.condition.type = static_cast<Uint16>(type);
  effect.condition.direction.type = SDL_HAPTIC_CARTESIAN;
  effect.condition.direction.dir[0] = 1;
  effect.condition.length = SDL_HAPTIC_INFINITY;
  effect.condition.center[0] = static_cast<Sint16>(centre);
  effect.condition.left_coeff[0] = level(below);
  effect.condition.right_coeff[0] = level(above);
  const auto saturation = static_cast<Uint16>(2 * level(limit));
  effect.condition.left_sat[0] = effect.condition.right_sat[0] = saturation;
  return effect;
}

SDL_HapticEffect wave(Uint32 type, float amplitude, Uint16 period_ms, Uint32 length_ms) {
  SDL_HapticEffect effect;
  std::memset(&effect, 0, sizeof effect);
  effect.periodic.type = static_cast<Uint16>(type);
  effect.periodic.direction.type = SDL_HAPTIC_CARTESIAN;
  effect.periodic.direction.dir[0] = 1;
  effect.periodic.length = length_ms;
  effect.periodic.period = period_ms;
  effect.periodic.magnitude = level(amplitude);
  return effect;
}

/// A push down: SDL's directions say where a force comes from, and this one comes from the right.
SDL_HapticEffect push_down(float share, Uint16 length_ms) {
  SDL_HapticEffect effect;
  std::memset(&effect, 0, sizeof effect);
  effect.constant.type = SDL_HAPTIC_CONSTANT;
  effect.constant.direction.type = SDL_HAPTIC_CARTESIAN;
  effect.constant.direction.dir[0] = 1;
  effect.constant.length = length_ms;
  effect.constant.level = level(share);
  effect.constant.fade_length = static_cast<Uint16>(length_ms / 2);
  return effect;
}

/// The lock's forces in the device's terms, in the order of the slots.
std::array<SDL_HapticEffect, Haptics::kSlots> render(const Forces& felt, const AxisScale& scale) {
  std::array<SDL_HapticEffect, Haptics::kSlots> effects = {
      condition(SDL_HAPTIC_SPRING, scale.axis(0), 0, felt.spring, felt.spring),
      condition(SDL_HAPTIC_FRICTION, 0, felt.friction, felt.friction, felt.friction),
      condition(SDL_HAPTIC_DAMPER, 0, felt.damping, felt.damping, 1),
      wave(SDL_HAPTIC_SINE, felt.grind, 25, SDL_HAPTIC_INFINITY),
      wave(SDL_HAPTIC_TRIANGLE, 0.9F, 20, 40),
      push_down(0.8F, 80),
  };
  // A wall's springs are as stiff as they come, on one side of their centre only. There is one
  // wall, the nearer one: a device that keeps all springs together stable can make one stiffer than
  // two. A dead band would make both walls of one spring, but devices differ in how wide theirs is.
  std::fill(effects.begin() + Haptics::wall, effects.end(),
            felt.low ? condition(SDL_HAPTIC_SPRING, scale.axis(felt.floor_lift), 1, 0, 1)
                     : condition(SDL_HAPTIC_SPRING, scale.axis(felt.ceiling_lift), 0, 1, 1));
  return effects;
}

constexpr std::array<const char*, Haptics::kWallSprings> kWallNames = {"wall", "wall 2", "wall 3",
                                                                       "wall 4", "wall 5"};

}  // namespace

float AxisScale::lift(int axis) const {
  return static_cast<float>(axis) / kFull * range_deg / 2 / lift_deg;
}

int AxisScale::axis(float lift) const {
  const float axis = lift * lift_deg / (range_deg / 2) * kFull;
  return static_cast<int>(std::lround(std::clamp(axis, -kFull, kFull)));
}

Haptics::Haptics(SDL_Joystick* joystick, AxisScale scale)
    : scale_(scale),
      effects_{{{"pin spring", SDL_HAPTIC_SPRING},
                {"friction", SDL_HAPTIC_FRICTION},
                {"damping", SDL_HAPTIC_DAMPER},
                {"grind", SDL_HAPTIC_SINE},
                {"click", SDL_HAPTIC_TRIANGLE},
                {"thump", SDL_HAPTIC_CONSTANT}}} {
  for (std::size_t n = 0; n < kWallSprings; ++n) {
    effects_[wall + n] = {.name = kWallNames[n], .type = SDL_HAPTIC_SPRING};
  }
  if (joystick == nullptr || SDL_JoystickIsHaptic(joystick) != 1) return;
  device_ = SDL_HapticOpenFromJoystick(joystick);
  if (device_ == nullptr) {
    check(-1, "open");
    return;
  }
  const unsigned has = SDL_HapticQuery(device_);
  if ((has & SDL_HAPTIC_GAIN) != 0) check(SDL_HapticSetGain(device_, 100), "gain");
  if ((has & SDL_HAPTIC_AUTOCENTER) != 0) check(SDL_HapticSetAutocenter(device_, 0), "autocenter");
  wanted_ = render({}, scale_);
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    Effect& effect = effects_[slot];
    if ((has & effect.type) == 0) continue;
    effect.now = wanted_[slot];
    effect.id = SDL_HapticNewEffect(device_, &effect.now);
    check(effect.id, effect.name);
  }
}

Haptics::~Haptics() {
  if (device_ == nullptr) return;
  stop();
  for (const Effect& effect : effects_) {
    if (effect.id >= 0) SDL_HapticDestroyEffect(device_, effect.id);
  }
  SDL_HapticClose(device_);
}

void Haptics::feel(const Forces& forces, Uint32 now_ms) {
  if (device_ == nullptr) return;
  wanted_ = render(forces, scale_);
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    if (slot == click || slot == thump) continue;
    update(slot, now_ms);
    if (!running_) run(slot, SDL_HAPTIC_INFINITY);
  }
  running_ = true;
}

void Haptics::knock(Event event) {
  if (device_ == nullptr) return;
  if (event == Event::set || event == Event::freed || event == Event::opened) run(click, 1);
  if (event == Event::dropped) run(thump, 1);
}

void Haptics::stop() {
  if (device_ != nullptr && running_) check(SDL_HapticStopAll(device_), "stop");
  running_ = false;
}

void Haptics::update(std::size_t slot, Uint32 now_ms) {
  Effect& effect = effects_[slot];
  if (effect.id < 0 || std::memcmp(&effect.now, &wanted_[slot], sizeof effect.now) == 0) return;
  if (effect.updates != 0 && now_ms - effect.changed_ms < kUpdate_ms) return;
  if (!check(SDL_HapticUpdateEffect(device_, effect.id, &wanted_[slot]), effect.name)) return;
  effect.now = wanted_[slot];
  effect.changed_ms = now_ms;
  ++effect.updates;
}

void Haptics::run(std::size_t slot, Uint32 times) {
  Effect& effect = effects_[slot];
  if (effect.id < 0) return;
  if (check(SDL_HapticRunEffect(device_, effect.id, times), effect.name)) ++effect.starts;
}

bool Haptics::check(int result, const char* what) {
  if (result >= 0) return true;
  if (errors_.size() < kErrorsKept) errors_.push_back(std::string(what) + ": " + SDL_GetError());
  return false;
}

}  // namespace game
