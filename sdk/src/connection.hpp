/// @file
/// Parts of a knob: the way to a device, and facts known beforehand.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "torsio/emulator.hpp"
#include "torsio/transport.hpp"

namespace torsio {

class Link;

struct Connection {
  std::unique_ptr<Transport> transport;
  std::string kind;  ///< DeviceInfo::transport
  std::string path;
  std::string product;
  /// Makes the user's handle on the world round an emulated device; empty for other devices. The
  /// link must outlive it.
  std::function<std::unique_ptr<Emulator>(Link&)> make_emulator{};
};

}  // namespace torsio
