/// @file
/// The method by which the plant is stepped.
#pragma once

#include <cstdint>
#include <memory>

#include "emulator/plant/stepper.hpp"

namespace torsio::emulator {

/// Exact up to rounding: matrix exponentials between located events.
/// @param step_ns the duration that most steps have; others are as exact, and slower
/// @throws std::invalid_argument if the plant moves too fast for any such step
[[nodiscard]] std::unique_ptr<Stepper> make_exact_stepper(PlantModel model, std::int64_t step_ns);

}  // namespace torsio::emulator
