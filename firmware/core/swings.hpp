/// @file
/// What the bound learns from the knob's motion: its swings, flickers and spins, and a sensor that
/// rings, take from share and trust. A hand, or a rest, gives them back
/// (docs/explanation/theory.md, "Bounded stiffness").
#pragma once

#include <cstdint>

#include "core/math.hpp"
#include "core/motion.hpp"
#include "core/stiffness_bound.hpp"

namespace torsio::core {

/// Share of the stable stiffness: no swing lasts where the torque rises no more steeply along the
/// swing, unless the device has wrong values.
inline constexpr float kSoft = 1.0F / 3;

/// More than a turn, and few enough to be multiplied by 8.
inline constexpr std::int32_t kManyCounts = 1 << 27;

/// A swing of no more than this may hide a turn from the encoder, and so seem to last.
inline constexpr std::int32_t kNarrowCounts = 6;

/// So many swings in a row that get smaller are a swing that dies. A lasting one may be wide and
/// narrow by turns.
inline constexpr std::uint32_t kFading = 6;

/// So many swings in a row that did not get smaller come from no push.
inline constexpr std::uint32_t kUnexpected = 4;

/// With right values, less than one turn in so many begins a swing that lasts.
inline constexpr std::uint32_t kExpectedTurns = 50;

/// A knob that goes on for so many slow swings without a rest may be driven by a wrong guess.
inline constexpr std::uint32_t kCreeps = 128;

/// By so many its trust has been gone for long. If it goes on still, a hand leads it.
inline constexpr std::uint32_t kLed = 136;

/// So many changes of the count in a row are a flicker and no step of a hand.
inline constexpr std::uint32_t kFlickers = 8;

/// So many changes of the count to and fro, less the counts that the knob went on, and virtual
/// inertia drives it.
inline constexpr std::int32_t kRattles = 8;

/// So many changes of side in a row and the sensor rings.
inline constexpr std::uint32_t kRings = 8;

/// So many changes in a row from more than the brake's capacity to less and the brake swings on the
/// shaft's spring while it slips.
inline constexpr std::uint32_t kSlides = 24;

/// By so many swings in a row little trust is left. What swings on even in a scene that is hardly
/// steep needs less stiffness, too.
inline constexpr std::uint32_t kDistrusted = 16;

/// A hand may notice a torque that trembles by more.
inline constexpr float kNoticedNm = 1e-3F;

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

/// Whether the knob comes back as if nobody held it. It may do so slowly over an eighth of a turn,
/// as a flywheel, or while the brake's inertia is in doubt. Else a hand moves it. The scene has
/// driven it at more than a third of the looks, which no friction does. A constant torque M swings
/// it over w within sqrt(4 w J / M), a spring within 1.1 times that. M is the less of both ends',
/// for a wall may throw the knob back. Of M a quarter to twice will do.
[[gnu::noinline]] constexpr bool swings_freely(const BoundState& state, std::uint32_t now) {
  if (state.pushes <= 0) return false;
  const bool wide = state.params.flywheel || 8 * state.swing_counts >= state.params.turn_counts;
  if (state.doubt == 0 && !wide) return false;
  const auto ticks = static_cast<float>(now - state.turned_tick);
  const float took_nm = state.params.swing_nm * static_cast<float>(state.swing_counts);
  const float back_nm =
      smaller(-static_cast<float>(state.way) * asked_torque(state), absolute(state.turned_nm)) *
      ticks * ticks;
  return took_nm > 0.0625F * back_nm && took_nm < 0.5F * back_nm;
}

/// Whether hardly any swing that lives on a wrong guess is as slow.
constexpr bool is_slow(const BoundState& state, std::uint32_t now) {
  return is_slower(state, now, state.params.slow_ticks) && !swings_freely(state, now);
}

/// Whether the knob has gone on for longer than a hand turns it without a rest.
constexpr bool has_crept(const BoundState& state) {
  return state.moved_tick - state.rested_tick > kCreeps * state.params.slow_ticks;
}

/// After a swing as slow as a hand's the bound begins anew. The trust does if no swing of the
/// knob's own is as slow, and the knob has neither spun nor crept.
/// @param slow as is_slow()
/// @returns whether it was a hand's
constexpr bool begin_touch(BoundState& state, std::uint32_t now, bool slow) {
  if (!is_slower(state, now, state.params.buzz_ticks)) return false;
  set_share(state, most_share(state));
  if (slow && !has_crept(state) && !state.spun) state.trust = 1.0F;
  return true;
}

/// Whether the knob has not moved on for as long as no swing lasts that lives on a wrong guess.
constexpr bool has_rested(const BoundState& state, std::uint32_t now) {
  const std::uint32_t least_ticks =
      state.params.slow_ticks > kLookTicks ? state.params.slow_ticks : kLookTicks;
  return now - state.moved_tick > least_ticks;
}

/// Few hands turn a knob on for as long without a rest. A motor that takes off more than there is
/// may drive it. So the trust goes, and the knob rests until a hand moves it anew. One that goes on
/// without the trust is led by a hand, and no longer watched so.
constexpr bool creeps(BoundState& state, bool rested, std::int32_t way_counts, std::uint32_t now) {
  if (way_counts > 0) {
    const bool led = state.moved_tick - state.rested_tick > kLed * state.params.slow_ticks;
    if (rested || led) state.rested_tick = now;
    state.moved_tick = now;
  }
  return has_crept(state) && way_counts <= state.params.spin_counts / 4;
}

/// Whether the scene takes more off the knob's motion than wrong guesses add.
/// @param along_nm the scene's torque along the knob's way
constexpr bool brakes(const BoundState& state, float along_nm) {
  return along_nm < -state.params.held_nm;
}

/// Whether the scene has braked the knob for some slow swings, while it turned on.
constexpr bool is_led(const BoundState& state, float along_nm, std::int32_t way_counts,
                      std::uint32_t now) {
  return brakes(state, along_nm) && way_counts > 0 &&
         is_slower(state, now, 4 * state.params.slow_ticks);
}

/// Counts the looks at which the scene drives the swing, twice, less those at which it brakes.
constexpr void count_push(BoundState& state, float along_nm) {
  if (along_nm > 0.0F) state.pushes += 2;
  if (along_nm < 0.0F) --state.pushes;
}

/// A flung knob turns for ever if the motor takes off more than there is. So the trust goes while
/// it spins: beyond a quarter turn, and from the fifth on at a quarter of the speed. The trust
/// comes back in steps that a hand hardly feels: at rest, without inertia, or under a hand that
/// turns on against the scene.
constexpr void judge_way(BoundState& state, std::int32_t way_counts, std::uint32_t now) {
  const bool far = state.swing_counts / 4 > state.params.turn_counts;
  const std::int32_t spin_counts = far ? state.params.spin_counts / 4 : state.params.spin_counts;
  const bool fast = way_counts > spin_counts && state.swing_counts > state.params.turn_counts / 4;
  const float along_nm = static_cast<float>(state.way) * asked_torque(state);
  count_push(state, along_nm);
  const bool rested = has_rested(state, now);
  if (creeps(state, rested, way_counts, now)) {
    distrust(state);
  } else if (fast && !brakes(state, along_nm)) {
    state.spun = true;
    distrust(state);
  } else if ((state.spun && rested) || state.slides >= kSlides ||
             is_led(state, along_nm, way_counts, now)) {
    state.trust = smaller(state.trust + 1.0F / 16, 1.0F);
    state.spun = state.spun && state.trust < 1.0F;
  }
}

/// Looks at the way since the last look.
constexpr void watch_spin(BoundState& state, std::uint32_t now) {
  const std::int32_t way_counts = state.swing_counts - state.looked_counts;
  judge_way(state, way_counts, now);
  if (state.swing_counts >= kManyCounts) {  // further on it would overflow
    state.gone_counts -= kManyCounts / 2;
    state.swing_counts -= kManyCounts / 2;
    state.rested_counts =
        state.rested_counts > kManyCounts / 2 ? state.rested_counts - kManyCounts / 2 : 0;
    state.flicker_counts = state.swing_counts;
  }
  if (way_counts == 0 && now - state.turned_tick >= kLookTicks)
    state.rested_counts = state.swing_counts;
  state.looked_counts = state.swing_counts;
}

/// Share of the help in free air. If the friction is told too large, help may turn the knob for
/// ever, to and fro too, or swing it on the shaft's spring. So it ends after four turns without a
/// rest, whichever way, and has no more trust than the sensor.
constexpr float help_share(const BoundState& state) {
  const float turns = static_cast<float>(state.swing_counts - state.rested_counts) /
                      static_cast<float>(state.params.turn_counts);
  return state.trust * smaller(larger(2.0F - 0.5F * turns, 0.0F), 1.0F);
}

/// A knob that goes on is led by a hand.
/// @returns whether it does so
constexpr bool goes_on(BoundState& state, std::uint32_t now) {
  const std::int32_t way_counts = state.swing_counts - state.flicker_counts;
  if (way_counts <= kRestCounts) return false;
  if (!state.spun) begin_touch(state, now, is_slow(state, now));
  state.rattles = state.rattles > way_counts ? state.rattles - way_counts : 0;
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
  if (!begin_touch(state, now, is_slow(state, now))) return;
  set_share(state, 1.0F);
  state.line_counts = -risen_nm / state.slope_nm_per_count;
  state.rest_counts = absolute(state.line_counts);
}

/// Once the scene shakes the knob no longer, it may have been the scene that did it. Where less is
/// given than asked, the line stays as it is.
constexpr void forgive(BoundState& state, std::uint32_t now) {
  if (!state.shaken || now - state.timed_tick <= state.params.slow_ticks) return;
  state.shaken = false;
  if (state.bounded) return;
  set_share(state, most_share(state));
  state.trust = 1.0F;
}

/// Out of line, for that is rare.
[[gnu::noinline]] constexpr void watch_hand(BoundState& state, std::uint32_t now) {
  watch_spin(state, now);
  forgive(state, now);
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
    state.flickers = state.rattles = 0;
    state.flicker_counts = state.swing_counts;
  }
  if (state.flickers == 0) state.flicker_begin = now;
  state.flicker_tick = now;
  ++state.flickers;
  if (++state.rattles >= kRattles) {
    state.rattles = 0;
    state.calm = larger(0.6F * state.calm, state.params.least_share);
  }
  if (state.flickers < kFlickers || now - state.flicker_begin < state.params.noise_ticks)
    return false;
  state.flickers = 0;
  state.flickered = true;
  if (state.share <= state.params.quiet_share) return true;
  soften(state, state.params.quiet_share);
  return false;
}

/// Steepness of the scene from turn to turn of the swing that has ended, as a share of a third of
/// the first bound: that is the stable stiffness, or less. It is 1 where less was given than asked,
/// or where the scene follows time or a host.
constexpr float steepness(const BoundState& state, std::int32_t width_counts, std::uint32_t now) {
  const bool streamed = now - state.streamed_tick <= state.params.slow_ticks;
  if (state.was_bounded || streamed || state.in_time_nm != 0.0F) return 1.0F;
  const float risen_nm = absolute(asked_torque(state) - state.turned_nm);
  return kFirstStiffness * risen_nm /
         (state.params.slope_nm_per_count * static_cast<float>(width_counts));
}

/// The sensed torque is more than the motor may take up. A sensor that rings so, quickly and for
/// long, is kept ringing by the motor's answers. The knob need not swing: it may be dragged on one
/// way, or by less than a swing. Hardly anything damps the brake's side, so a small error of its
/// inertia or of the shaft is enough: it is forgotten. Out of line, for that is rare.
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
  if (state.doubt > 0) return;
  state.trust = state.params.least_share;
  state.doubt = state.next_doubt;
  state.next_doubt = state.doubt < kMostDoubt / 2 ? 2 * state.doubt : kMostDoubt;
  // In a stiffer scene right values may ring so, too.
  if (steepness(state, state.swing_counts, now) < kSoft) state.unexpected_swings += kUnexpected;
}

/// A hand turns the knob on against a torque that at most doubles, so the brake slips. It then
/// swings on the shaft's spring. The motor cancels all of that, so nothing damps it, and what is
/// wrong in the model makes it grow. From then on the sensor knows no inertia, until the knob turns
/// back or gets slow, or the scene asks for another torque.
/// @param beyond_nm    sensed against the knob's motion, beyond the brake's capacity
/// @param speed_counts of the knob in a tick, along its way
constexpr void judge_slide(BoundState& state, float beyond_nm, float speed_counts,
                           std::uint64_t tick) {
  const float asked_nm = asked_torque(state);
  const bool same = absolute(asked_nm - state.slide_nm) < absolute(state.slide_nm);
  state.speed_counts += 0.0625F * (speed_counts - state.speed_counts);
  const bool slow = state.slides >= kSlides && state.speed_counts < 0.6F * state.slide_counts;
  if (!same || slow) {
    state.slide_nm = asked_nm;
    state.slides = 0;
  }
  const bool up = beyond_nm > 0.0F;
  if (up == state.slid_up || absolute(beyond_nm) < kNoticedNm) return;
  if (state.swing_counts <= state.params.turn_counts / 24) return;
  const auto now = static_cast<std::uint32_t>(tick);
  state.slides = now - state.slide_tick <= state.params.slow_ticks ? state.slides + 1 : 0;
  if (state.slides == kSlides) state.slide_counts = state.speed_counts;
  state.slid_up = up;
  state.slide_tick = now;
}

/// The knob has turned round. In scenes that the parts can render, every so many turns take an
/// unexpected swing back, so that their number tells of how many more there are than right values
/// give.
constexpr void count_turn(BoundState& state, bool could_render) {
  if (!could_render || ++state.turns < kExpectedTurns) return;
  state.turns = 0;
  if (state.unexpected_swings > 0) --state.unexpected_swings;
}

/// A wide swing without a flicker gives virtual inertia back.
constexpr void calm_down(BoundState& state, std::int32_t width_counts) {
  if (width_counts > kNarrowCounts && state.flickers < kFlickers) state.calm = 1.0F;
}

/// The next swing begins. The way since the last rest goes on.
constexpr void turn_round(BoundState& state, std::uint32_t now) {
  state.turned_tick = state.rested_tick = state.moved_tick = now;
  state.way = -state.way;
  state.rested_counts -= state.gone_counts;
  if (state.rested_counts < -kManyCounts) state.rested_counts = -kManyCounts;
  state.swing_counts -= state.gone_counts;
  state.gone_counts = state.flicker_counts = state.swing_counts;
  state.slides = 0;
  state.pushes = 0;
  if (state.doubt > 0) {
    --state.doubt;
  } else if (state.next_doubt > kFirstDoubt) {
    --state.next_doubt;
  }
}

/// Whether the swing that has ended is hardly smaller than those before. Where it is slow, or they
/// fade, the count begins anew.
constexpr bool is_as_wide(BoundState& state, std::int32_t width, bool slow) {
  // A swing may look a count wider or narrower than it is.
  const bool smaller_now = (width + 1) * 8 < state.widest_counts * 7;
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
  return true;
}

/// Looks at the swing that has ended. One that is not slow and hardly smaller than those before has
/// regained from the device what friction took. So the trust goes down. If it is shorter than a
/// hand's, the bound does, too: at once in a steep scene, else later. In the end the motor's part
/// of the spring is less than the friction, and no swing lives on it. Out of line, for that is
/// rare.
[[gnu::noinline]] constexpr void judge_turn(BoundState& state, std::uint32_t now) {
  const bool slow = is_slow(state, now);
  const bool by_hand = begin_touch(state, now, slow);
  const std::int32_t width = state.swing_counts;
  calm_down(state, width);
  turn_round(state, now);
  const float steep = steepness(state, width, now);
  count_turn(state, steep < kSoft);
  state.was_bounded = state.bounded;
  state.turned_nm = asked_torque(state);
  state.flickered = false;
  if (!is_as_wide(state, width, slow) || ++state.swings < 2) return;
  if (now - state.timed_tick <= state.params.slow_ticks) state.shaken = true;
  distrust(state);
  if (by_hand) return;
  // A push may make the first ones.
  if (steep < kSoft && state.swings >= kUnexpected) ++state.unexpected_swings;
  // A scene that is hardly steep mostly swings by a wrong guess: the trust goes first. A softer
  // detent would let a weight roll over it.
  if (steep >= 1.0F || state.swings >= kDistrusted) soften(state, state.params.least_share);
}

/// The knob goes back.
/// @returns as judge_flicker()
constexpr bool judge_swing(BoundState& state, std::uint64_t tick) {
  const auto now = static_cast<std::uint32_t>(tick);
  if (state.swing_counts - state.gone_counts <= kRestCounts) return judge_flicker(state, now);
  judge_turn(state, now);
  return false;
}

}  // namespace torsio::core
