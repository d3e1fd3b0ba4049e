/// @file
/// The Python package's data classes as the emulator's own structures.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "emulator/encoder.hpp"
#include "emulator/hand.hpp"
#include "emulator/plant.hpp"

namespace torsio::bindings {

/// @throws InvalidArgument, TypeError or std::invalid_argument that names what is wrong
emulator::Hand emulator_hand(const pybind11::object& source);

/// @param source a PlantParams of the package
/// @throws InvalidArgument or TypeError that names the class and the attribute; likewise below
emulator::PlantParams emulator_plant(const pybind11::object& source);
emulator::EncoderParams emulator_encoder(const pybind11::object& source);

/// Keys as torsio.Fidelity.
pybind11::dict fidelity_to_python(const emulator::FidelityReport& report);

/// @param source an InitialState of the package
emulator::PlantState initial_state_from_python(const pybind11::object& source);

/// @throws ValueError that lists the methods there are
emulator::Method emulator_method(const std::string& name);

}  // namespace torsio::bindings
