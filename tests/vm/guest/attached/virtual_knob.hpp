/// @file
/// A virtual USB knob as this computer has it plugged in: the program that serves it over USB/IP,
/// and the port of the kernel's virtual host controller. Needs root and vhci_hcd.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace torsio::test {

class VirtualKnob {
 public:
  /// Starts `$TORSIO_VIRTUAL_KNOB` and plugs it in.
  /// @throws std::runtime_error if that takes longer than half a minute
  explicit VirtualKnob(const std::vector<std::string>& arguments);
  VirtualKnob(const VirtualKnob&) = delete;
  VirtualKnob& operator=(const VirtualKnob&) = delete;
  /// Unplugs it and ends the program; aborts the process if the program did not end well.
  ~VirtualKnob();

  void plug();
  /// As pulling the cable; returns when the kernel knows.
  void unplug();
  /// Sends a line to the program.
  void say(const std::string& line) const;
  /// Such as "1-1": how the kernel names the device.
  [[nodiscard]] const std::string& bus_id() const { return bus_id_; }

 private:
  void read_address();
  [[nodiscard]] bool is_bound(int interface) const;

  pid_t program_ = -1;
  int input_ = -1;   // the program's
  int output_ = -1;  // the program's
  int tcp_port_ = 0;
  int vhci_port_ = -1;
  std::string bus_id_;
};

}  // namespace torsio::test
