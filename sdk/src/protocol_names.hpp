/// @file
/// Numbers of the protocol in words, for messages.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/status.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

/// "not_armed", as docs/reference/protocol.md calls it; "status 99" if this library does not know
/// it.
std::string status_name(std::uint8_t status);

/// Meaning of the status, and advice.
std::string_view status_advice(std::uint8_t status);

/// "wall"; "report 0x7f" if there is none.
std::string report_name(std::uint8_t id);

/// "stiffness_nm_per_rad"; empty if there is no such field.
std::string report_field_name(std::uint8_t report_id, std::uint8_t field);

/// Names of the bits of a `faults` field.
std::vector<std::string> fault_names(std::uint16_t faults);

/// "watchdog"; "event 9" if this library does not know it.
std::string event_kind_name(std::uint8_t kind);

/// "watchdog".
std::string disarm_reason_name(DisarmReason reason);

/// A sentence that says when and why the torque went.
std::string disarm_text(const Disarm& disarm);

/// "0x1a2b3c4d".
std::string hex32(std::uint32_t value);

}  // namespace torsio
