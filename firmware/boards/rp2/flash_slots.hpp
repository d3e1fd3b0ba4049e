/// @file
/// The configuration's two slots, each at the start of one of the last two sectors of the flash. A
/// power cut spoils at most the one that is being written.
#pragma once

#include "device/config_store.hpp"

namespace torsio::boards {

/// Where they are, past the flash's cache.
device::SlotViews slots();

/// Erases the slot's sector and writes it. Takes up to half a second, in which interrupts go on:
/// the program runs from RAM.
/// @returns false if the flash does not hold the bytes afterwards
bool write_slot(const device::SlotWrite& write);

}  // namespace torsio::boards
