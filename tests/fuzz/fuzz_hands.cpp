// Scripts of hands and the lines that move a hand while the knob runs. An input whose first byte is
// even is a script, any other one is a row of lines of commands.
#include <sstream>
#include <string>
#include <string_view>

#include "emulator/usbip/hands.hpp"
#include "fuzz.hpp"

namespace {

using namespace torsio::emulator;
using namespace torsio::emulator::usbip;

constexpr std::string_view kWords[] = {
    "torque_nm\n", "angle_rad\n", "motion_rad\n", "torque ", "angle ", "still\n", "free\n",
    "script ",     "0 0\n",       "1e6 ",         "-1e6",    "1e308",  "nan",     "inf",
    "-0",          " # x\n",      "0.05 0.01\n",  "\t",      "\r\n",   "1e-9 ",   "10\n"};

}  // namespace

std::span<const std::string_view> fuzz::dictionary() { return kWords; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  if (data[0] % 2 == 0) {
    std::istringstream script(text);
    try {
      validate(read_hand(script, "script"));
    } catch (const BadScript& error) {
      fuzz::require(std::string_view(error.what()).starts_with("script:"), "it says where");
    }
    return 0;
  }
  EmulatedDevice device;
  HandCommands commands(device);
  std::istringstream lines(text);
  std::string line;
  for (int left = 16; left > 0 && std::getline(lines, line); --left) {
    // No file of this machine is an input.
    if (line.find("script") != std::string::npos) continue;
    if (!commands.follow(line)) continue;  // a refused line moves no hand
    device.advance(1'000'000);
    fuzz::require(std::abs(device.plant().state().knob_angle_rad()) <= 1e9,
                  "the knob is somewhere");
  }
  return 0;
}
