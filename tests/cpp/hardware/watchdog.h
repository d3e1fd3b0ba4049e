/// @file
/// The watchdog as numbers; see fake.hpp.
#pragma once

#include "hardware/structs/watchdog.h"

// NOLINTBEGIN: these names are the SDK's.
inline void watchdog_enable(std::uint32_t time_ms, bool) { fake::watchdog.time_ms = time_ms; }
inline void watchdog_update() { ++fake::watchdog.updates; }
// NOLINTEND
