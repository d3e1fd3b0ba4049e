/// @file
/// Bounded stiffness: the scene's torque may rise along the angle only as steeply as the parts can
/// render. The knob's swings tell how steeply (docs/explanation/theory.md, "Bounded stiffness").
#pragma once

#include <cstdint>
#include <limits>

#include "core/angle.hpp"
#include "core/math.hpp"
#include "core/motion.hpp"
#include "core/stability.hpp"

namespace torsio::core {

struct BoundParams {
  float slope_nm_per_count = 0;     // of the stiffness that a touch begins with
  float least_share = 1.0F / 64;    // of it that is always left
  std::uint32_t buzz_ticks = 0;     // a swing that takes longer is a hand's
  std::uint32_t slow_ticks = 0;     // few swings that live on a wrong guess take longer
  float quiet_share = 1;            // of it with which a count switches less than friction holds
  std::uint32_t flicker_ticks = 0;  // counts that change more slowly are no flicker
  std::uint32_t noise_ticks = 0;    // a shorter one may be the encoder's noise under a slow hand
  float swing_nm = 0;               // that moves the knob's inertia by a count a tick in a tick
  float held_nm = 0;                // a knob that is let off may rest against this much
  std::int32_t turn_counts = std::numeric_limits<std::int32_t>::max();
  std::int32_t spin_counts = std::numeric_limits<std::int32_t>::max();  // from look to look
  float damping_nm_s_per_rad = 0;  // the most that dampers give, while nothing has swung
  bool flywheel = false;           // the scene has virtual inertia
};

/// Share of the stable stiffness.
inline constexpr float kFirstStiffness = 3.0F;

/// A torque that changes by less than this share is nearly the same.
inline constexpr float kNearly = 0.25F;

/// How often a hand is looked for.
inline constexpr std::uint32_t kLookTicks = 256;

/// Few hands turn a knob as fast beyond a quarter turn.
inline constexpr float kSpinRadPerS = 20.0F;

/// After a ring the sensor does without the brake's inertia for so many turns, and for twice as
/// many after each ring more.
inline constexpr std::uint32_t kFirstDoubt = 64;
inline constexpr std::uint32_t kMostDoubt = 2048;

/// A wall under a leaning hand can be several times as stiff as a free spring. So the bound begins
/// well above the stable stiffness and comes down when it must. One count switches no more than
/// half the motor, if the motor moves the knob at all.
/// @param damping_nm_s_per_rad that is stable
/// @param inertia_kg_m2        of the knob
/// @param friction_nm   dry friction of the knob. A torque that changes by no more from count to
///                      count leaves a knob at rest where it is
constexpr BoundParams make_bound_params(const StableStiffness& stable, float damping_nm_s_per_rad,
                                        const Resolution& resolution, float motor_torque_max_nm,
                                        float inertia_kg_m2, float friction_nm) {
  BoundParams params;
  params.damping_nm_s_per_rad = damping_nm_s_per_rad;
  params.slope_nm_per_count =
      kFirstStiffness * stable.stiffness_nm_per_rad * resolution.rad_per_count;
  if (moves_knob(motor_torque_max_nm, friction_nm)) {
    params.slope_nm_per_count = smaller(params.slope_nm_per_count, 0.5F * motor_torque_max_nm);
  }
  params.buzz_ticks = round_to_u32(0.04F / resolution.period_s);
  params.slow_ticks = round_to_u32(0.15F / resolution.period_s);
  params.swing_nm =
      inertia_kg_m2 * resolution.rad_per_count / (resolution.period_s * resolution.period_s);
  params.quiet_share =
      smaller(larger(friction_nm / params.slope_nm_per_count, params.least_share), 1.0F);
  params.flicker_ticks = round_to_u32(1.0F / resolution.period_s);
  params.noise_ticks = round_to_u32(0.05F / resolution.period_s);
  params.held_nm = 1.5F * friction_nm;
  params.turn_counts = static_cast<std::int32_t>(kTwoPi / resolution.rad_per_count);
  params.spin_counts = static_cast<std::int32_t>(kSpinRadPerS * resolution.period_s * kLookTicks /
                                                 resolution.rad_per_count);
  return params;
}

/// For a scene with virtual inertia: a flywheel may spin, and swings more slowly.
constexpr void add_inertia(BoundParams& params, const Resolution& resolution, float inertia_kg_m2) {
  params.flywheel = true;
  params.spin_counts = std::numeric_limits<std::int32_t>::max();
  params.swing_nm +=
      inertia_kg_m2 * resolution.rad_per_count / (resolution.period_s * resolution.period_s);
}

struct BoundState {
  BoundParams params;              // as they were when the scene was new
  float last_nm = 0;               // asked at the last tick; while `on_line` no number
  float slope_nm_per_count = 0;    // `share` of that in `params`
  std::int32_t way = 1;            // 1 or -1, of the swing that goes on
  std::int32_t gone_counts = 0;    // along it by now
  std::int32_t swing_counts = 0;   // its length, 0 to 2 more than `gone_counts`
  std::int32_t widest_counts = 0;  // of the swings before that did not get smaller
  std::uint32_t swings = 0;        // in a row that did not get smaller
  std::uint32_t fading = 0;        // swings in a row that did
  std::uint32_t turned_tick = 0;
  std::uint32_t flickers = 0;       // changes of the count in a row within what counts as rest
  bool flickered = false;           // in the swing that goes on, at rest
  std::uint32_t flicker_tick = 0;   // of the last change
  std::uint32_t flicker_begin = 0;  // tick of the first
  std::int32_t flicker_counts = 0;  // how far the swing had come when they began
  std::int32_t looked_counts = 0;   // the same, at the last look
  std::int32_t rested_counts = 0;   // the same at the last rest; < 0: before that many and a turn
  std::uint32_t moved_tick = 0;     // of the last look that saw it move on
  std::uint32_t rested_tick = 0;    // of the first since it rested or turned
  std::int32_t rattles = 0;         // changes of the count to and fro, less the counts it went on
  float share = 1;                  // of the first bound that is left
  float trust = 1;                  // share of the assumed spring torque that the motor may take up
  bool spun = false;                // it is less, for the knob has spun, and not rested since
  float calm = 1;                   // share of virtual inertia that does not make a count flicker
  float drag_nm = 0;                // of the brake's, that it takes up: follow_drag()
  bool on_line = false;             // `line_nm` is followed too, beside the asked torque
  bool bounded = false;             // less is given than the scene asks
  bool was_bounded = false;         // somewhere in the swing that goes on
  float turned_nm = 0;              // asked at the last turn
  std::uint32_t unexpected_swings = 0;  // that lasted in scenes that the parts could render
  bool new_scene = true;                // the next change does not come from the knob's motion
  float asked_nm = 0;                   // at the last tick: while `on_line`
  float line_nm = 0;      // the torque of the spring that bounds, which may be beyond what is asked
  float begin_nm = 0;     // where it begins
  float line_counts = 0;  // the knob's way from there
  float rest_counts = 0;  // the same, less what may be a flicker
  float outer_begin_nm = 0;      // where the line begins that this one lies in
  float outer_counts = 0;        // this one's begin from there; 0: it lies in none
  float absorbed = 0;            // N m counts, by what was given since the outermost line began
  float in_time_nm = 0;          // its part that does not come from the knob's motion
  std::uint32_t slides = 0;      // changes in a row from more than the brake's capacity to less
  bool slid_up = false;          // which of them was last
  std::uint32_t slide_tick = 0;  // of that change
  float slide_nm = 0;            // asked when they began
  float speed_counts = 0;        // in a tick, along the way, in the mean of a swing
  float slide_counts = 0;        // the same once the changes are enough
  bool rang_up = false;  // which way the sensed torque last went beyond what the motor may take up
  std::uint32_t rings = 0;      // in a row that it did so to and fro
  std::uint32_t ring_tick = 0;  // of the last one
  std::uint32_t doubt = 0;      // turns for which the sensor does without the brake's inertia
  std::uint32_t next_doubt = kFirstDoubt;  // as many after the next ring
  std::uint32_t turns = 0;  // where the parts could render, since the last of `unexpected_swings`
  std::uint32_t timed_tick = 1U << 31;     // when `in_time_nm` last changed; as yet long ago
  std::uint32_t streamed_tick = 1U << 31;  // when a host last changed what it streams
  bool shaken = false;                     // it changed while a swing was judged
  std::int32_t pushes = 0;                 // looks that drove this swing, twice, less braking ones
};

/// Two energies are equal if they differ by less: they are rounded.
inline constexpr float kEnough = 1.01F;

/// Compares with nothing.
inline constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

/// The scene's torque at the last tick.
constexpr float asked_torque(const BoundState& state) {
  return state.on_line ? state.asked_nm : state.last_nm;
}

constexpr void set_share(BoundState& state, float share) {
  state.share = share;
  state.slope_nm_per_count = state.params.slope_nm_per_count * share;
}

/// The stiffest bound that still leads the knob back to where the line begins: a stiffer one would
/// leave it inside a wall, and the next press would begin there.
[[gnu::noinline]] constexpr float most_share(const BoundState& state) {
  if (!state.on_line) return 1.0F;
  const float risen_nm = absolute(state.line_nm - state.begin_nm);
  const float most_nm = state.params.slope_nm_per_count * absolute(state.line_counts);
  return risen_nm < most_nm ? larger(state.share, risen_nm / most_nm) : 1.0F;
}

/// Of two torques of one sign.
constexpr float smaller_torque(float line_nm, float asked_nm) {
  return absolute(line_nm) < absolute(asked_nm) ? line_nm : asked_nm;
}

/// The way out leads straight back to where the line begins, however the way in was bent. Near
/// where the knob was deepest it is as soft as the bound, for the knob may rest there. It gives no
/// more energy than the way in took: with too little, the torque falls with a power of what is left
/// of the way.
constexpr float way_out(BoundState& state, float spring_nm, float moved_counts) {
  const float left_counts = absolute(state.line_counts + moved_counts) + kRestCounts;
  if (left_counts >= state.rest_counts) return spring_nm;
  state.rest_counts = left_counts;
  const float share = moved_counts / state.line_counts;  // < 0
  const float chord_nm = (state.line_nm - state.begin_nm) * share;
  if (state.outer_counts != 0.0F) return chord_nm;
  const float gave_nm = smaller_torque(state.line_nm, state.asked_nm);
  const float chord = 0.5F * absolute((gave_nm + state.begin_nm) * state.line_counts);
  if (chord <= kEnough * state.absorbed) return chord_nm;
  const float power = absolute(gave_nm * state.line_counts) / larger(state.absorbed, 1e-9F) - 1.0F;
  return state.line_nm * larger(power * share, -1.0F);
}

/// A line begins within another, or within the one that its own lies in.
constexpr void nest(BoundState& state) {
  if (state.outer_counts == 0.0F) state.outer_begin_nm = state.begin_nm;
  state.outer_counts += state.line_counts;
}

/// The outermost line goes on where an inner one ends.
/// @returns whether there is one
constexpr bool unnest(BoundState& state) {
  if (state.outer_counts == 0.0F) return false;
  state.begin_nm = state.outer_begin_nm;
  state.line_counts += state.outer_counts;
  state.rest_counts = absolute(state.line_counts);
  state.outer_counts = 0.0F;
  return true;
}

/// Where the scene's torque changes its sign all begins anew.
constexpr void cross_zero(BoundState& state, float before_nm, float asked_nm) {
  if (!(before_nm * asked_nm < 0.0F)) return;  // NaN changes none
  state.begin_nm = state.line_counts = state.rest_counts = 0.0F;
  state.outer_counts = state.absorbed = 0.0F;
}

/// Whether the line goes on. Where the scene is steep again it begins anew, if it is beyond.
constexpr bool continues(const BoundState& state, float before_nm, float excess_nm,
                         float spring_nm) {
  const bool beyond = absolute(state.line_nm) > absolute(before_nm);
  return state.on_line && !(beyond && excess_nm * spring_nm > 0.0F);
}

/// A line begins: within the other, if there is one.
constexpr void begin_line(BoundState& state, float before_nm) {
  if (state.on_line) {
    nest(state);
  } else {
    state.outer_counts = state.absorbed = 0.0F;
  }
  state.begin_nm = before_nm;
  state.line_counts = state.rest_counts = 0.0F;
}

/// Whether the knob is back where the line began, and the scene asks for no more than the bound
/// allows from there.
constexpr bool ends(const BoundState& state, float asked_nm, float line_nm, float moved_counts) {
  const float begin_nm = absolute(state.begin_nm);
  const float past_counts = smaller(absolute(state.line_counts), absolute(moved_counts));
  const float past_nm = state.slope_nm_per_count * (past_counts + 0.1F);
  return state.line_counts * asked_nm >= 0.0F && moved_counts != 0.0F &&
         absolute(line_nm) > 0.99F * begin_nm && absolute(asked_nm) < begin_nm + past_nm;
}

/// The allowed torque once the scene's torque has changed more steeply than the bound. It changes
/// by the part that follows time, and by the torque of a spring as stiff as the bound for this
/// tick's motion. It never has the other sign, and never exceeds the scene's torque. Torque that
/// was left out is never added at rest: that would be energy from nowhere. The spring's line goes
/// on beyond the scene's torque, so the way back meets that torque at the same place. Otherwise the
/// way back would give what the way in left out. The line ends where it began. Out of line: a clean
/// wall never comes here.
[[gnu::noinline]] constexpr float follow_bound(BoundState& state, float asked_nm, float timed_nm,
                                               float moved_counts) {
  const float spring_nm = -state.slope_nm_per_count * moved_counts;
  const float before_nm = state.on_line ? state.asked_nm : state.last_nm;
  const float excess_nm = asked_nm - before_nm - timed_nm - spring_nm;
  float line_nm = before_nm;
  float way_nm = spring_nm;
  if (continues(state, before_nm, excess_nm, spring_nm)) {
    line_nm = state.line_nm;
    way_nm = way_out(state, spring_nm, moved_counts);
  } else {
    begin_line(state, before_nm);
  }
  const float gave_nm = smaller_torque(line_nm, before_nm) + timed_nm;
  state.begin_nm += timed_nm;
  state.outer_begin_nm += timed_nm;
  state.absorbed -= timed_nm * (state.outer_counts + state.line_counts);
  state.line_counts += moved_counts;
  state.rest_counts = larger(state.rest_counts, absolute(state.line_counts));
  const bool is_back = ends(state, asked_nm, line_nm + timed_nm, moved_counts);
  line_nm += timed_nm + way_nm;
  if (is_back) line_nm = state.begin_nm;
  const bool is_over = is_back && !unnest(state);
  if (line_nm * asked_nm <= 0.0F) line_nm = 0.0F;
  cross_zero(state, before_nm, asked_nm);
  // A torque that is not finite is a fault. The bound must not keep it.
  if (is_over || !is_finite(asked_nm + line_nm)) line_nm = asked_nm;
  const float given_nm = smaller_torque(line_nm, asked_nm);
  state.absorbed -= 0.5F * (gave_nm + given_nm) * moved_counts;
  state.asked_nm = asked_nm;
  state.line_nm = line_nm;
  state.on_line = is_finite(asked_nm) && asked_nm != 0.0F && !is_over;
  state.bounded = given_nm != asked_nm;
  state.was_bounded = state.was_bounded || state.bounded;
  state.last_nm = state.on_line ? kNoNumber : asked_nm;
  return given_nm;
}

/// A change that a host makes passes: a line of the scene before would not end in this one. The
/// same scene, or nearly, keeps its line while less is given than asked.
constexpr void begin_scene(BoundState& state, float asked_nm) {
  state.new_scene = false;
  const float before_nm = asked_torque(state);
  if (state.bounded && absolute(asked_nm - before_nm) < kNearly * absolute(before_nm)) return;
  state.on_line = state.bounded = false;
  state.last_nm = asked_nm;
}

/// One tick, after the swing has been followed: compares the change of the asked torque with a
/// spring as stiff as the bound.
/// @param asked_nm  the scene's torque
/// @param timed_nm  how much of its change comes from time, not from the knob's motion
/// @returns the torque that may be given: of the same sign, and not more
constexpr float bound_stiffness(BoundState& state, float asked_nm, float timed_nm,
                                std::int32_t delta_counts) {
  const float moved_counts = static_cast<float>(delta_counts);
  const float spring_nm = -state.slope_nm_per_count * moved_counts;
  const float excess_nm = asked_nm - state.last_nm - timed_nm - spring_nm;
  // Not "< 0": NaN is not gentle either.
  const bool gentle = excess_nm * moved_counts >= 0.0F;
  if (!gentle) [[unlikely]]
    return follow_bound(state, asked_nm, timed_nm, moved_counts);
  state.last_nm = asked_nm;
  return asked_nm;
}

}  // namespace torsio::core
