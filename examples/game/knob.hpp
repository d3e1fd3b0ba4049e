/// @file
/// The joystick that one plays with, and its forces.
#pragma once

#include <SDL.h>

#include <memory>
#include <optional>
#include <ostream>
#include <string>

#include "game/haptics.hpp"

namespace game {

class Knob {
 public:
  /// @returns the joystick of that index, or the first whose name has "Torsio" in it; null if there
  ///   is none
  /// @throws std::runtime_error when the index is wrong or the joystick cannot be opened
  static std::unique_ptr<Knob> open(std::optional<int> index, AxisScale scale, bool haptic);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] SDL_JoystickID id() const { return SDL_JoystickInstanceID(joystick_.get()); }
  [[nodiscard]] float lift() const { return scale_.lift(SDL_JoystickGetAxis(joystick_.get(), 0)); }
  Haptics& haptics() { return haptics_; }
  /// Which of the effects that the game wants the device does not have; empty if none.
  [[nodiscard]] std::string missing() const;
  /// Writes the knob's part of the report: a JSON object.
  void report(std::ostream& to) const;

 private:
  struct Close {
    void operator()(SDL_Joystick* joystick) const { SDL_JoystickClose(joystick); }
  };
  Knob(SDL_Joystick* joystick, AxisScale scale, bool haptic);

  std::unique_ptr<SDL_Joystick, Close> joystick_;
  std::string name_;
  AxisScale scale_;
  Haptics haptics_;
};

/// Writes every joystick with its number, its name and its force effects.
void list_joysticks(std::ostream& to);

}  // namespace game
