/// @file
/// What the files of the extension module torsio_studies._studies share: one function per area.
#pragma once

#include <pybind11/pybind11.h>

namespace torsio::studies::bindings {

void bind_actuators(pybind11::module_& module);
void bind_foreign_stepper(pybind11::module_& module);
void bind_steppers(pybind11::module_& module);
void bind_wide(pybind11::module_& module);

}  // namespace torsio::studies::bindings
