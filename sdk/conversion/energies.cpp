#include "conversion/energies.hpp"

#include <numbers>

#include "core/ledger.hpp"

namespace torsio::conversion {

Energies energies(const protocol::Ledger& ledger, std::uint32_t counts_per_rev,
                  double control_rate_hz) {
  constexpr double torque_nm = 1.0 / core::kLedgerTorquesPerNm;
  const double step_j = torque_nm * 2.0 * std::numbers::pi / counts_per_rev;
  Energies out{};
  out.tick = ledger.tick;
  out.time_s = static_cast<double>(ledger.tick) / control_rate_hz;
  out.kept = ledger.kept == protocol::Toggle::on;
  out.motor_j = static_cast<double>(ledger.motor) * step_j;
  const double spring_j = static_cast<double>(ledger.spring_twice) * 0.5 * step_j;
  out.felt_j = out.motor_j + spring_j;
  out.stored_j = static_cast<double>(ledger.stored_j);
  // What the spring was given and has not any more.
  out.brake_j = -spring_j - out.stored_j;
  out.bound_nm_per_rad = static_cast<double>(ledger.bound_nm_per_rad);
  return out;
}

}  // namespace torsio::conversion
