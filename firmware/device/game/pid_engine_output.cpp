// PidEngine: reports to the host. Feature reports, the axis, and how the effects are.
#include <bit>

#include "core/math.hpp"
#include "device/game/codec.hpp"
#include "device/game/pid_engine.hpp"

namespace torsio::device::game {
namespace {

// Blocks are all alike and kept in a table of their own, so the pool is simply counted in bytes.
constexpr std::uint16_t kBlockBytes = 64;
// Reports of the axis in the time after which nobody is there to fetch them. Linux throws away what
// comes in the 50 ms after a program has opened the device.
constexpr std::uint64_t kHeartbeats = 5;

}  // namespace

std::size_t PidEngine::get_feature(std::uint8_t id, std::span<std::uint8_t> report) {
  heard_ = true;
  if (report.size() < kLongestReport) return 0;
  switch (id) {
    case PidLayout<BlockLoad>::id:
      block_load_.pool_available = pool_available();
      return encode(block_load_, report);
    case PidLayout<Pool>::id: {
      Pool pool;
      pool.size = kBlocks * kBlockBytes;
      return encode(pool, report);
    }
    default:
      return 0;
  }
}

std::uint16_t PidEngine::pool_available() const {
  std::uint16_t bytes = 0;
  for (const Block& block : blocks_) {
    if (block.type == EffectType::none) bytes = static_cast<std::uint16_t>(bytes + kBlockBytes);
  }
  return bytes;
}

protocol::GameMonitor PidEngine::monitor(float torque_step_nm) {
  const auto steps = [torque_step_nm](float nm) {
    return static_cast<std::int16_t>(core::clamp_symmetric(nm / torque_step_nm, float{kFull}));
  };
  const auto toggle = [](bool on) { return on ? protocol::Toggle::on : protocol::Toggle::off; };
  protocol::GameMonitor monitor;
  monitor.tick = now_.tick;
  monitor.owner = now_.owner;
  monitor.paused = toggle(paused_);
  monitor.enabled = toggle(enabled_);
  monitor.gain = static_cast<std::uint16_t>(gain_ * static_cast<float>(kFull) + 0.5F);
  monitor.torque = steps(forces_.sum_nm());
  monitor.updates = updates_;
  monitor.clipped_ticks = forces_.clipped_ticks();
  const std::uint32_t percent = core::round_to_u32(100.0F * asked_nm_ / scale_.torque_nm);
  monitor.asked_percent = static_cast<std::uint16_t>(percent < 0xFFFF ? percent : 0xFFFF);
  std::size_t row = 0;
  for (std::uint8_t n = 0; n < kBlocks; ++n) {
    const auto index = static_cast<std::uint8_t>((monitored_ + n) % kBlocks);
    const Block& block = blocks_[index];
    if (block.type == EffectType::none) continue;
    ++monitor.effects;
    if (row == monitor.effect.size()) continue;
    const std::uint64_t silent_ms = (now_.tick - block.updated_tick) * period_ns_ / 1'000'000;
    protocol::GameEffect& shown = monitor.effect[row++];
    shown.block = static_cast<std::uint8_t>(index + 1);
    shown.kind = static_cast<protocol::GameEffectKind>(block.type);
    shown.state = protocol::GameEffectState::stopped;
    if (is_aside(index)) shown.state = protocol::GameEffectState::set_aside;
    if (plays(index)) shown.state = protocol::GameEffectState::playing;
    shown.torque = steps(forces_.block_torque_nm(index));
    shown.updates = block.updates;
    shown.silent_ms = static_cast<std::uint16_t>(silent_ms < 0xFFFF ? silent_ms : 0xFFFF);
  }
  if (row != 0) monitored_ = monitor.effect[row - 1].block;
  return monitor;
}

std::int16_t PidEngine::axis() const {
  // Beyond this many counts the product would not fit, and the end is long passed.
  constexpr std::int64_t kMany = std::int64_t{1} << 30;
  const std::int64_t counts = now_.position_counts;
  const bool far = counts > kMany || counts < -kMany;
  const std::int64_t magnitude = far ? kMany : counts < 0 ? -counts : counts;
  // Two factors, each of less than 2^63: the scale is at most a few thousand steps a count.
  const std::int64_t whole = magnitude * (scale_.axis_per_count_q32 >> 32);
  const std::int64_t part =
      (magnitude * (scale_.axis_per_count_q32 & 0xFFFFFFFF) + (std::int64_t{1} << 31)) >> 32;
  const std::int64_t steps = whole + part > kFull ? kFull : whole + part;
  return static_cast<std::int16_t>((counts < 0) != scale_.reversed ? -steps : steps);
}

std::uint8_t PidEngine::status() const {
  std::uint8_t bits = 0;
  if (paused_) bits |= state_bit::paused;
  if (enabled_) bits |= state_bit::actuators_enabled;
  if (scale_.allowed && now_.owner != protocol::Owner::sdk) bits |= state_bit::override_switch;
  if (now_.owner == protocol::Owner::game) bits |= state_bit::actuator_power;
  return bits;
}

bool PidEngine::plays(std::size_t index) const {
  return (forces_.playing_blocks(index / 32) >> (index % 32) & 1U) != 0;
}

bool PidEngine::is_aside(std::size_t index) const {
  return (forces_.blocks_aside(index / 32) >> (index % 32) & 1U) != 0;
}

std::size_t PidEngine::get_input(std::uint8_t id, std::span<std::uint8_t> report) {
  if (report.size() < kLongestReport) return 0;
  if (id == PidLayout<Joystick>::id) return encode(Joystick{axis(), buttons_}, report);
  if (id != PidLayout<PidState>::id) return 0;
  PidState state{status(), 0, 1};
  for (std::uint8_t block = kBlocks; block > 0; --block) {
    if (plays(block - 1U)) state = {state.status, 1, block};
  }
  return encode(state, report);
}

std::size_t PidEngine::next_input(std::span<std::uint8_t> report) {
  if (report.size() < kLongestReport) return 0;
  asked_ = true;
  if (offered_) reader_ = true;  // the one before was fetched
  // In turns: a knob that moves all the time must not keep the states back.
  joystick_turn_ = !joystick_turn_;
  std::size_t size = joystick_turn_ ? next_joystick(report) : next_state(report);
  if (size == 0) size = joystick_turn_ ? next_state(report) : next_joystick(report);
  offered_ = size != 0;
  return size;
}

std::size_t PidEngine::next_joystick(std::span<std::uint8_t> report) {
  const Joystick joystick{axis(), buttons_};
  const bool heartbeat = now_.tick - joystick_tick_ >= scale_.abandoned_ticks / kHeartbeats;
  if (joystick_sent_ && joystick == joystick_ && !heartbeat) return 0;
  joystick_ = joystick;
  joystick_sent_ = true;
  joystick_tick_ = now_.tick;
  return encode(joystick_, report);
}

std::size_t PidEngine::next_state(std::span<std::uint8_t> report) {
  PidState state;
  state.status = status();
  for (std::size_t word = 0; word < playing_sent_.size(); ++word) {
    const std::uint32_t playing = forces_.playing_blocks(word);
    const std::uint32_t changed = playing ^ playing_sent_[word];
    if (changed == 0) continue;
    const std::uint32_t bit = changed & -changed;  // one at a time, the lowest first
    playing_sent_[word] ^= bit;
    state.playing = (playing & bit) != 0 ? 1 : 0;
    state.block = static_cast<std::uint8_t>(32 * word + std::countr_zero(bit) + 1);
    return send(state, report);
  }
  if (state.status == status_sent_ && !state_due_) return 0;
  return send(state, report);
}

std::size_t PidEngine::send(const PidState& state, std::span<std::uint8_t> report) {
  status_sent_ = state.status;
  state_due_ = false;
  return encode(state, report);
}

}  // namespace torsio::device::game
