/// @file
/// The Python package's data classes as the emulator's own structures.
#pragma once

#include <pybind11/pybind11.h>

#include "emulator/closed_loop_options.hpp"
#include "emulator/plant/hand.hpp"
#include "emulator/plant/plant.hpp"

namespace torsio::bindings {

/// @throws InvalidArgument, TypeError or std::invalid_argument that names what is wrong
emulator::Hand emulator_hand(const pybind11::object& source);

/// @param source a LoopOptions of the package
emulator::ClosedLoopOptions loop_options_from_python(const pybind11::object& source);

/// @param source an InitialState of the package
emulator::PlantState initial_state_from_python(const pybind11::object& source);

}  // namespace torsio::bindings
