#include "game/options.hpp"

#include <charconv>
#include <stdexcept>
#include <string_view>

namespace game {

const char* const kUsage =
    R"(usage: lockpick [OPTIONS]

Pick a lock with a force feedback knob, or with the mouse where there is none.
  turn the knob right / mouse up / arrow up   lift the pin
  button 1, 2 / mouse buttons / arrows        next pin, pin before
  P, Escape                                   pause, quit

  --joystick N       play with joystick N of --list; without: the first one named Torsio
  --no-joystick      play with mouse and keyboard
  --no-haptic        use the joystick's axis, but no forces
  --range-deg DEG    what the joystick turns from end to end of its axis; default 900
  --list             list joysticks and the force effects that they have, and end
  --seed N           which lock comes first; default 1
  --autopilot        let the program play, by what the knob would feel
  --headless         no window, and a clock that does not wait; --autopilot unless --joystick is given
  --frames N         end after N frames of 1/60 s; headless default: when the lock is open
  --screenshot FILE  write the last frame as a BMP file
  --report FILE      write what happened as JSON
)";

namespace {

template <class Number>
Number number(std::string_view option, std::string_view text, Number least, Number most) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  // Written so that it is false for NaN.
  if (error != std::errc{} || stopped != end || !(value >= least && value <= most)) {
    throw std::invalid_argument(std::string(option) + " wants a number from " +
                                std::to_string(least) + " to " + std::to_string(most) + ", not '" +
                                std::string(text) + "'");
  }
  return value;
}

}  // namespace

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view option = argv[i];
    const auto value = [&]() -> std::string_view {
      if (i + 1 == argc) throw std::invalid_argument(std::string(option) + " wants a value");
      return argv[++i];
    };
    if (option == "--help" || option == "-h") {
      options.help = true;
    } else if (option == "--list") {
      options.list = true;
    } else if (option == "--headless") {
      options.headless = true;
    } else if (option == "--autopilot") {
      options.autopilot = true;
    } else if (option == "--no-haptic") {
      options.haptic = false;
    } else if (option == "--no-joystick") {
      options.any_joystick = false;
    } else if (option == "--joystick") {
      options.joystick = number(option, value(), 0, 255);
    } else if (option == "--frames") {
      options.frames = number(option, value(), 1, 10'000'000);
    } else if (option == "--range-deg") {
      options.range_deg = number(option, value(), 10.0F, 36000.0F);
    } else if (option == "--seed") {
      options.seed = number<std::uint32_t>(option, value(), 0, UINT32_MAX);
    } else if (option == "--screenshot") {
      options.screenshot = value();
    } else if (option == "--report") {
      options.report = value();
    } else {
      throw std::invalid_argument("unknown option '" + std::string(option) + "'");
    }
  }
  if (options.headless && !options.joystick) {
    options.autopilot = true;
    options.any_joystick = false;
  }
  return options;
}

}  // namespace game
