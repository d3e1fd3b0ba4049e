// Crack the safe: a small game that plays on a force feedback knob with plain SDL 2.
//
// The device computes springs, friction and damping from its own angle, thousands of times a
// second. The game says which, and only when they change.
#include <SDL.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iostream>
#include <memory>
#include <string>
#include <utility>

namespace {

constexpr float kAxisRange_deg = 900;  // from one end of the joystick's axis to the other
constexpr float kStop_deg = 90;        // the dial turns so far to each side
constexpr float kNotch_deg = 15;       // from one number to the next
constexpr int kSecret = 4;             // the number that opens the safe
constexpr Uint32 kFrame_ms = 16;

Sint16 axis_of(float angle_deg) {
  return static_cast<Sint16>(std::lround(32767 * angle_deg / (kAxisRange_deg / 2)));
}

float angle_of(Sint16 axis) { return static_cast<float>(axis) / 32767 * kAxisRange_deg / 2; }

/// A spring, a damper or a friction, with its coefficients below and above the centre.
SDL_HapticEffect condition(Uint16 type, float centre_deg, float below, float above, float limit) {
  SDL_HapticEffect effect;
  std::memset(&effect, 0, sizeof effect);  // bytes between members too: effects are compared
  effect.condition.type = type;
  effect.condition.direction.type = SDL_HAPTIC_CARTESIAN;
  effect.condition.direction.dir[0] = 1;
  effect.condition.length = SDL_HAPTIC_INFINITY;
  effect.condition.center[0] = axis_of(centre_deg);
  effect.condition.left_coeff[0] = static_cast<Sint16>(32767 * below);
  effect.condition.right_coeff[0] = static_cast<Sint16>(32767 * above);
  effect.condition.left_sat[0] = effect.condition.right_sat[0] = static_cast<Uint16>(65535 * limit);
  return effect;
}

/// The knock of a bolt, 40 ms long.
SDL_HapticEffect knock() {
  SDL_HapticEffect effect;
  std::memset(&effect, 0, sizeof effect);
  effect.periodic.type = SDL_HAPTIC_TRIANGLE;
  effect.periodic.direction.type = SDL_HAPTIC_CARTESIAN;
  effect.periodic.direction.dir[0] = 1;
  effect.periodic.length = 40;
  effect.periodic.period = 20;
  effect.periodic.magnitude = 29'000;
  return effect;
}

class Forces {
 public:
  /// Uploads every effect that the device has, and starts all but the knock.
  explicit Forces(SDL_Joystick* joystick) : device_(SDL_HapticOpenFromJoystick(joystick)) {
    ids_.fill(-1);
    if (device_ == nullptr) {
      std::cerr << "safe: no force feedback: " << SDL_GetError() << '\n';
      return;
    }
    const unsigned has = SDL_HapticQuery(device_);
    if ((has & SDL_HAPTIC_GAIN) != 0) SDL_HapticSetGain(device_, 100);
    if ((has & SDL_HAPTIC_AUTOCENTER) != 0) SDL_HapticSetAutocenter(device_, 0);
    now_ = wanted(0);
    for (std::size_t n = 0; n < kEffects; ++n) {
      if ((has & now_[n].type) != 0) ids_[n] = SDL_HapticNewEffect(device_, &now_[n]);
      if (ids_[n] < 0) std::cerr << "safe: left out effect " << n << ": " << SDL_GetError() << '\n';
    }
  }
  ~Forces() {
    stop();
    if (device_ != nullptr) SDL_HapticClose(device_);
  }
  Forces(const Forces&) = delete;
  Forces& operator=(const Forces&) = delete;

  /// Makes the device feel as the dial does at this angle.
  void feel(float angle_deg) {
    if (device_ == nullptr) return;
    const Effects next = wanted(angle_deg);
    for (std::size_t n = 0; n < kKnock; ++n) {
      if (ids_[n] < 0) continue;
      if (std::memcmp(&now_[n], &next[n], sizeof next[n]) != 0) {
        now_[n] = next[n];
        SDL_HapticUpdateEffect(device_, ids_[n], &now_[n]);
      }
      if (!running_) SDL_HapticRunEffect(device_, ids_[n], SDL_HAPTIC_INFINITY);
    }
    running_ = true;
  }

  void play_knock() {
    if (device_ != nullptr && ids_[kKnock] >= 0) SDL_HapticRunEffect(device_, ids_[kKnock], 1);
  }

  /// Stops all forces until the next feel().
  void stop() {
    if (device_ != nullptr) SDL_HapticStopAll(device_);
    running_ = false;
  }

 private:
  // Devices spread a full coefficient over their whole axis, so one spring feels like rubber.
  static constexpr std::size_t kWallSprings = 5;
  static constexpr std::size_t kKnock = 3 + kWallSprings;
  static constexpr std::size_t kEffects = kKnock + 1;
  using Effects = std::array<SDL_HapticEffect, kEffects>;

  static Effects wanted(float angle_deg) {
    const float notch_deg = kNotch_deg * std::round(angle_deg / kNotch_deg);
    Effects effects{condition(SDL_HAPTIC_SPRING, notch_deg, 1, 1, 0.25F),
                    condition(SDL_HAPTIC_FRICTION, 0, 0.05F, 0.05F, 0.05F),
                    condition(SDL_HAPTIC_DAMPER, 0, 0.1F, 0.1F, 1)};
    // The nearer wall: a spring on one side of its centre only.
    const bool low = angle_deg < 0;
    std::fill_n(
        effects.begin() + 3, kWallSprings,
        condition(SDL_HAPTIC_SPRING, low ? -kStop_deg : kStop_deg, low ? 1 : 0, low ? 0 : 1, 1));
    effects[kKnock] = knock();
    return effects;
  }

  SDL_Haptic* device_;
  std::array<int, kEffects> ids_{};  // less than 0: the device does not have it
  Effects now_{};
  bool running_ = false;
};

void draw(SDL_Renderer* renderer, float angle_deg, bool open) {
  SDL_SetRenderDrawColor(renderer, 24, open ? 96 : 24, 32, 255);
  SDL_RenderClear(renderer);
  const auto line = [renderer](float deg, float inner, float outer) {
    const float x = std::sin(deg * 3.14159F / 180);
    const float y = -std::cos(deg * 3.14159F / 180);
    SDL_RenderDrawLineF(renderer, 200 + inner * x, 200 + inner * y, 200 + outer * x,
                        200 + outer * y);
  };
  SDL_SetRenderDrawColor(renderer, 230, 190, 90, 255);
  for (float deg = -kStop_deg; deg <= kStop_deg; deg += kNotch_deg) line(deg, 150, 170);
  line(angle_deg, 0, 140);
  SDL_RenderPresent(renderer);
}

class Game {
 public:
  Game(bool has_window, bool by_itself) : by_itself_(by_itself) {
    if (has_window) SDL_CreateWindowAndRenderer(400, 400, 0, &window_, &renderer_);
    if (!by_itself && SDL_NumJoysticks() > 0) joystick_ = SDL_JoystickOpen(0);
    if (joystick_ != nullptr) forces_ = std::make_unique<Forces>(joystick_);
    std::cout << "plays on " << (joystick_ == nullptr ? "the mouse" : SDL_JoystickName(joystick_))
              << std::endl;
  }
  ~Game() {
    forces_.reset();
    if (joystick_ != nullptr) SDL_JoystickClose(joystick_);
    if (renderer_ != nullptr) SDL_DestroyRenderer(renderer_);
    if (window_ != nullptr) SDL_DestroyWindow(window_);
  }
  Game(const Game&) = delete;
  Game& operator=(const Game&) = delete;

  /// Plays until somebody quits; by itself, until the safe is open or the dial at its end.
  /// @returns whether the safe is open
  bool play() {
    while (!quit_) {
      SDL_Event event;
      while (SDL_PollEvent(&event) != 0) handle(event);
      step();
      if (renderer_ != nullptr) draw(renderer_, angle_deg_, open_);
      if (!by_itself_) SDL_Delay(kFrame_ms);
    }
    return open_;
  }

 private:
  void handle(const SDL_Event& event) {
    // SDL makes SDL_QUIT of Ctrl-C, too.
    if (event.type == SDL_QUIT || event.type == SDL_JOYDEVICEREMOVED) quit_ = true;
    if (event.type == SDL_MOUSEMOTION && joystick_ == nullptr) {
      angle_deg_ = (static_cast<float>(event.motion.x) - 200) / 200 * kStop_deg;
    }
    if (event.type != SDL_WINDOWEVENT) return;
    // A knob must not turn by itself while you work in another window.
    if (event.window.event == SDL_WINDOWEVENT_FOCUS_GAINED) paused_ = false;
    if (event.window.event == SDL_WINDOWEVENT_FOCUS_LOST) {
      paused_ = true;
      if (forces_) forces_->stop();
    }
  }

  void step() {
    if (joystick_ != nullptr) angle_deg_ = angle_of(SDL_JoystickGetAxis(joystick_, 0));
    if (by_itself_) {
      angle_deg_ += 0.5F;
      quit_ = open_ || angle_deg_ > kStop_deg;
    }
    if (forces_ && !paused_) forces_->feel(angle_deg_);
    const int before =
        std::exchange(number_, static_cast<int>(std::lround(angle_deg_ / kNotch_deg)));
    if (number_ == before || number_ != kSecret) return;
    if (forces_) forces_->play_knock();
    open_ = true;
    std::cout << "open" << std::endl;
  }

  bool by_itself_;
  SDL_Window* window_ = nullptr;
  SDL_Renderer* renderer_ = nullptr;
  SDL_Joystick* joystick_ = nullptr;
  std::unique_ptr<Forces> forces_;
  float angle_deg_ = 0;
  int number_ = 0;
  bool quit_ = false;
  bool paused_ = false;
  bool open_ = false;
};

}  // namespace

int main(int count, char** arguments) {
  const std::string option = count > 1 ? arguments[1] : "";
  if (count > 2 || (!option.empty() && option != "--no-window" && option != "--by-itself")) {
    std::cerr << "usage: safe [--no-window | --by-itself]\n";
    return 2;
  }
  SDL_SetMainReady();
  if (!option.empty()) SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
  const Uint32 parts = SDL_INIT_EVENTS | SDL_INIT_JOYSTICK | SDL_INIT_HAPTIC;
  if (SDL_Init(parts | (option.empty() ? SDL_INIT_VIDEO : 0U)) != 0) {
    std::cerr << "safe: " << SDL_GetError() << '\n';
    return 1;
  }
  const bool by_itself = option == "--by-itself";
  const bool open = Game(option.empty(), by_itself).play();
  SDL_Quit();
  return open || !by_itself ? 0 : 1;
}
