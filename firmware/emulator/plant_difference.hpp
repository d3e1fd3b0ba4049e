#pragma once

#include "emulator/fidelity.hpp"
#include "emulator/plant_model.hpp"
#include "emulator/plant_state.hpp"

namespace torsio::emulator {

/// a - b, however many turns away from zero both are.
[[nodiscard]] double angle_between(const Angle& a, const Angle& b);

/// By how much two motions differ at one moment, in what errors are measured by.
[[nodiscard]] FidelityAccount::Error between(const PlantModel& model, const PlantState& a,
                                             const PlantState& b);

/// What may come of that difference, with all of its energy in the shaft spring.
[[nodiscard]] FidelityAccount::Error bound_between(const PlantModel& model, const PlantState& a,
                                                   const PlantState& b);

/// Whether the way from a to b is not smooth: friction caught or let go, or a piecewise linear law
/// went on to another piece.
[[nodiscard]] bool kinks(const PlantModel& model, const PlantState& a, const PlantState& b);

}  // namespace torsio::emulator
