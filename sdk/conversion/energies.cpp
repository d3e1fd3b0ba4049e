#include "conversion/energies.hpp"

#include <numbers>

#include "conversion/reading.hpp"
#include "core/ledger.hpp"

namespace torsio::conversion {

Energies energies(const protocol::Ledger& ledger, const protocol::Identity& device) {
  constexpr double torque_nm = 1.0 / core::kLedgerTorquesPerNm;
  const double step_j = torque_nm * 2.0 * std::numbers::pi / device.counts_per_rev;
  auto out = read<Energies>(ledger, device);
  out.time_s = conversion::time_s(ledger.tick, device);
  out.motor_j = static_cast<double>(ledger.motor) * step_j;
  const double spring_j = static_cast<double>(ledger.spring_twice) * 0.5 * step_j;
  out.felt_j = out.motor_j + spring_j;
  // Energy that the spring got and no longer has.
  out.brake_j = -spring_j - out.stored_j;
  return out;
}

}  // namespace torsio::conversion
