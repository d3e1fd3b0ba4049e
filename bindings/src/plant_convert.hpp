/// @file
/// The package's PlantParams as the SDK's structure or the emulator's own, whose fields have the
/// same names.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <string_view>
#include <utility>

#include "attributes.hpp"

namespace torsio::bindings {

/// Those of the encoder, which both enumerations have in this order.
inline constexpr std::array<std::string_view, 2> rounding_names{"floor", "nearest"};

template <class Plant>
void read_parts(const Attributes& from, Plant& plant) {
  namespace py = pybind11;
  plant.spring_and_brake = from.boolean("spring_and_brake");
  const auto given = [&](const char* name) { return !from.get(name).is_none(); };
  if (given("shaft_hardening")) {
    const py::object source = from.get("shaft_hardening");
    const Attributes part(source);
    plant.shaft_hardening = {part.number("knee_rad"), part.number("stiffness_factor")};
  }
  if (given("brake_hysteresis")) {
    const py::object source = from.get("brake_hysteresis");
    plant.brake_hysteresis = {Attributes(source).number("half_width_nm")};
  }
  if (given("belt")) {
    const py::object source = from.get("belt");
    const Attributes part(source);
    plant.belt = {part.number("stiffness_nm_per_rad"), part.number("damping_nm_s_per_rad"),
                  part.number("pulley_inertia_kg_m2")};
  }
  if (given("cogging")) {
    const py::object source = from.get("cogging");
    const Attributes part(source);
    auto& cogging = plant.cogging.emplace();
    cogging.periods_per_rev = part.integer<int>("periods_per_rev");
    const py::object table = part.get("torque_nm");
    for (const py::handle point : table) {
      cogging.torque_nm.push_back(part.as_number(point, "torque_nm"));
    }
  }
}

/// All but the encoder. @throws InvalidArgument or TypeError that names the class and the attribute
template <class Plant>
void read_plant(const Attributes& from, Plant& plant) {
  plant.knob_inertia_kg_m2 = from.number("knob_inertia_kg_m2");
  plant.knob_viscous_nm_s_per_rad = from.number("knob_viscous_nm_s_per_rad");
  plant.knob_coulomb_nm = from.number("knob_coulomb_nm");
  plant.brake_inertia_kg_m2 = from.number("brake_inertia_kg_m2");
  plant.brake_viscous_nm_s_per_rad = from.number("brake_viscous_nm_s_per_rad");
  plant.brake_drag_nm = from.number("brake_drag_nm");
  plant.shaft_stiffness_nm_per_rad = from.number("shaft_stiffness_nm_per_rad");
  plant.shaft_damping_nm_s_per_rad = from.number("shaft_damping_nm_s_per_rad");
  plant.brake_time_constant_s = from.number("brake_time_constant_s");
  plant.motor_time_constant_s = from.number("motor_time_constant_s");
  plant.motor_limit_nm = from.number("motor_limit_nm");
  plant.brake_limit_nm = from.number("brake_limit_nm");
  read_parts(from, plant);
}

}  // namespace torsio::bindings
