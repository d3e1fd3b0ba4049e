#include "game/screen.hpp"

#include <stdexcept>

#include "game/scene.hpp"

namespace game {
namespace {

constexpr int kFine = 2;

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what + ": " + SDL_GetError());
}

}  // namespace

Sdl::Sdl(bool headless) {
  SDL_SetMainReady();
  if (headless) SDL_SetHint(SDL_HINT_VIDEODRIVER, "dummy");
  // Without a window there is no focus to lose; with one, the game pauses by itself.
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
  SDL_SetHint(SDL_HINT_RENDER_SCALE_QUALITY, "linear");
  if (SDL_Init(SDL_INIT_VIDEO | SDL_INIT_JOYSTICK | SDL_INIT_HAPTIC) != 0) {
    fail("cannot start SDL (without a display, use --headless)");
  }
}

void Sdl::need_a_visible_display() {
  const std::string driver = SDL_GetCurrentVideoDriver();
  if (driver != "offscreen" && driver != "dummy") return;
  throw std::runtime_error("nobody would see the game: SDL has found only its '" + driver +
                           "' display; play where there is a screen, or add --headless");
}

Screen::Screen(bool headless) {
  if (headless) {
    surface_.reset(SDL_CreateRGBSurfaceWithFormat(0, kFine * kWidth, kFine * kHeight, 32,
                                                  SDL_PIXELFORMAT_ARGB8888));
    if (!surface_) fail("cannot make a picture");
    renderer_.reset(SDL_CreateSoftwareRenderer(surface_.get()));
    if (!renderer_) fail("cannot draw");
    return;
  }
  window_.reset(SDL_CreateWindow("Pick the lock", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED,
                                 kWidth, kHeight, 0));
  if (!window_) fail("cannot open a window");
  renderer_.reset(SDL_CreateRenderer(window_.get(), -1,
                                     SDL_RENDERER_PRESENTVSYNC | SDL_RENDERER_TARGETTEXTURE));
  if (!renderer_) fail("cannot draw");
  texture_.reset(SDL_CreateTexture(renderer_.get(), SDL_PIXELFORMAT_ARGB8888,
                                   SDL_TEXTUREACCESS_TARGET, kFine * kWidth, kFine * kHeight));
  if (!texture_) fail("cannot make a picture");
}

SDL_Renderer* Screen::begin() {
  if (texture_) SDL_SetRenderTarget(renderer_.get(), texture_.get());
  SDL_RenderSetScale(renderer_.get(), kFine, kFine);
  return renderer_.get();
}

void Screen::show() {
  SDL_SetRenderTarget(renderer_.get(), nullptr);
  SDL_RenderSetScale(renderer_.get(), 1, 1);
  SDL_RenderCopy(renderer_.get(), texture_.get(), nullptr, nullptr);
  SDL_RenderPresent(renderer_.get());
}

void Screen::save(const std::string& file) {
  SDL_RenderFlush(renderer_.get());
  using Surface = std::unique_ptr<SDL_Surface, Free>;
  const auto make = [](int fine) {
    return Surface(SDL_CreateRGBSurfaceWithFormat(0, fine * kWidth, fine * kHeight, 32,
                                                  SDL_PIXELFORMAT_ARGB8888));
  };
  const Surface fine = make(kFine);
  const Surface picture = make(1);
  if (!fine || !picture) fail("cannot make a picture");
  if (SDL_RenderReadPixels(renderer_.get(), nullptr, fine->format->format, fine->pixels,
                           fine->pitch) != 0 ||
      SDL_SoftStretchLinear(fine.get(), nullptr, picture.get(), nullptr) != 0 ||
      SDL_SaveBMP(picture.get(), file.c_str()) != 0) {
    fail("cannot write " + file);
  }
}

}  // namespace game
