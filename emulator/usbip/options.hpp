/// @file
/// The command line of torsio_virtual_knob.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "emulator/emulated_device.hpp"
#include "protocol/reports.hpp"

namespace torsio::emulator::usbip {

/// A sentence for the user of the command line.
class BadOption : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

struct ProgramOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 3240;
  std::string serial = EmulatedDeviceOptions{}.serial;
  double rate_hz = 1e9 / protocol::emulated_control_period_ns;
  std::uint64_t seed = 0;
  std::string hand = "still";  // still, free or scripted:FILE
  std::string log;             // empty: none
  std::string storage;         // file of the knob's storage; empty: new at each start
  bool commands = false;       // follow lines from standard input, and end where they end
  bool status = false;
  bool help = false;
};

/// @param arguments without the program's name; `--name VALUE` or `--name=VALUE`
/// @throws BadOption
ProgramOptions read_options(std::span<const std::string_view> arguments);

/// The text of `--help`.
std::string usage();

/// Whether only programs of this machine can reach an address.
bool is_loopback(std::string_view address);

}  // namespace torsio::emulator::usbip
