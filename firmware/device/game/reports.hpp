/// @file
/// The reports of the game interface: a joystick with force feedback, as the USB Physical Interface
/// Device class (PID 1.0) describes it. Each report is one list of fields; the report descriptor
/// (report_descriptor.hpp) and the codec (codec.hpp) are both made from it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "device/game/fields.hpp"
#include "protocol/field_list.hpp"

namespace torsio::device::game {

inline constexpr std::uint8_t kBlocks = 40;
inline constexpr std::uint8_t kEffectTypes = 11;
inline constexpr std::int16_t kFull = 32767;         // logical maximum of levels and of the axis
inline constexpr std::uint16_t kEndless = 0xFFFF;    // as a duration
inline constexpr std::uint8_t kEndlessLoops = 0xFF;  // as a loop count
inline constexpr std::uint8_t kButtons = 2;
inline constexpr std::size_t kLongestReport = 32;

namespace detail {

template <class Owner, class T>
consteval Value<Owner, T> level(T Owner::* member, std::uint8_t id, std::int32_t min) {
  return {member, usage::pid, id, min, kFull};
}
/// Milliseconds. Linux 6.1 sends what a program asks for, also beyond the logical maximum.
template <class Owner>
consteval Value<Owner, std::uint16_t> time(std::uint16_t Owner::* member, std::uint8_t id) {
  return {member, usage::pid, id, 0, kFull, kFull, kMilliseconds, false};
}
template <class Owner>
consteval Value<Owner, std::uint8_t> block_index(std::uint8_t Owner::* member) {
  return {member, usage::pid, 0x22, 1, kBlocks};
}
template <class Owner>
consteval Choice<Owner, kEffectTypes> effect_type(std::uint8_t Owner::* member, bool strict) {
  return {member, 0x25, {0x26, 0x27, 0x30, 0x31, 0x32, 0x33, 0x34, 0x40, 0x41, 0x42, 0x43}, strict};
}

}  // namespace detail

// In the order of the choices of an effect's type.
enum class EffectType : std::uint8_t {
  none,
  constant,
  ramp,
  square,
  sine,
  triangle,
  sawtooth_up,
  sawtooth_down,
  spring,
  damper,
  inertia,
  friction,
};

struct Joystick {
  std::int16_t x = 0;
  std::uint8_t buttons = 0;
  std::int16_t y = 0;  // constant: programs take a device of one axis for no joystick

  friend bool operator==(const Joystick&, const Joystick&) = default;
};
// Stands in the application collection itself.
template <>
struct PidLayout<Joystick> : Heading<0x01, Main::input> {
  static constexpr protocol::FieldList fields{
      Value{&Joystick::x, game::usage::desktop, 0x30, -kFull, kFull},
      Bits<Joystick, kButtons>{&Joystick::buttons,
                               {{{game::usage::button, 1}, {game::usage::button, 2}}}},
      Value{&Joystick::y, game::usage::desktop, 0x31, -kFull, kFull},
  };
};

/// Without a safety switch: Linux makes a button of it, which a game would find pressed all the
/// time.
struct PidState {
  std::uint8_t status = 0;  // bits, see state_bit
  std::uint8_t playing = 0;
  std::uint8_t block = 0;
};
namespace state_bit {
inline constexpr std::uint8_t paused = 1 << 0;
inline constexpr std::uint8_t actuators_enabled = 1 << 1;
// The user lets games have the actuator. DirectInput reads a 0 as "switched off by the user", so
// it is 1 unless that is so.
inline constexpr std::uint8_t override_switch = 1 << 2;
inline constexpr std::uint8_t actuator_power = 1 << 3;  // the game has the actuator
}  // namespace state_bit
template <>
struct PidLayout<PidState> : Heading<0x02, Main::input, 0x92> {
  static constexpr protocol::FieldList fields{
      Bits<PidState, 4>{&PidState::status,
                        {{{game::usage::pid, 0x9F},
                          {game::usage::pid, 0xA0},
                          {game::usage::pid, 0xA5},
                          {game::usage::pid, 0xA6}}}},
      Bits<PidState, 1>{&PidState::playing, {{{game::usage::pid, 0x94}}}},
      detail::block_index(&PidState::block),
  };
};

struct SetEffect {
  std::uint8_t block = 0;
  std::uint8_t type = 0;
  std::uint16_t duration_ms = 0;
  std::uint16_t trigger_repeat_ms = 0;
  std::uint16_t start_delay_ms = 0;
  std::uint16_t gain = 0;
  std::uint8_t trigger_button = 0;
  std::uint8_t enable = 0;  // bit 0: axis x, bit 1: direction
  std::array<std::uint16_t, 2> direction{};
};
template <>
struct PidLayout<SetEffect> : Heading<0x11, Main::output, 0x21> {
  static constexpr protocol::FieldList fields{
      detail::block_index(&SetEffect::block),
      // A block's kind was set when it was created. Linux before June 2026 names the type of the
      // effect that was created last.
      detail::effect_type(&SetEffect::type, false),
      detail::time(&SetEffect::duration_ms, 0x50),
      detail::time(&SetEffect::trigger_repeat_ms, 0x54),
      detail::time(&SetEffect::start_delay_ms, 0xA7),
      detail::level(&SetEffect::gain, 0x52, 0),
      // Linux sends its own numbers for buttons; a number without a button here is no trigger.
      Value<SetEffect, std::uint8_t>{&SetEffect::trigger_button, game::usage::pid, 0x53, 1,
                                     kButtons, 0, kNoUnit, false},
      Bits<SetEffect, 2>{&SetEffect::enable,
                         {{{game::usage::desktop, 0x30, 0x55}, {game::usage::pid, 0x56}}}},
      Values<SetEffect, 2>{
          &SetEffect::direction, 0x57, game::usage::ordinal, {1, 2}, kFull, kTurn, kCentidegrees},
  };
};

struct SetEnvelope {
  std::uint8_t block = 0;
  std::uint16_t attack_level = kFull;
  std::uint16_t attack_ms = 0;
  std::uint16_t fade_level = kFull;
  std::uint16_t fade_ms = 0;
};
template <>
struct PidLayout<SetEnvelope> : Heading<0x12, Main::output, 0x5A> {
  static constexpr protocol::FieldList fields{
      detail::block_index(&SetEnvelope::block),
      detail::level(&SetEnvelope::attack_level, 0x5B, 0),
      detail::level(&SetEnvelope::fade_level, 0x5D, 0),
      detail::time(&SetEnvelope::attack_ms, 0x5C),
      detail::time(&SetEnvelope::fade_ms, 0x5E),
  };
};

struct SetCondition {
  std::uint8_t block = 0;
  std::uint8_t parameter_block = 0;
  std::int16_t offset = 0;
  std::int16_t positive_coefficient = 0;
  std::int16_t negative_coefficient = 0;
  std::uint16_t positive_saturation = 0;
  std::uint16_t negative_saturation = 0;
  std::uint16_t dead_band = 0;
};
template <>
struct PidLayout<SetCondition> : Heading<0x13, Main::output, 0x5F> {
  static constexpr protocol::FieldList fields{
      detail::block_index(&SetCondition::block),
      Value{&SetCondition::parameter_block, game::usage::pid, 0x23, 0, 1},
      detail::level(&SetCondition::offset, 0x60, -kFull),
      detail::level(&SetCondition::positive_coefficient, 0x61, -kFull),
      detail::level(&SetCondition::negative_coefficient, 0x62, -kFull),
      detail::level(&SetCondition::positive_saturation, 0x63, 0),
      detail::level(&SetCondition::negative_saturation, 0x64, 0),
      detail::level(&SetCondition::dead_band, 0x65, 0),
  };
};

struct SetPeriodic {
  std::uint8_t block = 0;
  std::uint16_t magnitude = 0;
  std::int16_t offset = 0;
  std::uint16_t phase = 0;
  std::uint16_t period_ms = 0;
};
template <>
struct PidLayout<SetPeriodic> : Heading<0x14, Main::output, 0x6E> {
  static constexpr protocol::FieldList fields{
      detail::block_index(&SetPeriodic::block),
      detail::level(&SetPeriodic::magnitude, 0x70, 0),
      detail::level(&SetPeriodic::offset, 0x6F, -kFull),
      Value{&SetPeriodic::phase, game::usage::pid, 0x71, 0, kFull, kTurn, kCentidegrees},
      detail::time(&SetPeriodic::period_ms, 0x72),
  };
};

struct SetConstant {
  std::uint8_t block = 0;
  std::int16_t magnitude = 0;
};
template <>
struct PidLayout<SetConstant> : Heading<0x15, Main::output, 0x73> {
  static constexpr protocol::FieldList fields{
      detail::block_index(&SetConstant::block),
      detail::level(&SetConstant::magnitude, 0x70, -kFull),
  };
};

struct SetRamp {
  std::uint8_t block = 0;
  std::int16_t start = 0;
  std::int16_t end = 0;
};
template <>
struct PidLayout<SetRamp> : Heading<0x16, Main::output, 0x74> {
  static constexpr protocol::FieldList fields{
      detail::block_index(&SetRamp::block),
      detail::level(&SetRamp::start, 0x75, -kFull),
      detail::level(&SetRamp::end, 0x76, -kFull),
  };
};

enum class Operation : std::uint8_t { none, start, start_solo, stop };

struct EffectOperation {
  std::uint8_t block = 0;
  std::uint8_t operation = 0;
  std::uint8_t loops = 1;
};
template <>
struct PidLayout<EffectOperation> : Heading<0x1A, Main::output, 0x77> {
  static constexpr protocol::FieldList fields{
      detail::block_index(&EffectOperation::block),
      Choice<EffectOperation, 3>{&EffectOperation::operation, 0x78, {0x79, 0x7A, 0x7B}},
      Value{&EffectOperation::loops, game::usage::pid, 0x7C, 0, 255},
  };
};

struct BlockFree {
  std::uint8_t block = 0;
};
template <>
struct PidLayout<BlockFree> : Heading<0x1B, Main::output, 0x90> {
  static constexpr protocol::FieldList fields{detail::block_index(&BlockFree::block)};
};

enum class Control : std::uint8_t {
  none,
  enable_actuators,
  disable_actuators,
  stop_all,
  reset,
  pause,
  resume,
};

struct DeviceControl {
  std::uint8_t control = 0;
};
// The choice's own collection is the report's.
template <>
struct PidLayout<DeviceControl> : Heading<0x1C, Main::output> {
  static constexpr protocol::FieldList fields{
      Choice<DeviceControl, 6>{&DeviceControl::control, 0x96, {0x97, 0x98, 0x99, 0x9A, 0x9B, 0x9C}},
  };
};

struct DeviceGain {
  std::uint16_t gain = 0;
};
template <>
struct PidLayout<DeviceGain> : Heading<0x1D, Main::output, 0x7D> {
  static constexpr protocol::FieldList fields{detail::level(&DeviceGain::gain, 0x7E, 0)};
};

struct CreateEffect {
  std::uint8_t type = 0;
  std::uint16_t custom_bytes = 0;  // of custom forces, which do not exist here
};
template <>
struct PidLayout<CreateEffect> : Heading<0x21, Main::feature, 0xAB> {
  static constexpr protocol::FieldList fields{
      detail::effect_type(&CreateEffect::type, true),
      Value<CreateEffect, std::uint16_t>{&CreateEffect::custom_bytes, game::usage::desktop, 0x3B, 0,
                                         511, 0, kNoUnit, false},
  };
};

enum class LoadStatus : std::uint8_t { none, success, full, error };

struct BlockLoad {
  std::uint8_t block = 0;
  std::uint8_t status = 0;
  std::uint16_t pool_available = 0;
};
template <>
struct PidLayout<BlockLoad> : Heading<0x22, Main::feature, 0x89> {
  static constexpr protocol::FieldList fields{
      detail::block_index(&BlockLoad::block),
      Choice<BlockLoad, 3>{&BlockLoad::status, 0x8B, {0x8C, 0x8D, 0x8E}},
      Value{&BlockLoad::pool_available, game::usage::pid, 0xAC, 0, kFull},
  };
};

struct Pool {
  std::uint16_t size = 0;
  std::uint8_t simultaneous = kBlocks;
  std::uint8_t managed = 1;  // bit 0: by the device; bit 1: parameter blocks are shared
};
template <>
struct PidLayout<Pool> : Heading<0x23, Main::feature, 0x7F> {
  static constexpr protocol::FieldList fields{
      Value{&Pool::size, game::usage::pid, 0x80, 0, kFull},
      Value{&Pool::simultaneous, game::usage::pid, 0x83, 0, kBlocks},
      Bits<Pool, 2>{&Pool::managed, {{{game::usage::pid, 0xA9}, {game::usage::pid, 0xAA}}}},
  };
};

/// Every report in the order of the descriptor; the joystick's is the first.
using PidReports = std::tuple<Joystick, PidState, SetEffect, SetEnvelope, SetCondition, SetPeriodic,
                              SetConstant, SetRamp, EffectOperation, BlockFree, DeviceControl,
                              DeviceGain, CreateEffect, BlockLoad, Pool>;

}  // namespace torsio::device::game
