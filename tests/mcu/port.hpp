/// @file Services for a program on a bare processor in an emulator.
#pragma once

#include <cstdint>

namespace torsio::mcu {

/// Writes a line.
void print(const char* text);
void print(std::uint32_t number);

/// Instructions executed so far, modulo 2^32; 0 without a counter.
std::uint32_t instructions();

}  // namespace torsio::mcu
