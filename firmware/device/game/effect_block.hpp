/// @file
/// One block of a HID PID device's pool: what a game has said of an effect, and the force that the
/// control interrupt makes of it.
#pragma once

#include <cstdint>

#include "device/game/forces.hpp"
#include "device/game/params.hpp"
#include "device/game/reports.hpp"

namespace torsio::device::game {

struct Block {
  EffectType type = EffectType::none;  // none: free
  SetEffect effect;
  SetEnvelope envelope;
  SetCondition condition;
  SetPeriodic periodic;
  SetConstant constant;
  SetRamp ramp;
  bool has_envelope = false;
  bool may_be_folded = false;  // its negative saturation; see effect_block.cpp
  bool dirty = false;          // the interrupt does not know yet
  bool abandoned = false;      // the game that made it is gone
  ForceOrder::Play play = ForceOrder::Play::as_it_is;
  std::uint8_t loops = 1;
  std::uint64_t triggered_tick = 0;
  // For those who watch.
  std::uint32_t updates = 0;
  std::uint64_t updated_tick = 0;
};

constexpr bool is_timed(EffectType type) { return type < EffectType::spring; }
constexpr bool is_periodic(EffectType type) {
  return type >= EffectType::square && type <= EffectType::sawtooth_down;
}
/// Linux 6.1 sends its own sign for "without end", which is 0.
constexpr bool is_endless(const Block& block) {
  return block.effect.duration_ms == 0 || block.effect.duration_ms == kEndless;
}

/// A number of a report as a share of full.
constexpr float level(std::int32_t value) {
  return static_cast<float>(value) * (1.0F / static_cast<float>(kFull));
}

/// @param block must not be free
PreparedEffect prepare_effect(const Block& block, const GameScale& scale, std::uint32_t period_ns);

}  // namespace torsio::device::game
