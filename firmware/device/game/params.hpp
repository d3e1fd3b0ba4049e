/// @file
/// The configuration for games, prepared for the two sides of the game interface.
#pragma once

#include <array>
#include <cstdint>

#include "device/config.hpp"
#include "device/game/forces.hpp"

namespace torsio::device::game {

/// Meaning of a game's numbers on this device.
struct GameScale {
  float period_s = 0;
  float torque_nm = 0;       // at full level
  float gain = 1;            // of the user, on top of the game's
  float half_range_rad = 1;  // from the middle of the axis to its end
  float stiffness_nm_per_rad = 0;
  float speed_rad_s = 1;
  float acceleration_rad_s2 = 1;
  StableLimits most;
  std::int64_t axis_per_count_q32 = 0;
  std::uint64_t silence_ticks = 0;    // 0: no limit
  std::uint64_t abandoned_ticks = 1;  // without anybody who fetches input reports
  bool allowed = true;
  bool reversed = false;                                      // axis and forces go the other way
  std::array<std::uint8_t, kEffectTypes + 1> gain_percent{};  // of the user, by type
  bool own_is_felt = false;                                   // there is a feel of the player's own
  std::uint32_t hold_counts = 0;  // its spring is stronger than friction beyond; 0: there is none
};

constexpr float share_of(std::uint8_t percent) { return static_cast<float>(percent) * 0.01F; }

GameScale make_game_scale(const Config& config, std::uint32_t period_ns);

ForceParams make_force_params(const Config& config, std::uint32_t period_ns);

}  // namespace torsio::device::game
