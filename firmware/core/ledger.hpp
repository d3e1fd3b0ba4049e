/// @file
/// Energy that motor and shaft spring have given to the knob, in whole numbers. Sums of any length
/// lose nothing, and motion to and fro gives exactly nothing.
#pragma once

#include <cstdint>

namespace torsio::core {

/// Torques are counted in 2^-23 N m, so energies in 2^-23 N m times a count's angle.
inline constexpr float kLedgerTorquesPerNm = 0x1p23F;

struct Ledger {
  std::int64_t motor = 0;         // given to the knob
  std::int64_t spring_twice = 0;  // given to the knob, twice
  std::int32_t spring = 0;        // its torque on the knob at the last tick
};

/// One tick. The motor's command was held meanwhile; the spring's torque changed evenly.
/// @param motor_held_nm, spring_nm within 100 N m
constexpr void keep_ledger(Ledger& ledger, float motor_held_nm, float spring_nm,
                           std::int32_t delta_counts) {
  const auto spring = static_cast<std::int32_t>(spring_nm * kLedgerTorquesPerNm);
  if (delta_counts != 0) {
    const auto motor = static_cast<std::int32_t>(motor_held_nm * kLedgerTorquesPerNm);
    ledger.motor += std::int64_t{motor} * delta_counts;
    ledger.spring_twice += std::int64_t{ledger.spring + spring} * delta_counts;
  }
  ledger.spring = spring;
}

}  // namespace torsio::core
