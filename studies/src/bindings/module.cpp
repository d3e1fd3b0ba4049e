#include "bindings/module.hpp"

PYBIND11_MODULE(_studies, module) {
  using namespace torsio::studies::bindings;
  module.doc() = "The C++ side of the torsio_studies package. Use the package, not this module.";
  bind_actuators(module);
  bind_foreign_stepper(module);
  bind_steppers(module);
  bind_wide(module);
}
