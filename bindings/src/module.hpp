/// @file
/// What the files of the extension module share: one function per area, called in order of need.
#pragma once

#include <pybind11/pybind11.h>

namespace torsio::bindings {

void bind_errors(pybind11::module_& module);
void bind_protocol(pybind11::module_& module);
void bind_core(pybind11::module_& module);
void bind_scene(pybind11::module_& module);
void bind_emulator(pybind11::module_& module);
void bind_closed_loop(pybind11::module_& emulator);
void bind_batch(pybind11::module_& emulator);
void bind_knob(pybind11::module_& module);
void bind_firmware(pybind11::module_& module);
void bind_watch(pybind11::module_& module);
void bind_transport(pybind11::module_& module);

}  // namespace torsio::bindings
