/// @file
/// What the files of the extension module torsio_studies._studies share: one function per area.
#pragma once

#include <pybind11/pybind11.h>

namespace torsio::studies::bindings {

namespace py = pybind11;
using py::arg;

void bind_actuators(py::module_& module);
void bind_foreign_stepper(py::module_& module);
void bind_steppers(py::module_& module);
void bind_wide(py::module_& module);

}  // namespace torsio::studies::bindings
