/// @file
/// A firmware file's label for its readers: `torsio firmware update` does.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "protocol/registry.hpp"

namespace torsio::boards {

/// Stands somewhere in the image; the mark finds it. sdk/src/firmware_file.cpp reads it.
struct FirmwareLabel {
  std::array<char, 16> mark{};  // "torsio firmware"
  std::uint32_t fingerprint = 0;
  std::array<std::uint8_t, 3> version{};
  std::uint8_t unused = 0;
  std::array<char, 16> board{};  // its name, filled up with zeros
  // CRC-32 of the image with 0 in this place; tools/uf2.py writes it.
  std::uint32_t checksum = 0;
};
static_assert(sizeof(FirmwareLabel) == 44);

consteval FirmwareLabel make_firmware_label(std::string_view board,
                                            std::array<std::uint8_t, 3> version) {
  FirmwareLabel label;
  std::ranges::copy(std::string_view("torsio firmware"), label.mark.begin());
  std::ranges::copy(board, label.board.begin());
  label.fingerprint = protocol::fingerprint();
  label.version = version;
  return label;
}

/// Keeps the label in the program, which has no use for it itself.
inline void keep(const FirmwareLabel& label) { asm volatile("" : : "r"(&label)); }

}  // namespace torsio::boards
