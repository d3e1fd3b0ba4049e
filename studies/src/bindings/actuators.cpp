// The rival actuators, in torsio_studies._studies.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "actuators/trial.hpp"
#include "bindings/module.hpp"
#include "emulator/plant/hand.hpp"

namespace torsio::studies::bindings {
namespace {

using actuators::Parts;
using actuators::TrialRow;

constexpr std::array part_fields{
    std::pair{"knob_inertia_kg_m2", &Parts::knob_inertia_kg_m2},
    std::pair{"knob_coulomb_nm", &Parts::knob_coulomb_nm},
    std::pair{"rotor_inertia_kg_m2", &Parts::rotor_inertia_kg_m2},
    std::pair{"rotor_coulomb_nm", &Parts::rotor_coulomb_nm},
    std::pair{"rotor_viscous_nm_s_per_rad", &Parts::rotor_viscous_nm_s_per_rad},
    std::pair{"brake_inertia_kg_m2", &Parts::brake_inertia_kg_m2},
    std::pair{"brake_viscous_nm_s_per_rad", &Parts::brake_viscous_nm_s_per_rad},
    std::pair{"brake_drag_nm", &Parts::brake_drag_nm},
    std::pair{"stiff_spring_nm_per_rad", &Parts::stiff_spring_nm_per_rad},
    std::pair{"soft_spring_nm_per_rad", &Parts::soft_spring_nm_per_rad},
    std::pair{"spring_damping_nm_s_per_rad", &Parts::spring_damping_nm_s_per_rad},
    std::pair{"motor_time_constant_s", &Parts::motor_time_constant_s},
    std::pair{"motor_limit_nm", &Parts::motor_limit_nm},
    std::pair{"brake_time_constant_s", &Parts::brake_time_constant_s},
    std::pair{"clutch_time_constant_s", &Parts::clutch_time_constant_s},
    std::pair{"brake_limit_nm", &Parts::brake_limit_nm},
    std::pair{"free_assist_nm", &Parts::free_assist_nm},
    std::pair{"beta", &Parts::beta},
    std::pair{"sensor_threshold_nm", &Parts::sensor_threshold_nm},
    std::pair{"force_gain", &Parts::force_gain},
    std::pair{"source_speed_rad_s", &Parts::source_speed_rad_s},
    std::pair{"source_acceleration_rad_s2", &Parts::source_acceleration_rad_s2},
    std::pair{"source_gear_ratio", &Parts::source_gear_ratio},
    std::pair{"handover_time_constant_s", &Parts::handover_time_constant_s},
};

Parts parts_from(const std::map<std::string, double>& values) {
  Parts parts;
  for (const auto& [name, value] : values) {
    const auto* found = std::find_if(part_fields.begin(), part_fields.end(),
                                     [&](const auto& field) { return name == field.first; });
    if (found == part_fields.end()) throw py::value_error("actuator: no part '" + name + "'");
    parts.*(found->second) = value;
  }
  return parts;
}

using Knots = std::vector<std::pair<double, double>>;  // time_s, value

emulator::Profile profile(const Knots& from) {
  std::vector<emulator::ProfileKnot> knots;
  for (const auto& [time_s, value] : from) knots.push_back({std::llround(time_s * 1e9), value});
  return emulator::Profile(std::move(knots));
}

/// @param hand a torsio.NoHand, TorqueHand or ImpedanceHand
emulator::Hand hand_of(const py::object& hand) {
  if (py::hasattr(hand, "torque_nm")) {
    return emulator::TorqueHand{profile(hand.attr("torque_nm").cast<Knots>())};
  }
  if (!py::hasattr(hand, "intended_angle_rad")) return emulator::NoHand{};
  return emulator::ImpedanceHand{hand.attr("inertia_kg_m2").cast<double>(),
                                 hand.attr("stiffness_nm_per_rad").cast<double>(),
                                 hand.attr("damping_nm_s_per_rad").cast<double>(),
                                 profile(hand.attr("intended_angle_rad").cast<Knots>())};
}

py::array_t<TrialRow> run_actuator(const std::string& actuator, const py::object& hand,
                                   std::int64_t duration_ns,
                                   const std::map<std::string, double>& parts,
                                   double stiffness_nm_per_rad, double angle_rad, bool both_ways,
                                   double initial_speed_rad_s, std::uint32_t counts_per_rev,
                                   std::int64_t period_ns, std::int64_t step_ns) {
  const actuators::TrialParams params{
      .kind = actuators::kind_from_name(actuator),
      .parts = parts_from(parts),
      .environment = {stiffness_nm_per_rad, angle_rad, both_ways},
      .hand = hand_of(hand),
      .initial_speed_rad_s = initial_speed_rad_s,
      .counts_per_rev = counts_per_rev,
      .period_ns = period_ns,
      .step_ns = step_ns,
      .duration_ns = duration_ns,
  };
  std::vector<TrialRow> rows;
  {
    const py::gil_scoped_release release;
    rows = actuators::run_trial(params);
  }
  py::array_t<TrialRow> result(static_cast<py::ssize_t>(rows.size()));
  if (!rows.empty()) {
    std::memcpy(result.mutable_data(), rows.data(), rows.size() * sizeof(TrialRow));
  }
  return result;
}

}  // namespace

void bind_actuators(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(TrialRow, time_s, angle_rad, speed_rad_s, ideal_torque_nm, desired_torque_nm,
                       rendered_torque_nm, hand_torque_nm, motor_torque_nm, motor_load_nm,
                       brake_torque_nm, brake_capacity_nm);
  module.attr("TRIAL_DTYPE") = py::dtype::of<TrialRow>();
  py::list names;
  for (int kind = 0; kind < actuators::kKinds; ++kind) {
    names.append(std::string(actuators::name_of(static_cast<actuators::Kind>(kind))));
  }
  module.attr("ACTUATORS") = py::tuple(names);
  module.def(
      "actuator_parts",
      [] {
        py::dict parts;
        const Parts defaults;
        for (const auto& [name, member] : part_fields) parts[name] = defaults.*member;
        return parts;
      },
      "What all actuators are built from, by default.");
  module.def("run_actuator", &run_actuator, arg("actuator"), py::kw_only(), arg("hand"),
             arg("duration_ns"), arg("parts") = std::map<std::string, double>{},
             arg("stiffness_nm_per_rad") = 0.0, arg("angle_rad") = 0.0, arg("both_ways") = false,
             arg("initial_speed_rad_s") = 0.0,
             arg("counts_per_rev") = actuators::TrialParams{}.counts_per_rev,
             arg("period_ns") = actuators::TrialParams{}.period_ns,
             arg("step_ns") = actuators::TrialParams{}.step_ns,
             "One actuator, hand and environment; TRIAL_DTYPE, one row a tick.");
}

}  // namespace torsio::studies::bindings
