#include "module.hpp"

#include "interpreter.hpp"

PYBIND11_MODULE(_torsio, module) {
  using namespace torsio::bindings;
  module.doc() = "The C++ side of the torsio package. Use the package, not this module.";
  watch_interpreter();
  bind_errors(module);
  bind_protocol(module);
  bind_core(module);
  bind_scene(module);
  bind_emulator(module);
  bind_knob(module);
  bind_firmware(module);
  bind_watch(module);
  bind_transport(module);
}
