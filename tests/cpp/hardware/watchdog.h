/// @file
/// The watchdog as numbers; see fake.hpp.
#pragma once

#include "hardware/structs/watchdog.h"

// NOLINTBEGIN: these names are the SDK's.
inline void watchdog_enable(std::uint32_t time_ms, bool) {
  fake::watchdog.time_ms = time_ms;
  fake::watchdog.scratch[4] = fake::kEnabled;
}
inline bool watchdog_enable_caused_reboot() {
  return fake::watchdog.reason != 0 && fake::watchdog.scratch[4] == fake::kEnabled;
}
inline void watchdog_update() { ++fake::watchdog.updates; }
// NOLINTEND
