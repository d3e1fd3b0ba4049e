/// @file
/// A pin tumbler lock, how it is picked and what the hand feels: plain functions over plain state.
///
/// Lifts are what the pick is lifted by: 0 where it lies in the keyway, 1 where an unset pin meets
/// the top of its chamber. Levels are shares of what the device can give, 0 to 1.
#pragma once

#include <array>
#include <cstdint>

namespace game {

inline constexpr int kPins = 5;
inline constexpr float kLowered = 0.15F;  // below this lift the pick touches no pin and can move on
inline constexpr float kGive = 0.08F;     // a set pin that is pressed further than this is forced
inline constexpr float kPatience_s = 0.3F;  // a set pin that is forced for so long drops
inline constexpr float kFloor = -0.06F;

struct Pin {
  float shear_lift;  // at which it clears the shear line
  int order;         // pins bind one after the other, 0 first
};

struct Lock {
  std::array<Pin, kPins> pins;
  int set_count = 0;  // the pins whose order is less than this are set
  int selected = 0;
  float lift = 0;
  float speed_per_s = 0;  // of the lift, smoothed
  float forced_s = 0;     // how long the selected pin has been forced
  float turn_from = 0;    // lift at which the plug began to turn
  float turn = 0;         // of the plug: 0 shut, 1 open
  float time_s = 0;       // until it was open
  int dropped = 0;        // pins lost by force
};

struct Input {
  float lift = 0;
  int move = 0;  // to the pin before (-1) or after (+1); 0 stays
};

enum class Event : std::uint8_t { none, moved, set, freed, dropped, opened };

/// The same seed gives the same lock.
Lock make_lock(std::uint32_t seed);

inline bool is_set(const Lock& lock, int pin) { return lock.pins[pin].order < lock.set_count; }
inline bool is_free(const Lock& lock) { return lock.set_count == kPins; }  // the plug turns
inline bool is_open(const Lock& lock) { return lock.turn >= 1; }
/// Whether the pick presses on the one pin that binds.
bool is_binding(const Lock& lock);

/// Lets the hand do something for dt_s seconds; returns what it brought about.
Event step(Lock& lock, const Input& input, float dt_s);

/// What the hand feels, for as long as the state stays what it is.
struct Forces {
  float floor_lift = kFloor;  // a wall for whoever goes below
  float ceiling_lift = 1;     // a wall for whoever goes above
  bool low = false;           // nearer to the floor than to the ceiling
  float spring = 0;           // pushes the pick down to lift 0
  float friction = 0;
  float damping = 0;
  float grind = 0;  // amplitude of a vibration

  friend bool operator==(const Forces&, const Forces&) = default;
};
Forces forces(const Lock& lock);

/// A player that knows nothing of the lock and goes by what it feels.
class Autopilot {
 public:
  Input next(const Forces& felt, float dt_s);

 private:
  float lift_ = 0;
  bool up_ = true;
};

}  // namespace game
