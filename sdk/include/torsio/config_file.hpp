/// @file
/// A knob's whole configuration as a text to keep: the JSON that `torsio config dump` prints and
/// `torsio config load` takes.
#pragma once

#include <string>
#include <string_view>

#include "torsio/export.hpp"
#include "torsio/knob.hpp"

namespace torsio {

/// The configuration that the knob has: an object for each of KnobConfigurations, as in
/// `actuator_config`, with its fields by name.
/// @throws what Knob::actuator_config() does
[[nodiscard]] TORSIO_EXPORT std::string dump_config(Knob& knob);

/// Sets what such a text has, and saves it. Fields that it does not name stay. If the knob refuses
/// a part, or the program is interrupted meanwhile, everything stays.
/// @throws InvalidArgument it is no such text, or has a field or a value that the knob does not
///         take; Refused somebody has the actuator
TORSIO_EXPORT void load_config(Knob& knob, std::string_view text);

}  // namespace torsio
