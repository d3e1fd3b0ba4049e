/// @file
/// The picture of the lock.
#pragma once

#include <SDL.h>

#include <string>

#include "game/lock.hpp"

namespace game {

inline constexpr int kWidth = 960;
inline constexpr int kHeight = 600;

/// The lift at a height in the window, for playing with the mouse.
float lift_at(float y);

/// What the picture shows besides the lock.
struct Status {
  std::string input;    // what one plays with
  std::string hint;     // empty: what to do next
  int opened = 0;       // locks so far
  float knob_deg = 0;   // how far the knob is turned
  float lift_deg = 90;  // what a lift of 1 takes
  float since_event_s = 0;
  Event event = Event::none;  // the last one
};

void draw(SDL_Renderer* renderer, const Lock& lock, const Status& status);

}  // namespace game
