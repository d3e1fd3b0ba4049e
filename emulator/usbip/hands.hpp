/// @file
/// Hands on the virtual knob: from a file, and by commands.
#pragma once

#include <cstdint>
#include <istream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "emulator/emulated_device.hpp"
#include "emulator/plant/hand.hpp"

namespace torsio::emulator::usbip {

/// Error of a script, as "NAME:LINE: what".
class BadScript : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Holds the knob where it is, whatever torque that takes.
Hand still_hand(double angle_rad = 0.0);

/// An arm that means to move along a path, as stiff as one that holds a small knob firmly.
Hand firm_hand(Profile intended_angle_rad);

/// Reads a hand. The first line names the quantity: `torque_nm` on the knob, `angle_rad` where a
/// firm hand means to go, or `motion_rad`, which the knob follows exactly. Every further line is
/// one corner of a piecewise-linear path, `TIME_S VALUE`, in device time; two corners at the same
/// time make a jump, of a torque only. Text behind `#` does not count.
/// @param name of the file, for messages
/// @param start_ns time 0 of the script in device time
/// @throws BadScript
Hand read_hand(std::istream& script, const std::string& name, std::int64_t start_ns = 0);

/// Moves the hand of a running device, one line at a time: `torque NM`, `angle RAD`, `still`,
/// `free`, `script FILE`, whose time begins with the line.
class HandCommands {
 public:
  explicit HandCommands(EmulatedDevice& device) : device_(device) {}

  /// @returns false if the line is none of these, or its number is not a sensible one
  bool follow(std::string_view line);

 private:
  void move_to(double angle_rad);

  EmulatedDevice& device_;
  Profile path_ = Profile::constant(0.0);
  bool holding_ = false;
};

}  // namespace torsio::emulator::usbip
