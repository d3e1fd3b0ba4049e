/// @file
/// SDL itself, and the window or the picture in memory that is drawn on.
#pragma once

#include <SDL.h>

#include <memory>
#include <string>

namespace game {

/// Starts SDL and ends it.
class Sdl {
 public:
  /// @param headless without a display
  /// @throws std::runtime_error what SDL says
  explicit Sdl(bool headless);
  /// @throws std::runtime_error if what is drawn would be seen by nobody
  static void need_a_visible_display();
  ~Sdl() { SDL_Quit(); }
  Sdl(const Sdl&) = delete;
  Sdl& operator=(const Sdl&) = delete;
};

/// Drawn at twice its size and then shrunk, which smooths all edges on every kind of renderer.
class Screen {
 public:
  /// @throws std::runtime_error what SDL says
  explicit Screen(bool headless);

  /// The renderer for the next picture.
  SDL_Renderer* begin();
  /// Shows the picture in the window.
  void show();
  /// Writes the picture as a BMP file.
  void save(const std::string& file);

 private:
  struct Free {
    void operator()(SDL_Window* window) const { SDL_DestroyWindow(window); }
    void operator()(SDL_Surface* surface) const { SDL_FreeSurface(surface); }
    void operator()(SDL_Renderer* renderer) const { SDL_DestroyRenderer(renderer); }
    void operator()(SDL_Texture* texture) const { SDL_DestroyTexture(texture); }
  };
  // Destroyed from the last to the first.
  std::unique_ptr<SDL_Window, Free> window_;
  std::unique_ptr<SDL_Surface, Free> surface_;
  std::unique_ptr<SDL_Renderer, Free> renderer_;
  std::unique_ptr<SDL_Texture, Free> texture_;
};

}  // namespace game
