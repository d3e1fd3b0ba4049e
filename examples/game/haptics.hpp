/// @file
/// The lock's forces as SDL haptic effects. The device computes springs, friction and damping from
/// its own angle, thousands of times a second; the game only says which, and only when they change.
#pragma once

#include <SDL.h>

#include <array>
#include <string>
#include <vector>

#include "game/lock.hpp"

namespace game {

/// Where lifts are on the joystick's axis.
struct AxisScale {
  float range_deg = 900;  // that the device turns from one end of the axis to the other
  float lift_deg = 90;    // that a lift of 1 takes; lift 0 is the middle of the axis

  [[nodiscard]] float lift(int axis) const;
  [[nodiscard]] int axis(float lift) const;  // within the axis
};

class Haptics {
 public:
  /// Uploads every effect that the device has.
  /// @param joystick null, or one without force feedback: then nothing below does anything
  Haptics(SDL_Joystick* joystick, AxisScale scale);
  ~Haptics();  // stops all forces
  Haptics(const Haptics&) = delete;
  Haptics& operator=(const Haptics&) = delete;

  /// Makes the device feel so from now on.
  void feel(const Forces& forces, Uint32 now_ms);
  /// Plays the knock that belongs to an event, if one does.
  void knock(Event event);
  /// Stops all forces until the next feel().
  void stop();

  struct Effect {
    const char* name = "";
    Uint32 type = 0;  // also its bit in SDL_HapticQuery()
    SDL_HapticEffect now{};
    int id = -1;  // less than 0: the device does not have it
    Uint32 changed_ms = 0;
    int updates = 0;
    int starts = 0;
  };
  /// How many springs a wall is made of: devices spread a full coefficient over their whole axis,
  /// and on the axis of a steering wheel one such spring feels like rubber. What no device can
  /// render it softens by itself.
  static constexpr std::size_t kWallSprings = 5;
  enum Slot : std::uint8_t {
    pin,
    friction,
    damping,
    grind,
    click,
    thump,
    wall,  // and those behind it
    kSlots = wall + kWallSprings
  };

  [[nodiscard]] bool works() const { return device_ != nullptr; }
  [[nodiscard]] const std::array<Effect, kSlots>& effects() const { return effects_; }
  [[nodiscard]] const std::vector<std::string>& errors() const { return errors_; }

 private:
  void update(std::size_t slot, Uint32 now_ms);
  void run(std::size_t slot, Uint32 times);
  bool check(int result, const char* what);

  AxisScale scale_;
  SDL_Haptic* device_ = nullptr;
  bool running_ = false;
  std::array<Effect, kSlots> effects_;
  std::array<SDL_HapticEffect, kSlots> wanted_{};
  std::vector<std::string> errors_;
};

}  // namespace game
