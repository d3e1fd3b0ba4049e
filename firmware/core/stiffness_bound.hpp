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
  std::uint32_t slow_ticks = 0;     // no swing that lives on a wrong guess takes longer
  float quiet_share = 1;            // of it with which a count switches less than friction holds
  std::uint32_t flicker_ticks = 0;  // counts that change more slowly are no flicker
  std::uint32_t noise_ticks = 0;    // a shorter one may be the encoder's noise under a slow hand
  float held_nm = 0;                // a knob that is let off may rest against this much
  std::int32_t turn_counts = std::numeric_limits<std::int32_t>::max();
  std::int32_t spin_counts = std::numeric_limits<std::int32_t>::max();  // from look to look
};

/// Share of the stable stiffness.
inline constexpr float kFirstStiffness = 3.0F;

/// Share of the stable stiffness: no swing lasts where the torque rises no more steeply along the
/// swing, unless the device has wrong values.
inline constexpr float kSoft = 1.0F / 3;

/// More than a turn, and few enough to be multiplied by 8.
inline constexpr std::int32_t kManyCounts = 1 << 27;

/// How often a hand is looked for.
inline constexpr std::uint32_t kLookTicks = 256;

/// Few hands turn a knob as fast for more than a turn.
inline constexpr float kSpinRadPerS = 20.0F;

/// A wall under a leaning hand can be several times as stiff as a free spring. So the bound begins
/// well above the stable stiffness and comes down when it must. One count switches no more than
/// half the motor.
/// @param friction_nm dry friction of the knob. A torque that changes by no more from count to
///                    count leaves a knob at rest where it is
constexpr BoundParams make_bound_params(const StableStiffness& stable, const Resolution& resolution,
                                        float motor_torque_max_nm, float friction_nm) {
  BoundParams params;
  params.slope_nm_per_count =
      smaller(kFirstStiffness * stable.stiffness_nm_per_rad * resolution.rad_per_count,
              0.5F * motor_torque_max_nm);
  params.buzz_ticks = round_to_u32(0.04F / resolution.period_s);
  params.slow_ticks = round_to_u32(0.15F / resolution.period_s);
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
  float share = 1;                  // of the first bound that is left
  float trust = 1;                  // share of the assumed spring torque that the motor may take up
  bool spun = false;                // it is less, for the knob spins
  std::uint32_t even_swings = 0;    // as slow as a hand's, in a row that did not get smaller
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
  float outer_begin_nm = 0;  // where the line begins that this one lies in
  float outer_counts = 0;    // this one's begin from there; 0: it lies in none
  float absorbed = 0;        // N m counts, by what was given since the outermost line began
  float in_time_nm = 0;      // its part that does not come from the knob's motion
  bool rang_up = false;  // which way the sensed torque last went beyond what the motor may take up
  std::uint32_t rings = 0;      // in a row that it did so to and fro
  std::uint32_t ring_tick = 0;  // of the last one
};

/// Two energies are equal if they differ by less: they are rounded.
inline constexpr float kEnough = 1.01F;

/// Compares with nothing.
inline constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

/// The scene's torque at the last tick.
constexpr float asked_torque(const BoundState& state) {
  return state.on_line ? state.asked_nm : state.last_nm;
}

/// A swing of no more than this may hide a turn from the encoder, and so seem to last.
inline constexpr std::int32_t kNarrowCounts = 6;

/// So many swings in a row that get smaller are a swing that dies. A lasting one may be wide and
/// narrow by turns.
inline constexpr std::uint32_t kFading = 6;

/// So many slow swings in a row that did not get smaller and no hand makes them.
inline constexpr std::uint32_t kEven = 16;

/// So many swings in a row that did not get smaller come from no push.
inline constexpr std::uint32_t kUnexpected = 4;

/// So many changes of the count in a row are a flicker and no step of a hand.
inline constexpr std::uint32_t kFlickers = 8;

/// So many changes of side in a row and the sensor rings.
inline constexpr std::uint32_t kRings = 8;

constexpr void set_share(BoundState& state, float share) {
  state.share = share;
  state.slope_nm_per_count = state.params.slope_nm_per_count * share;
}

/// Takes off so much that a swing loses, and not all of what a hand feels.
constexpr void soften(BoundState& state, float least_share) {
  set_share(state, smaller(state.share, larger(0.6F * state.share, least_share)));
}

constexpr void distrust(BoundState& state) {
  state.trust = larger(0.6F * state.trust, state.params.least_share);
}

/// Follows the swing that goes on.
/// @returns whether it goes back: then judge_swing()
constexpr bool follow_swing(BoundState& state, std::int32_t delta_counts) {
  state.gone_counts += state.way * delta_counts;
  if (state.gone_counts > state.swing_counts) [[likely]] {
    state.swing_counts = state.gone_counts;
    return false;
  }
  return delta_counts != 0;
}

/// Whether the swing that goes on takes longer. A knob that rested in it was not moved by a hand.
constexpr bool is_slower(const BoundState& state, std::uint32_t now, std::uint32_t ticks) {
  const bool narrow = state.swing_counts <= kNarrowCounts;
  if (narrow && state.flickered) return false;
  return now - state.turned_tick > (narrow ? 4 : 1) * ticks;
}

/// The stiffest bound that still leads the knob back to where the line begins: a stiffer one would
/// leave it inside a wall, and the next press would begin there.
constexpr float most_share(const BoundState& state) {
  if (!state.on_line) return 1.0F;
  const float risen_nm = absolute(state.line_nm - state.begin_nm);
  const float most_nm = state.params.slope_nm_per_count * absolute(state.line_counts);
  return risen_nm < most_nm ? larger(state.share, risen_nm / most_nm) : 1.0F;
}

/// Whether the knob swings as slowly as a hand would, but on and on. One that rests or goes on one
/// way for long has done with it.
constexpr bool swings_evenly(const BoundState& state, std::uint32_t now) {
  return state.even_swings >= kEven && now - state.turned_tick < 10 * state.params.slow_ticks;
}

/// After a swing as slow as a hand's the bound begins anew. The trust does if no swing of the
/// knob's own is as slow.
/// @returns whether it was a hand's
constexpr bool begin_touch(BoundState& state, std::uint32_t now) {
  if (!is_slower(state, now, state.params.buzz_ticks)) return false;
  set_share(state, most_share(state));
  if (is_slower(state, now, state.params.slow_ticks) && !swings_evenly(state, now))
    state.trust = 1.0F;
  return true;
}

/// A flung knob turns for ever if the motor takes off more than there is. So the trust goes while
/// it spins. It comes back at half the speed, in steps that a hand hardly feels.
constexpr void watch_spin(BoundState& state) {
  const std::int32_t way_counts = state.swing_counts - state.looked_counts;
  const std::int32_t spin_counts = state.params.spin_counts;
  if (way_counts > spin_counts && state.swing_counts > state.params.turn_counts) {
    state.spun = true;
    distrust(state);
  } else if (state.spun && way_counts <= spin_counts / 2) {
    state.trust = smaller(state.trust + 1.0F / 16, 1.0F);
    state.spun = state.trust < 1.0F;
  }
  if (state.swing_counts >= kManyCounts) {  // further on it would overflow
    state.gone_counts -= kManyCounts / 2;
    state.swing_counts -= kManyCounts / 2;
    state.flicker_counts = state.swing_counts;
  }
  state.looked_counts = state.swing_counts;
}

/// A knob that goes on is led by a hand.
/// @returns whether it does so
constexpr bool goes_on(BoundState& state, std::uint32_t now) {
  if (state.swing_counts - state.flicker_counts <= kRestCounts) return false;
  if (!state.spun) begin_touch(state, now);
  state.flickers = 0;
  state.flicker_counts = state.swing_counts;
  return true;
}

/// Once a hand has let off, friction alone holds the knob. The next press is a new touch, and its
/// line begins here.
constexpr void let_off(BoundState& state, std::uint32_t now) {
  const float risen_nm = state.line_nm - state.begin_nm;
  const bool outwards = static_cast<float>(state.way) * asked_torque(state) > 0.0F;
  if (!outwards || state.flickered || absolute(risen_nm) > state.params.held_nm) return;
  if (!begin_touch(state, now)) return;
  set_share(state, 1.0F);
  state.line_counts = -risen_nm / state.slope_nm_per_count;
  state.rest_counts = absolute(state.line_counts);
}

/// Out of line, for that is rare.
[[gnu::noinline]] constexpr void watch_hand(BoundState& state, std::uint32_t now) {
  watch_spin(state);
  if (state.share == 1.0F || state.spun) return;
  goes_on(state, now);
  let_off(state, now);
}

/// The count has changed and changed back. A knob that does so for ever is driven from count to
/// count by the torque that a count switches. That is made less than friction holds. The trust is
/// left alone: it leaps, and a soft hand would follow as if it touched the knob anew.
/// @returns whether the count flickers still: it may be noise or the sensor's steps, and is held
constexpr bool judge_flicker(BoundState& state, std::uint32_t now) {
  if (!goes_on(state, now) && now - state.flicker_tick > state.params.flicker_ticks) {
    state.flickers = 0;
    state.flicker_counts = state.swing_counts;
  }
  if (state.flickers == 0) state.flicker_begin = now;
  state.flicker_tick = now;
  ++state.flickers;
  if (state.flickers == kFlickers) state.calm = larger(0.6F * state.calm, state.params.least_share);
  if (state.flickers < kFlickers || now - state.flicker_begin < state.params.noise_ticks)
    return false;
  state.flickers = 0;
  state.flickered = true;
  if (state.share <= state.params.quiet_share) return true;
  soften(state, state.params.quiet_share);
  return false;
}

/// Whether the parts can render the scene along the swing that has ended, as they are configured.
constexpr bool could_have_rendered(const BoundState& state, std::int32_t width_counts) {
  const float risen_nm = absolute(asked_torque(state) - state.turned_nm);
  const float most_nm_per_count = kSoft / kFirstStiffness * state.params.slope_nm_per_count;
  return !state.was_bounded && state.in_time_nm == 0.0F &&
         risen_nm < most_nm_per_count * static_cast<float>(width_counts);
}

/// The sensed torque is more than the motor may take up. A sensor that rings so, quickly and for
/// long, is kept ringing by the motor's answers. The knob need not swing: it may be dragged on one
/// way, or by less than a swing. Out of line, for that is rare.
[[gnu::noinline]] constexpr void judge_ringing(BoundState& state, float spring_nm,
                                               std::uint64_t tick) {
  const bool up = spring_nm > 0.0F;
  if (up == state.rang_up) return;
  const auto now = static_cast<std::uint32_t>(tick);
  if (now - state.ring_tick > state.params.buzz_ticks) state.rings = 0;
  state.rang_up = up;
  state.ring_tick = now;
  if (++state.rings <= kRings) return;
  distrust(state);
  // In a stiffer scene right values may ring so, too.
  const bool soft = could_have_rendered(state, state.swing_counts / 4);
  if (state.rings == kRings + kUnexpected && soft) ++state.unexpected_swings;
}

/// A wide swing without a flicker gives virtual inertia back.
constexpr void calm_down(BoundState& state, std::int32_t width_counts) {
  if (width_counts > kNarrowCounts && state.flickers < kFlickers) state.calm = 1.0F;
}

/// Swings as slow as a hand's cost trust if they go on evenly.
constexpr void judge_slow_swing(BoundState& state, std::uint32_t now, std::int32_t width_counts,
                                bool smaller_now) {
  const bool wider_now = width_counts * 7 > (state.widest_counts + 1) * 8;
  state.even_swings = smaller_now || wider_now ? 0 : state.even_swings + 1;
  if (swings_evenly(state, now)) distrust(state);
}

/// The knob goes back. Once it has turned round, looks at the swing that has ended. A swing that is
/// shorter than a hand's and hardly smaller than those before has regained from the device what
/// friction took. So the bound goes down, and with it the motor's part of the spring. In the end
/// that part is less than the friction, and no swing lives on it, whatever was believed of the
/// brake.
/// @returns as judge_flicker()
constexpr bool judge_swing(BoundState& state, std::uint64_t tick) {
  const auto now = static_cast<std::uint32_t>(tick);
  if (state.swing_counts - state.gone_counts <= kRestCounts) return judge_flicker(state, now);
  const bool slow = is_slower(state, now, state.params.slow_ticks);
  const bool by_hand = begin_touch(state, now);
  const std::int32_t width = state.swing_counts;
  calm_down(state, width);
  state.turned_tick = now;
  state.way = -state.way;
  state.swing_counts -= state.gone_counts;
  state.gone_counts = state.flicker_counts = state.swing_counts;
  const bool could_render = could_have_rendered(state, width);
  state.was_bounded = state.bounded;
  state.turned_nm = asked_torque(state);
  state.flickered = false;
  // A swing may look a count wider or narrower than it is.
  const bool smaller_now = (width + 1) * 8 < state.widest_counts * 7;
  if (slow) judge_slow_swing(state, now, width, smaller_now);
  if (slow || (smaller_now && ++state.fading >= kFading)) {
    state.swings = state.fading = 0;
    state.widest_counts = width;
    return false;
  }
  if (smaller_now) {
    state.widest_counts -= state.widest_counts / 8;
    return false;
  }
  state.fading = 0;
  if (width > state.widest_counts) state.widest_counts = width;
  if (++state.swings < 2) return false;
  if (!by_hand) {
    // A push may make the first ones.
    if (could_render && state.swings >= kUnexpected) ++state.unexpected_swings;
    soften(state, state.params.least_share);
  }
  distrust(state);
  return false;
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
