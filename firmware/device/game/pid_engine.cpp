#include "device/game/pid_engine.hpp"

#include <type_traits>

#include "device/game/codec.hpp"
#include "protocol/registry.hpp"

namespace torsio::device::game {
namespace {

// How Linux from 6.15 on begins, and nobody else: reset, reset, stop all, enable actuators.
constexpr std::uint32_t kLinuxBegins = 0x04'04'03'01;

// Keeps the orders that wait for the interrupt, except those that start or bring back an effect.
constexpr ForceOrder::Play without_start(ForceOrder::Play play) {
  const bool starts = play == ForceOrder::Play::start || play == ForceOrder::Play::go_on;
  return starts ? ForceOrder::Play::as_it_is : play;
}

// Where a block keeps what a report says of it; nullptr if it is of another kind.
SetEffect* place_of(Block& block, const SetEffect&) { return &block.effect; }
SetEnvelope* place_of(Block& block, const SetEnvelope&) {
  return is_timed(block.type) ? &block.envelope : nullptr;
}
SetCondition* place_of(Block& block, const SetCondition& set) {
  // There is one axis; a report about a second one is for another device.
  return !is_timed(block.type) && set.parameter_block == 0 ? &block.condition : nullptr;
}
SetPeriodic* place_of(Block& block, const SetPeriodic&) {
  return is_periodic(block.type) ? &block.periodic : nullptr;
}
SetConstant* place_of(Block& block, const SetConstant&) {
  return block.type == EffectType::constant ? &block.constant : nullptr;
}
SetRamp* place_of(Block& block, const SetRamp&) {
  return block.type == EffectType::ramp ? &block.ramp : nullptr;
}

}  // namespace

PidEngine::PidEngine(const Config& config, std::uint32_t period_ns)
    : forces_(make_force_params(config, period_ns)),
      period_ns_(period_ns),
      scale_(make_game_scale(config, period_ns)),
      turn_watch_(period_ns) {}

void PidEngine::configure(const Config& config) {
  scale_ = make_game_scale(config, period_ns_);
  forces_.prepare(make_force_params(config, period_ns_));
  for (Block& block : blocks_) {
    if (block.type != EffectType::none) touch(block);
  }
  settings_dirty_ = true;
}

// Reports in ---------------------------------------------------------------------------------

/// The control loop is to hear of it.
void PidEngine::touch(Block& block) {
  block.dirty = true;
  blocks_dirty_ = true;
}

void PidEngine::count(Block& block) {
  ++block.updates;
  block.updated_tick = now_.tick;
  if (!block.abandoned) return;
  for (Block& other : blocks_) other.abandoned = false;  // who made them is there after all
}

Block* PidEngine::find(std::uint8_t index) {
  if (index < 1 || index > kBlocks || blocks_[index - 1].type == EffectType::none) return nullptr;
  return &blocks_[index - 1];
}

/// A report about a block, if that is one of its kind.
template <class Report>
void PidEngine::take(const Report& report) {
  Block* block = find(report.block);
  Report* place = block == nullptr ? nullptr : place_of(*block, report);
  if (place == nullptr) return;
  *place = report;
  if constexpr (std::is_same_v<Report, SetEnvelope>) block->has_envelope = true;
  touch(*block);
  count(*block);
  if (block->play == ForceOrder::Play::as_it_is || block->play == ForceOrder::Play::set_aside) {
    block->play = ForceOrder::Play::go_on;
  }
}

bool PidEngine::receive(std::span<const std::uint8_t> report) {
  if (report.empty()) return true;
  heard_ = true;
  ++updates_;
  if (report[0] != PidLayout<DeviceControl>::id) controls_ = 0;
  protocol::for_each_report<PidReports>([&]<class Report>(std::type_identity<Report>) {
    if constexpr (PidLayout<Report>::main == Main::output) {
      if (Report content; decode(report, content)) take(content);
    }
  });
  send_orders();
  return true;
}

bool PidEngine::set_feature(std::span<const std::uint8_t> report) {
  CreateEffect create_effect;
  if (report.empty() || report[0] != PidLayout<CreateEffect>::id) return false;
  heard_ = true;
  // A type that does not exist is answered by the block load report, as the standard wants it.
  const bool known = decode(report, create_effect);
  create(known ? static_cast<EffectType>(create_effect.type) : EffectType::none);
  return true;
}

void PidEngine::create(EffectType type) {
  block_load_ = {};
  if (type == EffectType::none) {
    block_load_.status = static_cast<std::uint8_t>(LoadStatus::error);
    return;
  }
  for (std::uint8_t i = 0; i < kBlocks; ++i) {
    Block& block = blocks_[i];
    if (block.type != EffectType::none) continue;
    const ForceOrder::Play play = block.play;  // a stop that is still on its way
    block = Block{};
    block.type = type;
    block.updated_tick = now_.tick;
    touch(block);
    block.play = play;
    block.effect.gain = kFull;
    block.may_be_folded = host_folds_;
    block_load_.block = static_cast<std::uint8_t>(i + 1);
    block_load_.status = static_cast<std::uint8_t>(LoadStatus::success);
    return;
  }
  bool freed = false;
  for (std::uint8_t i = 0; i < kBlocks; ++i) {
    if (!blocks_[i].abandoned) continue;
    take(BlockFree{static_cast<std::uint8_t>(i + 1)});
    blocks_[i].abandoned = false;
    freed = true;
  }
  if (freed) return create(type);
  block_load_.status = static_cast<std::uint8_t>(LoadStatus::full);
}

void PidEngine::take(const BlockFree& free) {
  Block* block = find(free.block);
  if (block == nullptr) return;
  block->type = EffectType::none;
  block->play = ForceOrder::Play::stop;
  touch(*block);
}

void PidEngine::play(Block& block, std::uint8_t loops) {
  block.play = ForceOrder::Play::start;
  block.loops = loops;
  touch(block);
}

void PidEngine::take(const EffectOperation& operation) {
  Block* block = find(operation.block);
  if (block == nullptr) return;
  count(*block);
  switch (static_cast<Operation>(operation.operation)) {
    case Operation::none:
      break;
    case Operation::start_solo:
      stop_all();
      [[fallthrough]];
    case Operation::start:
      play(*block, operation.loops);
      break;
    case Operation::stop:
      block->play = ForceOrder::Play::stop;
      touch(*block);
      break;
  }
}

void PidEngine::stop_all() {
  stop_all_dirty_ = true;
  // Earlier orders must not take effect after it.
  for (Block& block : blocks_) block.play = ForceOrder::Play::as_it_is;
}

void PidEngine::take(const DeviceGain& gain) {
  gain_ = level(gain.gain);
  settings_dirty_ = true;
}

void PidEngine::take(const DeviceControl& report) {
  const auto control = static_cast<Control>(report.control);
  controls_ = controls_ << 8 | static_cast<std::uint32_t>(control);
  if (control == Control::reset) host_folds_ = false;
  if (controls_ == kLinuxBegins) host_folds_ = true;
  switch (control) {
    case Control::none:
      return;
    case Control::enable_actuators:
      enabled_ = true;
      break;
    case Control::disable_actuators:
      enabled_ = false;
      break;
    case Control::stop_all:
      stop_all();
      return;
    case Control::reset:
      stop_all();
      for (Block& block : blocks_) block = Block{};
      block_load_ = {};
      // The gain stays: Linux from 6.15 on resets at the first upload, behind the gain that a game
      // has set, and never says it again.
      enabled_ = true;
      paused_ = false;
      break;
    case Control::pause:
      paused_ = true;
      break;
    case Control::resume:
      paused_ = false;
      break;
  }
  settings_dirty_ = true;
  state_due_ = true;  // DirectInput asks for the state right after
}

// Orders -------------------------------------------------------------------------------------

void PidEngine::send_orders() {
  // Endings first: actuators that come on do not bring back what has ended.
  if (send_endings() && send_settings() && blocks_dirty_) send_blocks();
}

/// @returns whether it had room; so does the next
bool PidEngine::send_endings() {
  if (!stop_all_dirty_ && !all_aside_dirty_) return true;
  ForceOrder order;
  order.kind = stop_all_dirty_ ? ForceOrder::Kind::stop_all : ForceOrder::Kind::set_all_aside;
  if (!forces_.give(order)) return false;
  stop_all_dirty_ = false;
  all_aside_dirty_ = false;
  return true;
}

bool PidEngine::send_settings() {
  if (!settings_dirty_) return true;
  ForceOrder order;
  order.kind = ForceOrder::Kind::settings;
  order.gain = gain_;
  order.paused = paused_;
  order.enabled = enabled_;
  settings_dirty_ = !forces_.give(order);
  return !settings_dirty_;
}

void PidEngine::send_blocks() {
  for (std::uint8_t n = 0; n < kBlocks; ++n) {
    Block& block = blocks_[next_dirty_];
    if (block.dirty || block.play != ForceOrder::Play::as_it_is) {
      if (forces_.free_orders() == 0) return;
      ForceOrder order;
      order.block = next_dirty_;
      order.play = block.play;
      order.loops = block.loops;
      if (block.type != EffectType::none) order.effect = prepare_effect(block, scale_, period_ns_);
      (void)forces_.give(order);
      block.dirty = false;
      block.play = ForceOrder::Play::as_it_is;
    }
    next_dirty_ = next_dirty_ + 1 == kBlocks ? 0 : static_cast<std::uint8_t>(next_dirty_ + 1);
  }
  blocks_dirty_ = false;
}

// The rest of the device ---------------------------------------------------------------------

void PidEngine::settle(bool connected) {
  if (connected) return;
  leave_all();
  joystick_sent_ = false;
  state_due_ = true;
  offered_ = false;
  reader_ = false;
}

/// Ends everything, but not for good: an update brings it back.
void PidEngine::set_all_aside() {
  for (Block& block : blocks_) block.play = without_start(block.play);
  all_aside_dirty_ = true;
}

/// A game is gone: the next one must hear the effects that it silenced.
void PidEngine::leave_all() {
  set_all_aside();
  settings_dirty_ = settings_dirty_ || paused_ || !enabled_ || gain_ == 0.0F;
  paused_ = false;
  enabled_ = true;
  if (gain_ == 0.0F) gain_ = 1.0F;
}

bool PidEngine::plays_any() const {
  return (forces_.playing_blocks(0) | forces_.playing_blocks(1)) != 0;
}

/// Plays, or is silent until the actuators are on.
bool PidEngine::holds_any() const {
  return plays_any() || (!enabled_ && (forces_.blocks_aside(0) | forces_.blocks_aside(1)) != 0);
}

/// A game that hangs must not pull for ever. An effect that only answers to the hand may stay: a
/// game that wants a spring says so once. In a pause, or at no gain, nothing pulls, and the report
/// that ends it is a sign of life.
void PidEngine::watch_silence() {
  if (paused_ || gain_ == 0.0F) return;
  if (!plays_any()) return;
  for (std::size_t i = 0; i < kBlocks; ++i) {
    Block& block = blocks_[i];
    const bool has_end = !is_endless(block) && block.loops != kEndlessLoops;
    if (!plays(i) || !is_timed(block.type) || has_end) continue;
    if (block.play != ForceOrder::Play::as_it_is) continue;
    block.play = ForceOrder::Play::set_aside;
    blocks_dirty_ = true;
  }
}

/// Systems fetch input reports for as long as a program has the device open, whether it reads them
/// or not. While an effect plays, each heartbeat has a report to fetch. If nobody fetches it, the
/// game has ended. One that never fetched any is a driver of its own.
void PidEngine::watch_reader() {
  if (!reader_ || now_.tick - asked_tick_ <= scale_.abandoned_ticks || !holds_any()) return;
  leave_all();
  reader_ = false;
  for (Block& block : blocks_) block.abandoned = block.type != EffectType::none;
}

bool PidEngine::triggers(const Block& block, std::uint8_t buttons) {
  const std::uint8_t button = block.effect.trigger_button;
  return button >= 1 && button <= kButtons && (buttons >> (button - 1) & 1U) != 0;
}

/// A press begins the effects of the button; while it is held they begin again and again.
void PidEngine::watch_triggers() {
  const auto fresh = static_cast<std::uint8_t>(buttons_ & ~buttons_seen_);
  buttons_seen_ = buttons_;
  if (buttons_ == 0) return;
  for (Block& block : blocks_) {
    if (block.type == EffectType::none || !triggers(block, buttons_)) continue;
    if (triggers(block, fresh)) {
      play(block, 1);
      block.triggered_tick = now_.tick;
      heard_tick_ = now_.tick;  // the player is there
    }
    const std::uint16_t interval_ms = block.effect.trigger_repeat_ms;
    if (interval_ms == 0 || interval_ms == kEndless) continue;
    const std::uint64_t interval =
        (std::uint64_t{interval_ms} * 1'000'000 + period_ns_ / 2) / period_ns_;
    if (now_.tick - block.triggered_tick < interval) continue;
    block.triggered_tick += interval;
    play(block, 1);
  }
}

}  // namespace torsio::device::game
