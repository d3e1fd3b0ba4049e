#include "emulator/usbip/options.hpp"

#include <charconv>
#include <cmath>
#include <string>

namespace torsio::emulator::usbip {
namespace {

template <class Number>
Number number(std::string_view name, std::string_view text, Number lowest, Number highest) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  // The comparisons are also false for NaN.
  if (error == std::errc{} && end == text.data() + text.size() && value >= lowest &&
      value <= highest) {
    return value;
  }
  throw BadOption(std::string(name) + " is \"" + std::string(text) + "\", must be a number from " +
                  std::to_string(lowest) + " to " + std::to_string(highest));
}

void set_hand(ProgramOptions& options, std::string_view value) {
  const bool known = value == "still" || value == "free" || value == "pushes" ||
                     (value.starts_with("scripted:") && value != "scripted:");
  if (!known) {
    throw BadOption("--hand is \"" + std::string(value) +
                    "\", must be still, free, pushes or scripted:FILE");
  }
  options.commands = options.commands || value == "pushes";
  options.hand = value == "pushes" ? "free" : value;
}

void set(ProgramOptions& options, std::string_view name, std::string_view value) {
  if (name == "--address") {
    options.address = value;
  } else if (name == "--port") {
    options.port = number<std::uint16_t>(name, value, 0, 65'535);
  } else if (name == "--serial") {
    options.serial = value;
  } else if (name == "--rate-hz") {
    options.rate_hz =
        number<double>(name, value, protocol::min_control_rate_hz, protocol::max_control_rate_hz);
  } else if (name == "--seed") {
    options.seed = number<std::uint64_t>(name, value, 0, UINT64_MAX);
  } else if (name == "--hand") {
    set_hand(options, value);
  } else if (name == "--log") {
    options.log = value;
  } else if (name == "--storage") {
    options.storage = value;
  } else {
    throw BadOption("there is no option \"" + std::string(name) + "\"; see --help");
  }
}

bool* find_flag(ProgramOptions& options, std::string_view name) {
  if (name == "--commands") return &options.commands;
  if (name == "--status") return &options.status;
  if (name == "--help") return &options.help;
  return nullptr;
}

}  // namespace

ProgramOptions read_options(std::span<const std::string_view> arguments) {
  ProgramOptions options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (bool* flag = find_flag(options, argument)) {
      *flag = true;
      continue;
    }
    const std::size_t equals = argument.find('=');
    if (equals != std::string_view::npos) {
      const std::string_view name = argument.substr(0, equals);
      if (find_flag(options, name) != nullptr) {
        throw BadOption(std::string(name) + " takes no value");
      }
      set(options, name, argument.substr(equals + 1));
      continue;
    }
    if (i + 1 == arguments.size()) {
      set(options, argument, "");  // says it if there is no such option
      throw BadOption(std::string(argument) + " needs a value");
    }
    set(options, argument, arguments[++i]);
  }
  return options;
}

std::string usage() {
  const auto hz = [](double rate) { return std::to_string(std::llround(rate)); };
  return R"(usage: torsio_virtual_knob [OPTIONS]

A virtual knob as a USB device, served over USB/IP.

  --address ADDRESS  IPv4 address to listen on (127.0.0.1)
  --port PORT        TCP port; 0 for any free one (3240)
  --serial TEXT      serial number, 1 to 16 printable characters (EMULATED)
  --rate-hz HZ       control rate, )" +
         hz(protocol::min_control_rate_hz) + " to " + hz(protocol::max_control_rate_hz) + " (" +
         hz(ProgramOptions{}.rate_hz) + R"()
  --seed NUMBER      of everything random (0)
  --hand HAND        still, free, scripted:FILE, or pushes: free and --commands (still)
  --storage FILE     keep there what is saved on the knob, and start with it
  --commands         follow lines from standard input, and end where they end
  --log FILE         write the plant's truth at every control tick
  --status           print how the knob is, ten times a second
  --help             print this
)";
}

bool is_loopback(std::string_view address) { return address.starts_with("127."); }

}  // namespace torsio::emulator::usbip
