/// @file
/// A configuration's two slots, each at the start of a sector of the flash: the last two, or with
/// another pair the two before. A power cut spoils at most the one that is being written.
#pragma once

#include <cstdint>

#include "device/config_store.hpp"

namespace torsio::boards {

/// Where they are, past the flash's cache.
device::SlotViews slots(std::uint8_t pair = 0);

/// Erases the slot's sector and writes it. Takes up to half a second, in which interrupts go on:
/// the program runs from RAM.
/// @returns false if the flash does not hold the bytes afterwards
bool write_slot(const device::SlotWrite& write, std::uint8_t pair = 0);

}  // namespace torsio::boards
