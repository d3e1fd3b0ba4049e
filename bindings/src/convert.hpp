/// @file
/// The Python package's data classes as the SDK's structures. Python has them as frozen data
/// classes, so that type checkers, `repr` and `==` work without help; they are read by attribute.
#pragma once

#include <pybind11/pybind11.h>

#include "torsio/config.hpp"
#include "torsio/emulator.hpp"
#include "torsio/knob.hpp"
#include "torsio/scene.hpp"

namespace torsio::bindings {

/// @throws InvalidArgument or TypeError that names the class and the attribute; likewise below
Effect effect_from_python(const pybind11::handle& source);

/// @param source one effect or an iterable of effects
Scene scene_from_python(const pybind11::handle& source);

Hand hand_from_python(const pybind11::handle& source);
Profile profile_from_python(const pybind11::handle& source);
PlantParams plant_from_python(const pybind11::handle& source);
ActuatorConfig actuator_config_from_python(const pybind11::handle& source);
ControlConfig control_config_from_python(const pybind11::handle& source);
BoardConfig board_config_from_python(const pybind11::handle& source);
GameConfig game_config_from_python(const pybind11::handle& source);

pybind11::dict to_python(const ActuatorConfig& config);
pybind11::dict to_python(const ControlConfig& config);
pybind11::dict to_python(const BoardConfig& config);
pybind11::dict to_python(const GameConfig& config);
pybind11::dict to_python(const ListedDevice& device);

}  // namespace torsio::bindings
