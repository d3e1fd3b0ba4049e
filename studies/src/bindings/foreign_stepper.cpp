// torsio_studies._studies.drive_foreign: another simulator's step function in a compiled loop, so
// that comparing it with ours does not count the cost of Python against it. The function and its
// inputs and outputs come as addresses; nothing here knows the other simulator.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>

#include "bindings/module.hpp"

namespace torsio::studies::bindings {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Step = void (*)(const void* model, void* data);

py::array_t<double> drive_foreign(std::uintptr_t step, std::uintptr_t model, std::uintptr_t data,
                                  std::uintptr_t torque, std::uintptr_t friction,
                                  std::uintptr_t angles, const Doubles& torque_nm,
                                  const Doubles& friction_nm, std::int64_t steps_per_row) {
  if (torque_nm.ndim() != 1 || friction_nm.ndim() != 1 || torque_nm.size() != friction_nm.size()) {
    throw py::value_error("the inputs must have one dimension and the same length");
  }
  if (steps_per_row < 1 || torque_nm.size() % steps_per_row != 0) {
    throw py::value_error("steps_per_row must divide the number of steps");
  }
  const auto call = reinterpret_cast<Step>(step);
  const auto* of_model = reinterpret_cast<const void*>(model);
  auto* of_data = reinterpret_cast<void*>(data);
  auto* to_torque = reinterpret_cast<double*>(torque);
  auto* to_friction = reinterpret_cast<double*>(friction);
  const auto* from = reinterpret_cast<const double*>(angles);
  const double* torques = torque_nm.data();
  const double* frictions = friction_nm.data();
  const py::ssize_t rows = torque_nm.size() / steps_per_row;
  py::array_t<double> result({rows, py::ssize_t{2}});
  double* row = result.mutable_data();
  const py::gil_scoped_release release;
  for (py::ssize_t i = 0; i < rows; ++i) {
    for (std::int64_t j = 0; j < steps_per_row; ++j) {
      *to_torque = *torques++;
      *to_friction = *frictions++;
      call(of_model, of_data);
    }
    *row++ = from[0];
    *row++ = from[1];
  }
  return result;
}

}  // namespace

void bind_foreign_stepper(py::module_& module) {
  module.def("drive_foreign", &drive_foreign, py::kw_only(), arg("step"), arg("model"), arg("data"),
             arg("torque"), arg("friction"), arg("angles"), arg("torque_nm"), arg("friction_nm"),
             arg("steps_per_row"),
             "Call step(model, data) again and again; two doubles at `angles` after each row.");
}

}  // namespace torsio::studies::bindings
