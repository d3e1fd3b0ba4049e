/// @file
/// The user's handle to the world round an emulated knob.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "emulated/shared_device.hpp"

namespace torsio {

/// @param sleep lets so many nanoseconds pass
std::unique_ptr<Emulator> make_handle(std::shared_ptr<SharedDevice> device,
                                      std::function<void(std::int64_t)> sleep);

}  // namespace torsio
