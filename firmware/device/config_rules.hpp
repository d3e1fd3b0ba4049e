/// @file
/// Rules across the fields of a configuration: what no single field's range can say.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include "protocol/configuration.hpp"
#include "protocol/status.hpp"

namespace torsio::device {

protocol::Verdict check_consistent(const protocol::ActuatorConfig& config);
protocol::Verdict check_consistent(const protocol::ShaftConfig& config);

}  // namespace torsio::device
