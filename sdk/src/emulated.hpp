/// @file
/// Emulated knobs.
#pragma once

#include <string_view>

namespace torsio {

/// The selector of an emulated knob, its transport, and the board of one and of a virtual knob.
inline constexpr std::string_view kEmulated = "emulated";

/// Whether a selector means an emulated knob, with a name or without.
constexpr bool selects_emulated(std::string_view selector) {
  return selector.substr(0, selector.find(':')) == kEmulated;
}

}  // namespace torsio
