// Pick a lock: an example of a game that plays on a force feedback knob with plain SDL.
#include <SDL.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include "game/knob.hpp"
#include "game/lock.hpp"
#include "game/options.hpp"
#include "game/scene.hpp"
#include "game/screen.hpp"

namespace game {
namespace {

constexpr float kFrame_s = 1.0F / 60;
constexpr float kLongestFrame_s = 0.05F;  // after a stall the lock does not run ahead of the hand
constexpr int kHeadlessFrames = 3600;     // the autopilot needs about a third of it

constexpr const char* kNoKnob =
    "no knob found: play with mouse and keyboard\n"
    "  plug one in, or attach the virtual one (examples/game/README.md says how):\n"
    "    torsio emulate --usbip\n"
    "    sudo usbip attach -r 127.0.0.1 -b 1-1\n";

class Game {
 public:
  explicit Game(const Options& options)
      : options_(options), screen_(options.headless), lock_(make_lock(options.seed)) {
    status_.lift_deg = scale().lift_deg;
    if (options.joystick || options.any_joystick) find_knob();
    if (!knob_ && options.any_joystick) std::cerr << kNoKnob;
    describe_input();
  }

  /// @returns the exit status
  int run() {
    Uint64 before = SDL_GetPerformanceCounter();
    const bool wait = !options_.headless || knob_;
    int frames_most = options_.frames.value_or(0);
    if (frames_most == 0 && options_.headless) frames_most = kHeadlessFrames;
    while (!quit_ && (frames_most == 0 || frames_ < frames_most)) {
      float dt_s = kFrame_s;
      if (wait) {
        // The screen may or may not wait for its beam; this is right for both.
        const auto per_s = static_cast<float>(SDL_GetPerformanceFrequency());
        const auto passed_s = [&] {
          return static_cast<float>(SDL_GetPerformanceCounter() - before) / per_s;
        };
        while (passed_s() < kFrame_s - 1e-3F) SDL_Delay(1);
        dt_s = std::min(passed_s(), kLongestFrame_s);
        before = SDL_GetPerformanceCounter();
      }
      frame(dt_s);
      ++frames_;
      if (options_.headless && !options_.frames && is_open(lock_)) break;
    }
    if (knob_) knob_->haptics().stop();
    if (!options_.screenshot.empty()) {
      draw(screen_.begin(), lock_, status_);
      screen_.save(options_.screenshot);
    }
    if (!options_.report.empty()) report();
    const bool failed = options_.headless && options_.autopilot && !options_.frames && opened_ == 0;
    if (failed) std::cerr << "lockpick: the autopilot did not open the lock\n";
    return failed ? 1 : 0;
  }

 private:
  [[nodiscard]] AxisScale scale() const { return {.range_deg = options_.range_deg}; }

  void find_knob() {
    knob_ = Knob::open(options_.joystick, scale(), options_.haptic);
    if (!knob_ || !options_.haptic) return;
    if (!knob_->haptics().works()) {
      std::cerr << knob_->name() << " has no force feedback\n";
    } else if (const std::string missing = knob_->missing(); !missing.empty()) {
      std::cerr << knob_->name() << " cannot render: " << missing << '\n';
    }
    for (const std::string& error : knob_->haptics().errors()) {
      std::cerr << knob_->name() << ": " << error << '\n';
    }
  }

  void describe_input() {
    status_.input = options_.autopilot ? "The program plays by what it feels.  "
                    : knob_            ? "Turn right: lift.  Buttons or arrows: other pin.  "
                                       : "Mouse or arrows up, down: lift.  "
                                         "Mouse buttons or arrows: other pin.  ";
    if (!options_.headless) status_.input += "P: pause.  Esc: quit.";
    if (knob_) status_.input += "  (" + knob_->name() + ")";
  }

  void frame(float dt_s) {
    input_.move = 0;
    SDL_Event event;
    while (SDL_PollEvent(&event) != 0) handle(event);
    if (paused_) {
      status_.hint = "Paused. Press P to go on.";
    } else {
      status_.hint.clear();
      play(dt_s);
    }
    if (!options_.headless) {
      draw(screen_.begin(), lock_, status_);
      screen_.show();
    }
  }

  void play(float dt_s) {
    const Uint8* keys = SDL_GetKeyboardState(nullptr);
    const int keyed = keys[SDL_SCANCODE_UP] - keys[SDL_SCANCODE_DOWN];
    input_.lift += static_cast<float>(keyed) * dt_s;
    if (knob_) input_.lift = knob_->lift();
    if (options_.autopilot) input_ = autopilot_.next(forces(lock_), dt_s);
    input_.lift = std::clamp(input_.lift, -0.25F, 1.25F);

    const Event event = step(lock_, input_, dt_s);
    status_.since_event_s += dt_s;
    if (event != Event::none) {
      status_.event = event;
      status_.since_event_s = 0;
    }
    dropped_ += event == Event::dropped ? 1 : 0;
    if (event == Event::opened) status_.opened = ++opened_;
    status_.knob_deg = lock_.lift * status_.lift_deg;
    if (knob_) {
      knob_->haptics().feel(forces(lock_), SDL_GetTicks());
      knob_->haptics().knock(event);
    }
    if (is_open(lock_) && lock_.lift < kLowered && status_.since_event_s > 1) {
      lock_ = make_lock(options_.seed + static_cast<std::uint32_t>(opened_));
      autopilot_ = {};
    }
  }

  void pause(bool paused) {
    paused_ = paused;
    if (paused && knob_)
      knob_->haptics().stop();  // the next frame that is played starts them again
  }

  void handle(const SDL_Event& event) {
    switch (event.type) {
      case SDL_QUIT:  // also what SDL makes of SIGINT and SIGTERM
        quit_ = true;
        break;
      case SDL_KEYDOWN:
        if (event.key.keysym.sym == SDLK_ESCAPE) quit_ = true;
        if (event.key.keysym.sym == SDLK_p && event.key.repeat == 0) pause(!paused_);
        if (event.key.keysym.sym == SDLK_RIGHT) input_.move = 1;
        if (event.key.keysym.sym == SDLK_LEFT) input_.move = -1;
        break;
      case SDL_MOUSEMOTION:
        input_.lift = lift_at(static_cast<float>(event.motion.y));
        break;
      case SDL_MOUSEBUTTONDOWN:
        input_.move = event.button.button == SDL_BUTTON_LEFT ? 1 : -1;
        break;
      case SDL_JOYBUTTONDOWN:
        input_.move = event.jbutton.button == 0 ? 1 : -1;
        break;
      case SDL_WINDOWEVENT:
        // Whoever works in another window does not want a knob that turns by itself.
        if (event.window.event == SDL_WINDOWEVENT_FOCUS_LOST && !options_.headless) pause(true);
        break;
      case SDL_JOYDEVICEREMOVED:
        if (knob_ && event.jdevice.which == knob_->id()) {
          std::cerr << knob_->name() << " is gone: play with mouse and keyboard\n";
          input_.lift = 0;
          knob_.reset();
          describe_input();
        }
        break;
      case SDL_JOYDEVICEADDED:
        if (!knob_ && options_.any_joystick && !options_.joystick) {
          find_knob();
          describe_input();
        }
        break;
      default:
        break;
    }
  }

  void report() {
    std::ofstream file(options_.report);
    file << "{\"frames\": " << frames_ << ", \"opened\": " << opened_
         << ", \"dropped\": " << dropped_ << ", \"set\": " << lock_.set_count
         << ", \"lift\": " << lock_.lift << ", \"knob\": ";
    if (knob_) {
      knob_->report(file);
    } else {
      file << "null";
    }
    file << "}\n";
    file.close();
    if (!file) throw std::runtime_error("cannot write " + options_.report);
  }

  Options options_;
  Screen screen_;
  std::unique_ptr<Knob> knob_;
  Lock lock_;
  Autopilot autopilot_;
  Input input_;
  Status status_;
  bool quit_ = false;
  bool paused_ = false;
  int frames_ = 0;
  int opened_ = 0;
  int dropped_ = 0;
};

}  // namespace
}  // namespace game

int main(int argc, char** argv) try {
  game::Options options;
  try {
    options = game::parse(argc, argv);
  } catch (const std::invalid_argument& error) {
    std::cerr << "lockpick: " << error.what() << " (see --help)\n";
    return 2;
  }
  if (options.help) {
    std::cout << game::kUsage;
    return 0;
  }
  const game::Sdl sdl(options.headless || options.list);
  if (options.list) {
    game::list_joysticks(std::cout);
    return 0;
  }
  // One that ends by itself may be drawn for nobody.
  if (!options.headless && !options.frames) game::Sdl::need_a_visible_display();
  return game::Game(options).run();
} catch (const std::exception& error) {
  std::cerr << "lockpick: " << error.what() << '\n';
  return 1;
}
