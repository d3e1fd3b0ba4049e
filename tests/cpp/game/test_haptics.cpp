// The game's forces against a stand-in for SDL's haptic functions, which are defined here: SDL's
// documentation of each is the oracle.
#include <SDL.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "game/haptics.hpp"

namespace {

constexpr std::size_t kForces = 9;    // four, and the five springs of a wall
constexpr std::size_t kEffects = 11;  // and two knocks

struct FakeDevice {
  unsigned has = 0xFFFF;
  std::map<int, SDL_HapticEffect> effects;
  std::map<int, Uint32> playing;  // how many times
  std::vector<std::string> calls;
  bool refuse_updates = false;
} fake;

int a_joystick = 0;
SDL_Joystick* joystick() { return reinterpret_cast<SDL_Joystick*>(&a_joystick); }

int count(const char* call) {
  return static_cast<int>(std::count(fake.calls.begin(), fake.calls.end(), call));
}

std::vector<SDL_HapticEffect> playing(Uint16 type) {
  std::vector<SDL_HapticEffect> found;
  for (const auto& [id, times] : fake.playing) {
    if (fake.effects.at(id).type == type) found.push_back(fake.effects.at(id));
  }
  return found;
}

constexpr game::AxisScale kScale{.range_deg = 360, .lift_deg = 90};  // lift 1 is half way

}  // namespace

extern "C" {
int SDL_JoystickIsHaptic(SDL_Joystick*) { return fake.has == 0 ? 0 : 1; }
SDL_Haptic* SDL_HapticOpenFromJoystick(SDL_Joystick*) {
  fake.calls.emplace_back("open");
  return reinterpret_cast<SDL_Haptic*>(&fake);
}
void SDL_HapticClose(SDL_Haptic*) { fake.calls.emplace_back("close"); }
unsigned int SDL_HapticQuery(SDL_Haptic*) { return fake.has; }
int SDL_HapticSetGain(SDL_Haptic*, int gain) { return gain == 100 ? 0 : -1; }
int SDL_HapticSetAutocenter(SDL_Haptic*, int autocenter) { return autocenter == 0 ? 0 : -1; }
int SDL_HapticNewEffect(SDL_Haptic*, SDL_HapticEffect* effect) {
  const int id = static_cast<int>(fake.effects.size()) + 3;
  fake.effects[id] = *effect;
  return id;
}
int SDL_HapticUpdateEffect(SDL_Haptic*, int id, SDL_HapticEffect* effect) {
  fake.calls.emplace_back("update");
  if (fake.refuse_updates) return SDL_SetError("no more");
  fake.effects.at(id) = *effect;
  return 0;
}
int SDL_HapticRunEffect(SDL_Haptic*, int id, Uint32 times) {
  fake.calls.emplace_back("run");
  fake.playing[id] = times;
  return 0;
}
int SDL_HapticStopAll(SDL_Haptic*) {
  fake.calls.emplace_back("stop");
  fake.playing.clear();
  return 0;
}
void SDL_HapticDestroyEffect(SDL_Haptic*, int id) {
  fake.calls.emplace_back("destroy");
  fake.effects.erase(id);
}
}

TEST_CASE("the pin's spring pushes down to lift 0, no harder than its level") {
  fake = {};
  game::Haptics haptics(joystick(), kScale);
  haptics.feel({.spring = 0.2F}, 0);
  const SDL_HapticCondition pin = playing(SDL_HAPTIC_SPRING).at(0).condition;
  CHECK(pin.center[0] == 0);
  CHECK(pin.right_coeff[0] == 6553);
  CHECK(pin.left_coeff[0] == 0);
  CHECK(pin.right_sat[0] == 13106);  // of 65535
  CHECK(pin.length == SDL_HAPTIC_INFINITY);
}

TEST_CASE("the nearer wall is a spring of full stiffness on its far side only") {
  fake = {};
  game::Haptics haptics(joystick(), kScale);
  haptics.feel({.floor_lift = -0.5F, .ceiling_lift = 0.75F, .low = true}, 0);
  SDL_HapticCondition wall = playing(SDL_HAPTIC_SPRING).at(1).condition;
  CHECK(std::abs(wall.center[0] + 32767 / 4) <= 1);
  CHECK(wall.left_coeff[0] == 32767);
  CHECK(wall.right_coeff[0] == 0);
  haptics.feel({.floor_lift = -0.5F, .ceiling_lift = 0.75F, .low = false}, 100);
  wall = playing(SDL_HAPTIC_SPRING).at(1).condition;
  CHECK(std::abs(wall.center[0] - 32767 * 3 / 8) <= 1);
  CHECK(wall.left_coeff[0] == 0);
  CHECK(wall.right_coeff[0] == 32767);
  CHECK(wall.right_sat[0] >= 65534);
  CHECK(wall.deadband[0] == 0);
}

TEST_CASE("a wall beyond the axis stands at its end") {
  fake = {};
  game::Haptics haptics(joystick(), {.range_deg = 90, .lift_deg = 90});
  haptics.feel({}, 0);
  CHECK(playing(SDL_HAPTIC_SPRING).at(1).condition.center[0] == 32767);
}

TEST_CASE("what stays the same is not sent again; what changes fast is sent in time, newest wins") {
  fake = {};
  game::Haptics haptics(joystick(), kScale);
  haptics.feel({.friction = 0.1F}, 1000);
  const int first = count("update");
  for (Uint32 now = 1000; now < 2000; now += 4) haptics.feel({.friction = 0.1F}, now);
  CHECK(count("update") == first);

  for (Uint32 now = 2000; now <= 3000; now += 4) {
    haptics.feel({.friction = 0.1F + static_cast<float>(now - 2000) / 2000}, now);
  }
  CHECK(count("update") - first <= 67);  // once in 15 ms
  CHECK(count("update") - first >= 50);
  haptics.feel({.friction = 0.6F}, 3015);
  REQUIRE(playing(SDL_HAPTIC_FRICTION).size() == 1);
  CHECK(playing(SDL_HAPTIC_FRICTION)[0].condition.right_coeff[0] == 19660);
}

TEST_CASE("stop ends all forces, and the next feel starts them as they must be by then") {
  fake = {};
  game::Haptics haptics(joystick(), kScale);
  haptics.feel({.damping = 0.5F}, 0);
  CHECK(fake.playing.size() == kForces);
  for (const auto& [id, times] : fake.playing) CHECK(times == SDL_HAPTIC_INFINITY);
  haptics.stop();
  CHECK(fake.playing.empty());
  haptics.stop();
  CHECK(count("stop") == 1);
  haptics.feel({.damping = 0.25F}, 100);
  CHECK(fake.playing.size() == kForces);
  CHECK(playing(SDL_HAPTIC_DAMPER)[0].condition.right_coeff[0] == 8192);
}

TEST_CASE("a set pin clicks and a dropped one thumps, both once and briefly") {
  fake = {};
  game::Haptics haptics(joystick(), kScale);
  haptics.knock(game::Event::moved);
  CHECK(fake.playing.empty());
  haptics.knock(game::Event::set);
  REQUIRE(playing(SDL_HAPTIC_TRIANGLE).size() == 1);
  CHECK(playing(SDL_HAPTIC_TRIANGLE)[0].periodic.length < 100);
  haptics.knock(game::Event::dropped);
  REQUIRE(playing(SDL_HAPTIC_CONSTANT).size() == 1);
  CHECK(playing(SDL_HAPTIC_CONSTANT)[0].constant.length < 100);
  for (const auto& [id, times] : fake.playing) CHECK(times == 1);
}

TEST_CASE("at the end forces stop, then effects go, then the device is closed") {
  fake = {};
  {
    game::Haptics haptics(joystick(), kScale);
    haptics.feel({}, 0);
    fake.calls.clear();
  }
  REQUIRE(fake.calls.size() == 2 + kEffects);
  CHECK(fake.calls.front() == "stop");
  CHECK(count("destroy") == kEffects);
  CHECK(fake.calls.back() == "close");
  CHECK(fake.effects.empty());
}

TEST_CASE("effects that the device lacks are left out; without force feedback nothing is called") {
  fake = {};
  fake.has = SDL_HAPTIC_SPRING | SDL_HAPTIC_CONSTANT;
  {
    game::Haptics haptics(joystick(), kScale);
    haptics.feel({.friction = 0.5F}, 0);
    haptics.knock(game::Event::set);
    CHECK(haptics.works());
    CHECK(fake.effects.size() == 7);
    CHECK(fake.playing.size() == 6);
    CHECK(haptics.effects()[game::Haptics::friction].id < 0);
  }
  fake = {};
  fake.has = 0;
  game::Haptics none(joystick(), kScale);
  none.feel({}, 0);
  none.knock(game::Event::set);
  none.stop();
  CHECK_FALSE(none.works());
  CHECK(fake.calls.empty());
}

TEST_CASE("errors of the device are kept in words, and not without end") {
  fake = {};
  fake.refuse_updates = true;
  game::Haptics haptics(joystick(), kScale);
  for (Uint32 now = 0; now < 2000; now += 20) haptics.feel({.friction = 0.5F}, now);
  REQUIRE(!haptics.errors().empty());
  CHECK(haptics.errors().size() <= 20);
  CHECK(haptics.errors()[0] == "friction: no more");
}
