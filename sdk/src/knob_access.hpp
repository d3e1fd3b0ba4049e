/// @file
/// The way past discovery, for discovery itself and for tests with fake transports.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "torsio/knob.hpp"
#include "transport.hpp"

namespace torsio {

class EmulatedWorld;

struct Connection {
  std::unique_ptr<Transport> transport;
  std::shared_ptr<EmulatedWorld> world;  ///< null for hardware
  std::string path;
  std::string product;
};

struct KnobAccess {
  /// Checks that both ends speak the same protocol and makes a knob of the connection.
  /// @throws ProtocolMismatch, Error, Disconnected
  static Knob open(Connection connection, const OpenOptions& options);
};

}  // namespace torsio
