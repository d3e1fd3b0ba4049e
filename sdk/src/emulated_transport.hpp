/// @file
/// The emulated knob behind the same interface as the real one: exactly the same bytes travel.
#pragma once

#include <memory>
#include <string>

#include "torsio/emulator.hpp"
#include "transport.hpp"

namespace torsio {

class Session;
class EmulatedWorld;

struct EmulatedConnection {
  std::shared_ptr<EmulatedWorld> world;
  std::unique_ptr<Transport> transport;
};

/// Powers up an emulated knob.
/// @param name a named one keeps what it has stored while the process lives, and can be open once;
///        an unnamed one is new each time
/// @throws InvalidArgument, DeviceBusy
EmulatedConnection open_emulated(const std::string& name, const EmulatorOptions& options);

/// The user's handle on the world; `session` must outlive it.
std::unique_ptr<Emulator> make_emulator(std::shared_ptr<EmulatedWorld> world, Session& session);

}  // namespace torsio
