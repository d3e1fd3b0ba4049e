// torsio_studies._studies.stepper: other steppers, as torsio.emulator takes them.
#include "steppers/steppers.hpp"

#include <pybind11/pybind11.h>

#include <string>

#include "bindings/module.hpp"
#include "bindings/src/stepper_capsule.hpp"

namespace torsio::studies::bindings {

void bind_steppers(py::module_& module) {
  module.def(
      "stepper",
      [](const std::string& name) {
        return torsio::bindings::stepper_capsule(stepper_by_name(name));
      },
      arg("name"),
      "A stepper for torsio.emulator: exact_single, trapezoid, semi_implicit or regularised.");
}

}  // namespace torsio::studies::bindings
