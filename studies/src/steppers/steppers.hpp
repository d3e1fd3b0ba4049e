/// @file
/// Other ways to take the plant through time, to compare the emulator's exact one with.
#pragma once

#include <memory>
#include <string>

#include "emulator/plant/stepper.hpp"

namespace torsio::studies {

/// theta-method with set-valued friction.
/// @param theta 1 is semi-implicit, 1/2 the trapezoid rule
[[nodiscard]] std::unique_ptr<emulator::Stepper> make_theta_stepper(emulator::PlantModel model,
                                                                    double theta);

/// Runge-Kutta 4 over friction that is smoothed around rest; see regularised.cpp for what it is
/// for.
/// @param smoothing_rad_s speed over which friction is smoothed, > 0
/// @throws std::invalid_argument if it is not
[[nodiscard]] std::unique_ptr<emulator::Stepper> make_regularised_stepper(
    emulator::PlantModel model, double smoothing_rad_s);

/// Speed over which `regularised` smooths friction.
inline constexpr double kSmoothingRadS = 0.01;

/// @param name "exact_single" (the emulator's own, in 32-bit floating point), "trapezoid",
///             "semi_implicit" or "regularised"
/// @throws std::invalid_argument that lists the names
[[nodiscard]] emulator::MakeStepper stepper_by_name(const std::string& name);

}  // namespace torsio::studies
