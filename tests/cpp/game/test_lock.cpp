// The oracle is the rules of the game, as examples/game/README.md tells them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <random>
#include <set>

#include "game/lock.hpp"

namespace {

constexpr float kStep_s = 1.0F / 60;

int pin_of_order(const game::Lock& lock, int order) {
  int pin = 0;
  while (lock.pins[static_cast<std::size_t>(pin)].order != order) ++pin;
  return pin;
}

float shear_of(const game::Lock& lock, int pin) {
  return lock.pins[static_cast<std::size_t>(pin)].shear_lift;
}

void select(game::Lock& lock, int pin) {
  game::step(lock, {0, 0}, kStep_s);
  while (lock.selected != pin) REQUIRE(game::step(lock, {0, 1}, kStep_s) == game::Event::moved);
}

game::Event lift(game::Lock& lock, float lift) { return game::step(lock, {lift, 0}, kStep_s); }

game::Lock with_set_pins(int count) {
  game::Lock lock = game::make_lock(7);
  for (int order = 0; order < count; ++order) {
    const int pin = pin_of_order(lock, order);
    select(lock, pin);
    lift(lock, shear_of(lock, pin) + 0.01F);
  }
  REQUIRE(lock.set_count == count);
  return lock;
}

}  // namespace

TEST_CASE("make_lock gives every order once and shear lines within reach, the same for a seed") {
  std::set<int> first_pins;
  for (std::uint32_t seed = 0; seed < 1000; ++seed) {
    const game::Lock lock = game::make_lock(seed);
    const game::Lock again = game::make_lock(seed);
    std::set<int> orders;
    for (int i = 0; i < game::kPins; ++i) {
      orders.insert(lock.pins[static_cast<std::size_t>(i)].order);
      CHECK(shear_of(lock, i) > game::kLowered);
      CHECK(shear_of(lock, i) + game::kGive < 1);
      CHECK(shear_of(lock, i) == shear_of(again, i));
    }
    CHECK(orders == std::set<int>{0, 1, 2, 3, 4});
    CHECK(pin_of_order(lock, 0) == pin_of_order(again, 0));
    first_pins.insert(pin_of_order(lock, 0));
  }
  CHECK(first_pins.size() == game::kPins);
}

TEST_CASE("a pin sets when it is the one that binds and passes its shear line, not before") {
  game::Lock lock = game::make_lock(7);
  for (const int order : {1, 2, 3, 4}) {
    select(lock, pin_of_order(lock, order));
    CHECK(lift(lock, 1.0F) == game::Event::none);
    CHECK_FALSE(game::is_binding(lock));
  }
  const int pin = pin_of_order(lock, 0);
  select(lock, pin);
  CHECK(lift(lock, shear_of(lock, pin) - 0.01F) == game::Event::none);
  CHECK(game::is_binding(lock));
  CHECK(lift(lock, shear_of(lock, pin) + 0.01F) == game::Event::set);
  CHECK(game::is_set(lock, pin));
}

TEST_CASE("picked in the order of binding, the lock opens when the plug is turned to its end") {
  game::Lock lock = with_set_pins(4);
  const int last = pin_of_order(lock, 4);
  select(lock, last);
  CHECK(lift(lock, shear_of(lock, last) + 0.01F) == game::Event::freed);
  CHECK(lift(lock, 0.9F) == game::Event::none);
  CHECK_FALSE(game::is_open(lock));
  CHECK(lift(lock, 1.0F) == game::Event::opened);
  CHECK(game::is_open(lock));
  CHECK(lift(lock, 0.0F) == game::Event::none);
  CHECK(game::is_open(lock));
  CHECK(lock.dropped == 0);
}

TEST_CASE("the pick moves to another pin only when it is lowered") {
  game::Lock lock = game::make_lock(7);
  CHECK(game::step(lock, {game::kLowered, 1}, kStep_s) == game::Event::none);
  CHECK(lock.selected == 0);
  CHECK(game::step(lock, {0.0F, -1}, kStep_s) == game::Event::moved);
  CHECK(lock.selected == game::kPins - 1);
  CHECK(game::step(lock, {0.0F, 1}, kStep_s) == game::Event::moved);
  CHECK(lock.selected == 0);
}

TEST_CASE("a set pin drops, with those set after it, when it has been forced for long enough") {
  game::Lock lock = with_set_pins(4);
  const int pin = pin_of_order(lock, 1);
  const float forced = shear_of(lock, pin) + game::kGive + 0.01F;
  select(lock, pin);

  // Pressed often, but never for long.
  for (int i = 0; i < 10; ++i) {
    for (float s = 2 * kStep_s; s < game::kPatience_s; s += kStep_s) {
      CHECK(lift(lock, forced) == game::Event::none);
    }
    CHECK(lift(lock, shear_of(lock, pin)) == game::Event::none);
  }
  CHECK(lock.set_count == 4);

  game::Event event = game::Event::none;
  float held_s = 0;
  for (; event == game::Event::none && held_s < 1; held_s += kStep_s) event = lift(lock, forced);
  CHECK(event == game::Event::dropped);
  CHECK(std::abs(held_s - game::kPatience_s) < 2 * kStep_s);
  CHECK(lock.set_count == 1);
  CHECK(lock.dropped == 3);
  CHECK(lift(lock, forced) == game::Event::none);  // it does not set again from above
}

TEST_CASE("an unset pin feels like a spring, rubs when it binds, and stands like a wall once set") {
  game::Lock lock = game::make_lock(7);
  const int pin = pin_of_order(lock, 0);
  select(lock, pin_of_order(lock, 1));
  lift(lock, 0.3F);
  CHECK(game::forces(lock) == game::Forces{.spring = 0.2F});

  select(lock, pin);
  CHECK(game::forces(lock).friction == 0);
  lift(lock, 0.3F);
  CHECK(game::forces(lock).spring > 0);
  CHECK(game::forces(lock).friction > 0);
  CHECK(game::forces(lock).damping > 0);

  lift(lock, shear_of(lock, pin));
  CHECK(game::forces(lock) == game::Forces{.ceiling_lift = shear_of(lock, pin)});
}

TEST_CASE("whatever the hand does, levels stay within 0 and 1 and the walls apart") {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> anywhere(-2, 2);
  std::uniform_int_distribution<int> move(-1, 1);
  int opened = 0;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    game::Lock lock = game::make_lock(seed);
    float turn = 0;
    for (int i = 0; i < 500; ++i) {
      // Lowered now and then, else it would never get to another pin.
      const game::Event event =
          game::step(lock, {i % 3 == 0 ? 0 : anywhere(random), move(random)}, kStep_s);
      opened += event == game::Event::opened ? 1 : 0;
      const game::Forces felt = game::forces(lock);
      for (const float level : {felt.spring, felt.friction, felt.damping, felt.grind}) {
        REQUIRE(level >= 0);
        REQUIRE(level <= 1);
      }
      REQUIRE(felt.floor_lift < felt.ceiling_lift);
      // What is nearer to one wall is far from the other.
      REQUIRE(felt.low == (lock.lift < game::kLowered));
      REQUIRE(lock.set_count >= 0);
      REQUIRE(lock.set_count <= game::kPins);
      REQUIRE(lock.turn >= turn);
      REQUIRE(lock.turn <= 1);
      turn = lock.turn;
    }
  }
  CHECK(opened > 10);  // it got everywhere
}

TEST_CASE("who goes by what the knob feels opens every lock, and the forces change seldom") {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    game::Lock lock = game::make_lock(seed);
    game::Autopilot autopilot;
    game::Forces felt = game::forces(lock);
    int changes = 0;
    while (!game::is_open(lock) && lock.time_s < 60) {
      game::step(lock, autopilot.next(felt, kStep_s), kStep_s);
      changes += game::forces(lock) == felt ? 0 : 1;
      felt = game::forces(lock);
    }
    REQUIRE(game::is_open(lock));
    CHECK(lock.dropped == 0);
    CHECK(static_cast<float>(changes) < 6 * lock.time_s);  // of 60 frames a second
    CHECK(felt == game::Forces{});
  }
}
