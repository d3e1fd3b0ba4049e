/// @file
/// Shared by the files of the extension module: one function per area, called in order of need.
#pragma once

#include <pybind11/pybind11.h>

namespace torsio::bindings {

namespace py = pybind11;
using py::arg;

void bind_errors(py::module_& module);
void bind_protocol(py::module_& module);
void bind_core(py::module_& module);
void bind_scene(py::module_& module);
void bind_emulator(py::module_& module);
void bind_closed_loop(py::module_& emulator);
void bind_batch(py::module_& emulator);
void bind_knob(py::module_& module);
void bind_firmware(py::module_& module);
void bind_watch(py::module_& module);
void bind_transport(py::module_& module);

}  // namespace torsio::bindings
