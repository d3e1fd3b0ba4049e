#include "game/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "game/paint.hpp"

namespace game {
namespace {

constexpr SDL_Color kSky{30, 34, 44, 255}, kGround{15, 17, 22, 255};
constexpr SDL_Color kInk{226, 229, 236, 255}, kFaint{132, 140, 156, 255};
constexpr SDL_Color kSteel{196, 204, 216, 255}, kSteelDark{112, 122, 138, 255};
constexpr SDL_Color kBody{74, 82, 97, 255}, kBodyDark{48, 54, 66, 255};
constexpr SDL_Color kBrass{214, 170, 88, 255}, kBrassDark{142, 104, 44, 255};
constexpr SDL_Color kHole{21, 23, 29, 255};
constexpr SDL_Color kGood{96, 214, 140, 255}, kWarn{246, 178, 74, 255}, kBad{240, 94, 84, 255};

constexpr float kBodyLeft = 60, kBodyRight = 612, kBodyTop = 96, kBottom = 470;
constexpr float kShear = 296;  // y of the shear line
constexpr float kRest = 416;   // y of a key pin's point at lift 0
constexpr float kStroke = 104;
constexpr float kChamberTop = 112, kChamber = 44, kFirst = 166, kSpacing = 92;
constexpr float kDriver = 84;  // length of the upper halves

constexpr SDL_FPoint kDial{790, 226};

SDL_Color fade(SDL_Color colour, float alpha) {
  colour.a = static_cast<Uint8>(255 * std::clamp(alpha, 0.0F, 1.0F));
  return colour;
}

float pin_x(int pin) { return kFirst + kSpacing * static_cast<float>(pin); }

/// How far the pick's tip gets: the set pins do not yield, however hard one presses.
float tip_lift(const Lock& lock) {
  return std::clamp(lock.lift, 0.0F, forces(lock).ceiling_lift + 0.02F);
}

void draw_body(Paint& paint, const Lock& lock) {
  // The bolt, which the plug draws back.
  paint.box({kBodyRight - 40 - 44 * lock.turn, 150, 84, 56}, 8, kSteel, kSteelDark);
  paint.box({kBodyLeft - 6, kBodyTop - 6, kBodyRight - kBodyLeft + 12, kBottom - kBodyTop + 12}, 24,
            {9, 10, 13, 255});
  paint.box({kBodyLeft, kBodyTop, kBodyRight - kBodyLeft, kBottom - kBodyTop}, 20, kBody,
            kBodyDark);
  paint.box({kBodyLeft + 34, kShear, kBodyRight - kBodyLeft - 54, 150}, 6, kBrass, kBrassDark);
  paint.box({kBodyLeft - 6, 372, kBodyRight - kBodyLeft - 40, 56}, 4, kHole);  // the keyway
  for (int i = 0; i < kPins; ++i) {
    paint.box({pin_x(i) - kChamber / 2, kChamberTop, kChamber, 390 - kChamberTop}, 4, kHole);
  }
}

void draw_pin(Paint& paint, const Lock& lock, int index) {
  const Pin& pin = lock.pins[static_cast<std::size_t>(index)];
  const float x = pin_x(index);
  const float half = kChamber / 2 - 3;
  const bool chosen = index == lock.selected && !is_free(lock);
  const bool set = is_set(lock, index);
  const float lift = chosen ? tip_lift(lock) : 0;

  const float point = kRest - kStroke * lift;  // the lower half's
  const float top = kShear + kStroke * (pin.shear_lift - lift);
  const float driver_bottom = set ? kShear : top;
  const float driver_top = driver_bottom - kDriver;

  std::array<SDL_FPoint, 15> coil;
  for (std::size_t i = 0; i < coil.size(); ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(coil.size() - 1);
    coil[i] = {x + (i % 2 == 0 ? -1.0F : 1.0F) * (half - 5),
               kChamberTop + 4 + share * (driver_top - kChamberTop - 6)};
  }
  paint.line(coil, 3, kSteelDark);
  const bool binds = chosen && is_binding(lock);
  paint.box({x - half, driver_top, 2 * half, kDriver}, 4,
            set     ? kGood
            : binds ? kWarn
                    : kSteel,
            set     ? SDL_Color{44, 126, 78, 255}
            : binds ? SDL_Color{158, 98, 30, 255}
                    : kSteelDark);

  const float shoulder = std::min(point - 16, kRest);
  paint.box({x - half, top + 1, 2 * half, shoulder - top}, 3, {240, 206, 132, 255}, kBrassDark);
  paint.shape({{x - half, shoulder - 2}, {x + half, shoulder - 2}, {x + 5, point}, {x - 5, point}},
              {150, 112, 50, 255});
  if (chosen) paint.shape({{x - 8, 486}, {x, 476}, {x + 8, 486}}, kInk);
  char number[2] = {static_cast<char>('1' + index), 0};
  paint.text(number, {x, 494}, 13, set ? kGood : chosen ? kInk : kFaint, Align::centre);
}

void draw_pick(Paint& paint, const Lock& lock) {
  const bool free = is_free(lock);
  const float strain = lock.forced_s / kPatience_s;
  const SDL_Color colour = strain > 0 ? kBad : kSteel;
  const float x = pin_x(lock.selected);
  const float tip = kRest + 5 - (free ? 0 : kStroke * tip_lift(lock));
  const float shaft = 419 + 6 * strain;
  paint.line(
      std::array<SDL_FPoint, 4>{
          {{20, 428}, {x - 42, shaft}, {x - 16, std::min(shaft, tip + 12)}, {x, tip}}},
      8, colour);
  paint.box({-30, 416, 74, 24}, 9, {58, 62, 72, 255}, {28, 30, 36, 255});
}

/// The knob itself, and round it what holds it back.
void draw_dial(Paint& paint, const Lock& lock, const Forces& felt, const Status& status) {
  const float radius = 92;
  const auto angle = [&status](float lift) { return status.lift_deg * lift; };
  for (int i = -6; i <= 18; ++i) {
    const float at = angle(static_cast<float>(i) / 12);
    const float length = i % 6 == 0 ? 14.0F : 7.0F;
    paint.line({around(kDial, radius + 8, at), around(kDial, radius + 8 + length, at)}, 2,
               i < 0 || i > 12 ? fade(kFaint, 0.35F) : kFaint);
  }
  if (!is_open(lock)) {
    paint.arc(kDial, radius + 30, angle(felt.floor_lift) - 14, angle(felt.floor_lift), 7,
              lock.lift < felt.floor_lift ? kBad : kSteelDark);
    paint.arc(kDial, radius + 30, angle(felt.ceiling_lift), angle(felt.ceiling_lift) + 14, 7,
              lock.lift > felt.ceiling_lift ? kBad : kSteelDark);
  }
  paint.disc({kDial.x + 4, kDial.y + 7}, radius, {8, 9, 12, 160});
  for (int i = 0; i < 36; ++i) {  // the grip
    const float at = status.knob_deg + 10 * static_cast<float>(i);
    paint.line({around(kDial, radius - 10, at), around(kDial, radius - 2, at)}, 8,
               {58, 63, 75, 255});
  }
  paint.disc(kDial, radius - 6, {92, 100, 116, 255}, {40, 44, 54, 255});
  paint.disc(kDial, radius - 22, {52, 57, 69, 255}, {70, 77, 91, 255});
  const SDL_Color mark = is_open(lock) ? kGood : kWarn;
  paint.line({around(kDial, 42, status.knob_deg), around(kDial, 64, status.knob_deg)}, 7, mark);
}

void draw_bar(Paint& paint, float y, const char* name, float level, SDL_Color colour) {
  paint.text(name, {664, y}, 11, kFaint);
  paint.box({760, y - 1, 156, 13}, 6, {38, 42, 52, 255});
  if (level > 0) {
    paint.box({760, y - 1, 156 * std::clamp(level, 0.09F, 1.0F), 13}, 6, colour);
  }
}

void draw_felt(Paint& paint, const Lock& lock, const Forces& felt) {
  const float beyond = std::max(lock.lift - felt.ceiling_lift, felt.floor_lift - lock.lift);
  const bool lifted = lock.lift > 0.01F;
  paint.text("What the knob feels", {664, 366}, 12, kInk);
  draw_bar(paint, 394, "Spring", lifted ? felt.spring : 0, kSteel);
  draw_bar(paint, 416, "Friction", felt.friction, kWarn);
  draw_bar(paint, 438, "Damping", felt.damping, kWarn);
  draw_bar(paint, 460, "Grind", felt.grind, kWarn);
  draw_bar(paint, 482, "Wall", is_open(lock) ? 0 : 8 * beyond, kBad);
}

const char* hint(const Lock& lock) {
  if (is_open(lock)) return "Open! Go back down for the next lock.";
  if (is_free(lock)) return "The plug is free: turn on!";
  if (lock.forced_s > 0) return "Not so hard: it will drop!";
  if (is_set(lock, lock.selected)) return "Set. Lower the pick, then on to the next pin.";
  if (is_binding(lock)) return "This one binds: lift it until it clicks.";
  if (lock.lift > kLowered) return "Springy: not this one. Lower the pick, try another.";
  return "Lift the pin: turn the knob to the right.";
}

}  // namespace

float lift_at(float y) { return (kRest - y) / kStroke; }

void draw(SDL_Renderer* renderer, const Lock& lock, const Status& status) {
  SDL_SetRenderDrawBlendMode(renderer, SDL_BLENDMODE_BLEND);
  Paint paint(renderer);
  const Forces felt = forces(lock);
  paint.box({0, 0, kWidth, kHeight}, 0, kSky, kGround);
  paint.box({640, 96, 300, 420}, 18, fade({70, 78, 94, 255}, 0.25F));

  draw_body(paint, lock);
  for (int i = 0; i < kPins; ++i) draw_pin(paint, lock, i);
  const bool free = is_free(lock);
  paint.line({{kBodyLeft + 18, kShear}, {kBodyRight - 12, kShear}}, 2,
             free ? kGood : fade(kWarn, 0.55F));
  draw_pick(paint, lock);
  draw_dial(paint, lock, felt, status);
  draw_felt(paint, lock, felt);

  const float flash = 1 - status.since_event_s / 0.4F;
  if (flash > 0 && (status.event == Event::set || status.event == Event::dropped)) {
    const float x = pin_x(lock.selected);
    paint.arc({x, kShear}, 24 + 40 * (1 - flash), 0, 360, 5,
              fade(status.event == Event::set ? kGood : kBad, flash));
  }

  std::array<char, 64> line{};
  std::snprintf(line.data(), line.size(), "Lock %d   %d of %d set   %d dropped   %d s",
                status.opened + (is_open(lock) ? 0 : 1), lock.set_count, kPins, lock.dropped,
                static_cast<int>(lock.time_s));
  paint.text("Pick the lock", {60, 34}, 26, kInk);
  paint.text(line.data(), {940, 43}, 12, kFaint, Align::right);
  const std::string say = status.hint.empty() ? hint(lock) : status.hint;
  paint.text(say, {60, 536}, 15, is_open(lock) ? kGood : lock.forced_s > 0 ? kBad : kInk);
  paint.text(status.input, {60, 570}, 10, kFaint);
}

}  // namespace game
