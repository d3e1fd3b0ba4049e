/// @file
/// The emulated knob behind the same interface as the real one: exactly the same bytes travel.
#pragma once

#include <string>

#include "connection.hpp"
#include "torsio/emulator.hpp"

namespace torsio {

/// False in a build without the emulator.
[[nodiscard]] bool has_emulator() noexcept;

/// Powers up an emulated knob.
/// @param name a named one keeps what it has stored while the process lives, and can be open once;
///        an unnamed one is new each time
/// @throws InvalidArgument, DeviceBusy; Error if there is no emulator
Connection open_emulated(const std::string& name, const EmulatorOptions& options);

}  // namespace torsio
