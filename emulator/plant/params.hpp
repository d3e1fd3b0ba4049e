/// @file
/// The plant's checks of its parameters, which emulator/definition/ lists. In symbols:
///
///     JA wA' = Thand + Tm - K (thA - thB) - c (wA - wB) - bA wA - fA sgn(wA)
///     JB wB' =              K (thA - thB) + c (wA - wB) - bB wB - (Tb + drag) sgn(wB)
///     Tm' = (Tm_command - Tm) / tau_m,      Tb' = (Tb_command - Tb) / tau_b
///
/// with sgn set-valued at rest: friction truly holds. Without spring and brake the shafts are one
/// rigid body that carries the sums of inertia, viscous and Coulomb friction.
#pragma once

#include "torsio/plant.hpp"

namespace torsio::emulator {

using torsio::Belt;
using torsio::BrakeHysteresis;
using torsio::Cogging;
using torsio::CurrentSensorState;
using torsio::Electrics;
using torsio::ElectricsState;
using torsio::EncoderRounding;
using torsio::IndexPulse;
using torsio::PlantParams;
using torsio::ShaftHardening;

/// @throws std::invalid_argument that names the field, its range and its value
void validate(const PlantParams& params);

/// A sine wave of `points` corners a period.
[[nodiscard]] Cogging sine_cogging(int periods_per_rev, double amplitude_nm, int points = 16);

}  // namespace torsio::emulator
