/// @file
/// What motor and shaft spring have given to the knob, in whole numbers: sums of any length lose
/// nothing.
#pragma once

#include <cstdint>

namespace torsio::core {

/// Torques are counted in 2^-23 N m, so energies in 2^-23 N m times a count's angle.
inline constexpr float kLedgerTorquesPerNm = 0x1p23F;

struct Ledger {
  std::int64_t motor = 0;         // given to the knob
  std::int64_t spring_twice = 0;  // given to the knob, twice
  float spring_nm = 0;            // at the last tick
};

/// One tick. The motor's command was held meanwhile; the spring's torque changed evenly.
/// @param motor_held_nm, spring_nm within 100 N m
constexpr void keep_ledger(Ledger& ledger, float motor_held_nm, float spring_nm,
                           std::int32_t delta_counts) {
  if (delta_counts != 0) {
    const auto motor = static_cast<std::int32_t>(motor_held_nm * kLedgerTorquesPerNm);
    const auto twice =
        static_cast<std::int32_t>((ledger.spring_nm + spring_nm) * kLedgerTorquesPerNm);
    ledger.motor += std::int64_t{motor} * delta_counts;
    ledger.spring_twice += std::int64_t{twice} * delta_counts;
  }
  ledger.spring_nm = spring_nm;
}

/// The same in joules.
struct Energies {
  float motor_j = 0;   // given to the knob: what the motor gave
  float spring_j = 0;  // given to the knob by the shaft's spring
  float stored_j = 0;  // in the spring now
  float brake_j = 0;   // taken by the brake: what the spring was given and has not any more
};

constexpr Energies energies(const Ledger& ledger, float rad_per_count,
                            float spring_stiffness_nm_per_rad) {
  const float step_j = rad_per_count / kLedgerTorquesPerNm;
  Energies out;
  out.motor_j = static_cast<float>(ledger.motor) * step_j;
  out.spring_j = static_cast<float>(ledger.spring_twice) * (0.5F * step_j);
  if (spring_stiffness_nm_per_rad > 0.0F) {
    out.stored_j = 0.5F * ledger.spring_nm * ledger.spring_nm / spring_stiffness_nm_per_rad;
  }
  out.brake_j = -out.spring_j - out.stored_j;
  return out;
}

}  // namespace torsio::core
