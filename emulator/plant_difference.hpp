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

[[nodiscard]] FidelityAccount::Error larger(const FidelityAccount::Error& a,
                                            const FidelityAccount::Error& b);
[[nodiscard]] FidelityAccount::Error scaled(const FidelityAccount::Error& error, double factor);

/// Whether a difference in the knob's angle may last or grow: nothing holds or leads the knob, or
/// less firmly than cogging falls away along the turn.
[[nodiscard]] bool nothing_brings_back(const PlantModel& model);

/// Whether the way from a to b is not smooth: friction caught or let go, or a piecewise linear law
/// went on to another piece.
[[nodiscard]] bool kinks(const PlantModel& model, const PlantState& a, const PlantState& b);

}  // namespace torsio::emulator
