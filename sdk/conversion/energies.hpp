/// @file
/// From the device's ledger to joules.
#pragma once

#include <cstdint>

#include "protocol/reports.hpp"
#include "torsio/telemetry.hpp"

namespace torsio::conversion {

Energies energies(const protocol::Ledger& ledger, std::uint32_t counts_per_rev,
                  double control_rate_hz);

}  // namespace torsio::conversion
