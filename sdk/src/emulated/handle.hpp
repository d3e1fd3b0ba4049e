/// @file
/// The user's handle to the world round an emulated knob.
#pragma once

#include <memory>

#include "emulated/shared_device.hpp"
#include "session.hpp"

namespace torsio {

std::unique_ptr<Emulator> make_handle(std::shared_ptr<SharedDevice> device, Session& session);

}  // namespace torsio
