/// @file
/// The error of a report: the code, and the field.
#pragma once

#include <cstdint>

#include "protocol/enumerations.hpp"

namespace torsio::protocol {

/// Stands for "no field in particular" where a field's index is given.
inline constexpr std::uint8_t kNoField = 0xFF;

/// The error of a report, and its field (index in wire order, nested fields flattened).
struct Verdict {
  Status status = Status::ok;
  std::uint8_t field = kNoField;

  constexpr bool ok() const { return status == Status::ok; }
  friend constexpr bool operator==(const Verdict&, const Verdict&) = default;
};

}  // namespace torsio::protocol
