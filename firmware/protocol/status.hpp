/// @file
/// Why a report was refused. The device sends the code, the SDK turns it into a sentence.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace torsio::protocol {

enum class [[nodiscard]] Status : std::uint8_t {
  ok,
  bad_length,      // not exactly report_size bytes
  bad_padding,     // bytes behind the last field are not zero: a newer layout, or garbage
  unknown_report,  // no report of this id in this direction
  not_finite,      // a NaN or an infinity
  out_of_range,    // outside the range that docs/protocol.md gives
  inconsistent,    // each field is in range, but not together
  bad_axis,        // the device has no such axis
  empty_slot,      // a commit names a slot that was never written
  not_armed,       // needs the armed state
  not_disarmed,    // needs the disarmed state
  fault_latched,   // a fault must be cleared first
  fault_persists,  // the cause of the fault is still there
  stale,           // older than what the device already has
  busy,            // the device's inbox is full; send it again
  not_owner,       // somebody else owns the actuator
  unsupported,     // this board cannot do it
};

/// Stands for "no field in particular" where a field's index is given.
inline constexpr std::uint8_t kNoField = 0xFF;

/// What is wrong with a report, and in which field (index in wire order, nested fields flattened).
struct Verdict {
  Status status = Status::ok;
  std::uint8_t field = kNoField;

  constexpr bool ok() const { return status == Status::ok; }
  friend constexpr bool operator==(const Verdict&, const Verdict&) = default;
};

}  // namespace torsio::protocol
