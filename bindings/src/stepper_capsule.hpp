/// @file
/// Steppers that another extension module brings, as Python capsules. C++ objects go across, so
/// both modules must be built alike; the capsule's name says how.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "emulator/plant/exact/stepper.hpp"

namespace torsio::bindings {

inline const char* stepper_capsule_name() {
  static const std::string name =
      "torsio stepper, " + std::to_string(sizeof(emulator::PlantModel)) + " " +
      std::to_string(sizeof(emulator::PlantState)) + " " +
      std::to_string(sizeof(emulator::HeldInputs)) + ", compiler " + __VERSION__;
  return name.c_str();
}

inline pybind11::capsule stepper_capsule(emulator::MakeStepper make) {
  const auto drop = [](PyObject* capsule) {
    delete static_cast<emulator::MakeStepper*>(
        PyCapsule_GetPointer(capsule, PyCapsule_GetName(capsule)));
  };
  return pybind11::capsule(new emulator::MakeStepper(std::move(make)), stepper_capsule_name(),
                           drop);
}

/// @param source a capsule, or None for the exact stepper
/// @throws TypeError or ValueError that says what is wrong with it
inline emulator::MakeStepper stepper_from_python(const pybind11::object& source) {
  if (source.is_none()) return emulator::make_exact_stepper;
  if (!PyCapsule_CheckExact(source.ptr())) {
    throw pybind11::type_error(
        std::string("stepper must be a capsule of another extension module or None, is of class ") +
        Py_TYPE(source.ptr())->tp_name);
  }
  if (PyCapsule_IsValid(source.ptr(), stepper_capsule_name()) == 0) {
    throw pybind11::value_error(
        "stepper comes from a module with other sources or another compiler than this one; build "
        "both anew");
  }
  return *static_cast<emulator::MakeStepper*>(
      PyCapsule_GetPointer(source.ptr(), stepper_capsule_name()));
}

}  // namespace torsio::bindings
