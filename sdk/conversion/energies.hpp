/// @file
/// From the device's ledger to joules.
#pragma once

#include "protocol/reports.hpp"
#include "torsio/telemetry.hpp"

namespace torsio::conversion {

Energies energies(const protocol::Ledger& ledger, const protocol::Identity& device);

}  // namespace torsio::conversion
