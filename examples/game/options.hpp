/// @file
/// The command line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace game {

struct Options {
  bool help = false;
  bool list = false;
  bool headless = false;
  bool autopilot = false;
  bool haptic = true;
  bool any_joystick = true;  // without --joystick: the first knob
  std::optional<int> joystick;
  std::optional<int> frames;
  float range_deg = 900;
  std::uint32_t seed = 1;
  std::string screenshot;
  std::string report;
};

extern const char* const kUsage;

/// @throws std::invalid_argument what is wrong, in words
Options parse(int argc, char** argv);

}  // namespace game
