/// @file
/// The torque of a game's effects, as the control interrupt renders it. Everything was prepared by
/// the main loop (pid_engine.hpp); here it is only evaluated, tick by tick.
///
/// A report's change must not be felt as a click, so every change is blended. The torque goes on
/// from where it was, and the difference fades to zero along a straight line. The shape of an
/// effect itself is not touched by this: a square wave keeps its edges.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/effects.hpp"
#include "core/slew_limit.hpp"
#include "device/game/joined_updates.hpp"
#include "device/game/reports.hpp"
#include "device/guest.hpp"
#include "device/ring.hpp"
#include "device/stable_limits.hpp"

namespace torsio::device::game {

/// A force that depends on time only: constant, ramp and the periodic ones.
struct TimedForce {
  // amplitude * shape + offset. The amplitude is peak_nm outside attack and fade.
  float peak_nm = 0;
  float attack_nm = 0;  // attack level minus peak
  float attack_fall_per_tick = 0;
  float fade_nm = 0;  // fade level minus peak
  float fade_fall_per_tick = 0;
  std::uint32_t attack_ticks = 0;
  std::uint32_t fade_ticks = 0;
  float offset_nm = 0;
  // Shape, within [-1, 1]: of a wave, or start + slope * tick.
  float start = 1;
  float slope_per_tick = 0;
  bool periodic = false;
  core::Waveform waveform = core::Waveform::sine;
  std::uint32_t start_phase = 0;
  std::uint32_t phase_per_tick = 0;
};

enum class Metric : std::uint8_t { time, angle, speed, acceleration, slip };
inline constexpr std::size_t kMetrics = 5;

/// A force that depends on the motion: beyond offset and dead band it grows in proportion.
struct Condition {
  float offset = 0;  // rad, rad/s or rad/s^2
  float dead_band = 0;
  float positive_gain = 0;  // N m for one of the above; slip: N m/rad of the bristle
  float negative_gain = 0;
  float positive_limit_nm = 0;
  float negative_limit_nm = 0;
};

/// The player's own, under any game and without one; each up to the cap of all.
struct OwnFeel {
  float stiffness = 0;  // N m/rad, to the middle, while no game plays
  float damping = 0;    // N m s/rad
  float inertia = 0;    // kg m^2
  float friction_nm = 0;
  float bristle = 0;  // N m/rad, of this friction
  bool is_felt = false;
};

struct PreparedEffect {
  Metric metric = Metric::time;
  std::uint32_t delay_ticks = 0;
  std::uint32_t duration_ticks = 0;  // 0: without end
  float gain = 0;  // the effect's own; for a timed force with its direction's sign
  TimedForce timed;
  Condition condition;
};

/// The main loop's orders to the interrupt. Effects come whole, so that a later one may replace an
/// earlier one that was never sent.
struct ForceOrder {
  enum class Kind : std::uint8_t { effect, settings, stop_all, set_all_aside };
  // Effects that the game ended stay ended. Effects that the device ended are set aside: the game's
  // next update (go_on) brings it back.
  enum class Play : std::uint8_t { as_it_is, go_on, start, stop, set_aside };

  Kind kind = Kind::effect;
  // effect
  std::uint8_t block = 0;  // from 0
  Play play = Play::as_it_is;
  std::uint8_t loops = 1;
  PreparedEffect effect;
  // settings
  float gain = 1;
  bool paused = false;
  bool enabled = true;
};

/// The device's configuration for games, prepared.
struct ForceParams {
  bool allowed = true;
  float torque_max_nm = 0;  // of all effects together, and of a wall at an end
  float end_rad = 1;        // where the axis ends, on both sides
  float end_stiffness = 0;  // N m/rad of the walls there
  StableLimits most{};
  std::uint32_t blend_ticks = 1;      // length of a blend
  std::uint32_t release_ticks = 1;    // of the fade when somebody else takes the actuator
  std::uint32_t idle_ticks = 1;       // with nothing to play, after which the actuator is let go
  std::uint32_t soft_ticks = 1;       // in which a spring that begins comes up
  std::uint32_t frame_max_ticks = 0;  // longest time between updates that are joined; 0: none are
  OwnFeel own{};
  float hit_nm = 0;  // a change of more than this beyond the one before it is a hit, and passes
};

class Forces final : public Guest {
 public:
  explicit Forces(const ForceParams& params)
      : Guest(protocol::Owner::game), params_(params), prepared_(params) {}

  // Control interrupt.

  /// It wants the actuator if an effect was started or brought back, or for the player's own feel.
  bool take_news(bool may_play, std::uint64_t tick) override;
  /// It has ended if nothing has played for a while, or its actuators are off.
  bool play_on() override;
  /// If not, it sleeps.
  bool stay_awake(bool has_actuator) override;

  /// Sum of the effects, blended, within the cap. Once a tick at most.
  float torque_nm(const core::Motion& motion, const core::Resolution& resolution,
                  std::uint64_t tick) override;

  void release() override;  // sets everything aside
  void drop() override;     // likewise
  void forget() override;
  void configure() override { params_ = prepared_; }

  // Main loop.
  void prepare(const ForceParams& params) { prepared_ = params; }
  /// @returns false if there is no room
  [[nodiscard]] bool give(const ForceOrder& order);
  std::uint32_t free_orders() const { return orders_.free(); }
  /// Bit n % 32 of word n / 32: block n plays.
  std::uint32_t playing_blocks(std::size_t word) const {
    return playing_[word].load(std::memory_order_relaxed);
  }
  /// The same for what the device has ended and an update brings back.
  std::uint32_t blocks_aside(std::size_t word) const {
    return aside_[word].load(std::memory_order_relaxed);
  }
  /// Torque of a block now, with its gains and the device's.
  float block_torque_nm(std::size_t block) const {
    return block_nm_[block].load(std::memory_order_relaxed);
  }
  /// Torque of all together.
  float sum_nm() const { return shown_nm_.load(std::memory_order_relaxed); }
  /// Ticks in which effects asked for more than the cap.
  std::uint32_t clipped_ticks() const { return clipped_ticks_.load(std::memory_order_relaxed); }
  /// The most that they asked for since the last call.
  float take_asked_nm() {
    const float most_nm = asked_most_nm_.load(std::memory_order_relaxed);
    asked_most_nm_.store(0.0F, std::memory_order_relaxed);
    return most_nm;
  }

 private:
  struct Playing {
    std::uint64_t start = 0;       // in the games' time
    std::uint8_t loops_left = 0;   // 0: does not play
    std::uint8_t loops_aside = 0;  // its remaining time when it was set aside
    bool muted = false;            // not heard: comes back when the game turns its actuators on
    bool sounding = false;         // past its delay
    std::uint32_t soft_left = 0;   // ticks until a spring is all there
    std::uint32_t wave_phase = 0;  // that a wave had come to when it was started again
    float slip_rad = 0;
    JoinedUpdates updates{};
  };

  bool fading() const { return residual_.nm != 0.0F; }
  bool take(const ForceOrder& order, bool may_play, std::uint64_t tick);
  bool take_settings(const ForceOrder& order, bool may_play, std::uint64_t tick);
  bool enable(bool enabled, bool may_play, std::uint64_t now);
  bool take_effect(const ForceOrder& order, bool may_play, std::uint64_t now);
  void carry_wave_on(const ForceOrder& order, std::uint64_t now);
  bool start(const ForceOrder& order, bool may_play, std::uint64_t now, bool restarts, bool joined);
  void start_unheard(const ForceOrder& order, std::uint64_t now);
  bool plays_on(const ForceOrder& order) const;
  bool go_on(std::uint8_t block, std::uint64_t now);
  bool join(const ForceOrder& order, std::uint64_t now);
  void raise_walls();
  void stop(std::uint8_t block);
  void set_aside(std::uint8_t block);
  void set_all_aside();
  using BlockBits = std::array<std::atomic<std::uint32_t>, 2>;
  static void mark(BlockBits& bits, std::uint8_t block, bool on);
  void set_loops_aside(std::uint8_t block, std::uint8_t loops);
  void stop_all();
  void share_out();
  float effects_nm(const core::Motion& motion, float period_s, std::uint64_t now);
  float within_cap_nm(float asked_nm);
  float blend_nm(float sum_nm);
  float own_nm(const core::Motion& motion, float period_s);
  std::uint64_t time(std::uint64_t tick) const { return (paused_ ? paused_at_ : tick) - pauses_; }
  bool pass_delay(const PreparedEffect& effect, Playing& play, std::uint64_t now);
  static bool pass_loops(const PreparedEffect& effect, Playing& play, std::uint64_t now);
  float effect_nm(const PreparedEffect& effect, Playing& play, const core::Motion& motion,
                  float period_s, std::uint64_t now);

  ForceParams params_;
  ForceParams prepared_;
  Ring<ForceOrder, 4> orders_;

  std::array<PreparedEffect, kBlocks> effect_;
  std::array<Playing, kBlocks> play_;
  std::array<std::uint8_t, kBlocks> order_{};  // blocks that play
  std::uint8_t active_ = 0;
  BlockBits playing_{};
  BlockBits aside_{};
  std::array<std::atomic<float>, kBlocks> block_nm_{};
  std::atomic<float> shown_nm_{0};
  std::atomic<float> asked_most_nm_{0};
  std::atomic<std::uint32_t> clipped_ticks_{0};

  std::uint32_t idle_ticks_ = 0;  // with nothing to play
  float own_slip_rad_ = 0;
  std::array<float, kMetrics> share_{1, 1, 1, 1, 1};
  float gain_ = 1;
  bool enabled_ = true;
  bool paused_ = false;
  std::uint64_t paused_at_ = 0;
  std::uint64_t pauses_ = 0;  // ticks spent in pauses

  bool walls_ = false;                 // the game has the actuator
  std::uint32_t walls_soft_left_ = 0;  // ticks until they are all there
  bool gently_ = false;                // the next change takes the time of a release
  bool changed_ = false;
  float motion_angle_ = 0;  // rad, of this tick
  float last_nm_ = 0;
  core::Fade residual_;
};

}  // namespace torsio::device::game
