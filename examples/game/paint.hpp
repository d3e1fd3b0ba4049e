/// @file
/// Shapes and lettering on an SDL renderer.
#pragma once

#include <SDL.h>

#include <initializer_list>
#include <span>
#include <string_view>

namespace game {

enum class Align { left, centre, right };

class Paint {
 public:
  explicit Paint(SDL_Renderer* renderer) : renderer_(renderer) {}

  /// A convex shape, shaded from its highest to its lowest point.
  void shape(std::span<const SDL_FPoint> outline, SDL_Color top, SDL_Color bottom);
  void shape(std::initializer_list<SDL_FPoint> outline, SDL_Color colour) {
    shape({outline.begin(), outline.size()}, colour, colour);
  }
  void box(SDL_FRect box, float radius, SDL_Color top, SDL_Color bottom);
  void box(SDL_FRect box, float radius, SDL_Color colour) {
    this->box(box, radius, colour, colour);
  }
  void disc(SDL_FPoint centre, float radius, SDL_Color top, SDL_Color bottom);
  void disc(SDL_FPoint centre, float radius, SDL_Color colour) {
    disc(centre, radius, colour, colour);
  }
  /// With round ends.
  void line(std::span<const SDL_FPoint> points, float width, SDL_Color colour);
  void line(std::initializer_list<SDL_FPoint> points, float width, SDL_Color colour) {
    line(std::span{points.begin(), points.size()}, width, colour);
  }
  /// Angles in degrees, clockwise from the top.
  void arc(SDL_FPoint centre, float radius, float from_deg, float to_deg, float width,
           SDL_Color colour);
  /// Letters (all of them capitals), digits and .,:;-+/!'() from point `at` down.
  void text(std::string_view text, SDL_FPoint at, float height, SDL_Color colour,
            Align align = Align::left);

 private:
  SDL_Renderer* renderer_;
};

/// The point at a distance and at an angle in degrees, clockwise from the top.
SDL_FPoint around(SDL_FPoint centre, float radius, float angle_deg);

}  // namespace game
