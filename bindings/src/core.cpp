// torsio._torsio.core: the device's control mathematics on their own. Every function works on an
// explicit state, once per control tick; given arrays, it goes through them tick by tick.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/brake_model.hpp"
#include "core/motion.hpp"
#include "core/partition.hpp"
#include "core/soft_sensor.hpp"
#include "module.hpp"
#include "protocol/configuration.hpp"
#include "protocol/enumerations.hpp"
#include "protocol/reports.hpp"

namespace torsio::bindings {
namespace {

// Defaults are the reference actuator's, and the emulated device's.
constexpr protocol::ActuatorConfig kActuator;
constexpr protocol::ControlConfig kControl;
constexpr std::uint32_t kPeriodNs = protocol::emulated_control_period_ns;
constexpr auto kPeriodS = static_cast<float>(1e-9 * kPeriodNs);

std::string name_of(core::Law law) {
  return std::string(protocol::Enumerators<protocol::Law>::names.at(static_cast<std::size_t>(law)));
}

core::Law law_from_name(const std::string& name) {
  const auto& names = protocol::Enumerators<protocol::Law>::names;
  const auto found = std::ranges::find(names, name);
  if (found != names.end()) return static_cast<core::Law>(found - names.begin());
  std::string known;
  for (const std::string_view one : names) {
    known += (known.empty() ? "'" : ", '") + std::string(one) + "'";
  }
  throw py::value_error("law must be one of " + known + ", is '" + name + "'");
}

/// Refuses values that vectorize would take for numbers, or go through in another order.
template <class Number>
auto rows(const char* name, const py::object& value) {
  const bool is_array = py::isinstance<py::array>(value);
  bool good = PyNumber_Check(value.ptr()) != 0;
  if (is_array) {
    const auto array = py::reinterpret_borrow<py::array>(value);
    const char kind = array.dtype().kind();
    good = kind == 'i' || kind == 'u' || (kind == 'f' && std::is_floating_point_v<Number>);
    if (array.ndim() > 1) {
      throw py::value_error(std::string(name) + " has " + std::to_string(array.ndim()) +
                            " dimensions, allowed is one, of ticks");
    }
  } else if (!std::is_floating_point_v<Number>) {
    good = PyIndex_Check(value.ptr()) != 0;
  }
  if (!good) {
    throw py::type_error(std::string(name) + " must be " +
                         (std::is_floating_point_v<Number> ? "a number" : "a whole number") +
                         " or an array of them");
  }
  return py::array_t<Number, py::array::forcecast>(value);
}

/// A tick each.
template <class One, class Other>
void check_lengths(const One& one, const Other& other) {
  if (one.ndim() == 0 || other.ndim() == 0 || one.size() == other.size()) return;
  throw py::value_error("arrays of " + std::to_string(one.size()) + " and " +
                        std::to_string(other.size()) + " ticks do not go together");
}

void bind_motion(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(core::Motion, position_counts, delta_counts, delta_rad, speed_rad_s,
                       acceleration_rad_s2);
  py::class_<core::MotionParams>(module, "MotionParams")
      .def(py::init([](std::uint32_t counts_per_rev, std::uint32_t period_ns,
                       std::uint32_t counter_bits, bool reversed, float speed_bandwidth_hz) {
             if (counts_per_rev == 0 || period_ns == 0) {
               throw py::value_error("counts_per_rev and period_ns must be > 0");
             }
             if (counter_bits < 1 || counter_bits > 32) {
               throw py::value_error("counter_bits must be from 1 to 32");
             }
             return core::make_motion_params(core::make_resolution(counts_per_rev, period_ns),
                                             counter_bits, reversed, speed_bandwidth_hz);
           }),
           py::kw_only(), arg("counts_per_rev") = kActuator.counts_per_rev,
           arg("period_ns") = kPeriodNs, arg("counter_bits") = kActuator.counter_bits,
           arg("reversed") = false, arg("speed_bandwidth_hz") = kControl.speed_bandwidth_hz);
  py::class_<core::MotionState>(module, "MotionState")
      .def(py::init<>())
      .def_readwrite("position_counts", &core::MotionState::position_counts);
  py::class_<core::Motion>(module, "Motion")
      .def_readonly("position_counts", &core::Motion::position_counts)
      .def_readonly("delta_counts", &core::Motion::delta_counts)
      .def_readonly("delta_rad", &core::Motion::delta_rad)
      .def_readonly("speed_rad_s", &core::Motion::speed_rad_s)
      .def_readonly("acceleration_rad_s2", &core::Motion::acceleration_rad_s2);
  module.def(
      "track_motion",
      [](core::MotionState& state, core::MotionParams& params, const py::object& count) {
        return py::vectorize([&](std::uint32_t encoder_count) {
          return core::track_motion(state, params, encoder_count);
        })(rows<std::uint32_t>("encoder_count", count));
      },
      arg("state"), arg("params"), arg("encoder_count"),
      "One tick: position, speed and acceleration from a wrapping counter.");
}

void bind_brake_model(py::module_& module) {
  py::class_<core::BrakeParams>(module, "BrakeParams")
      .def(py::init([](float time_constant_s, float period_s, float floor_nm, float drag_nm) {
             return core::make_brake_params(time_constant_s, period_s, floor_nm, drag_nm);
           }),
           py::kw_only(), arg("time_constant_s") = kActuator.brake_time_constant_s,
           arg("period_s") = kPeriodS, arg("floor_nm") = kActuator.brake_torque_min_nm,
           arg("drag_nm") = 0.0F)
      .def_readonly("decay", &core::BrakeParams::decay)
      .def_readonly("floor_nm", &core::BrakeParams::floor_nm)
      .def_readonly("drag_nm", &core::BrakeParams::drag_nm);
  py::class_<core::BrakeState>(module, "BrakeState")
      .def(py::init([](float capacity_nm) { return core::BrakeState{capacity_nm}; }), py::kw_only(),
           arg("capacity_nm") = 0.0F)
      .def_readwrite("capacity_nm", &core::BrakeState::capacity_nm);
  module.def(
      "model_brake",
      [](core::BrakeState& state, core::BrakeParams& params, const py::object& held) {
        return py::vectorize([&](float held_command_nm) {
          return core::model_brake(state, params, held_command_nm);
        })(rows<float>("held_command_nm", held));
      },
      arg("state"), arg("params"), arg("held_command_nm"),
      "One tick: what the brake can hold now, N m.");
}

void bind_soft_sensor(py::module_& module) {
  py::class_<core::SoftSensorState>(module, "SoftSensorState")
      .def(py::init([](float torque_nm) { return core::SoftSensorState{torque_nm}; }),
           py::kw_only(), arg("spring_torque_nm") = 0.0F)
      .def_readwrite("spring_torque_nm", &core::SoftSensorState::spring_torque_nm);
  module.def(
      "sense_spring",
      [](core::SoftSensorState& state, const py::object& delta, const py::object& capacity,
         float stiffness_nm_per_rad) {
        const auto deltas = rows<float>("delta_rad", delta);
        const auto capacities = rows<float>("capacity_nm", capacity);
        check_lengths(deltas, capacities);
        return py::vectorize([&](float delta_rad, float capacity_nm) {
          return core::sense_spring(state, stiffness_nm_per_rad, delta_rad, capacity_nm);
        })(deltas, capacities);
      },
      arg("state"), arg("delta_rad"), arg("capacity_nm"), py::kw_only(),
      arg("stiffness_nm_per_rad") = kActuator.spring_stiffness_nm_per_rad,
      "One tick: the shaft spring's torque on the knob, N m.");
}

void bind_partition(py::module_& module) {
  py::class_<core::PartitionParams>(module, "PartitionParams")
      .def(py::init([](const std::string& law, float beta, float motor_nm, float brake_nm) {
             return core::PartitionParams{law_from_name(law), beta, motor_nm, brake_nm};
           }),
           py::kw_only(), arg("law") = name_of(static_cast<core::Law>(kControl.law)),
           arg("beta") = kControl.beta, arg("motor_torque_max_nm") = kActuator.motor_torque_max_nm,
           arg("brake_torque_max_nm") = kActuator.brake_torque_max_nm)
      .def_property_readonly(
          "law", [](const core::PartitionParams& params) { return name_of(params.law); })
      .def_property_readonly(
          "brakes",
          [](const core::PartitionParams& params) { return core::traits(params.law).brakes; })
      .def_property_readonly(
          "bounds",
          [](const core::PartitionParams& params) { return core::traits(params.law).bounds; })
      .def_readonly("beta", &core::PartitionParams::beta)
      .def_readonly("motor_torque_max_nm", &core::PartitionParams::motor_torque_max_nm)
      .def_readonly("brake_torque_max_nm", &core::PartitionParams::brake_torque_max_nm);
  py::class_<core::Shares>(module, "Shares")
      .def_readonly("motor_command_nm", &core::Shares::motor_command_nm)
      .def_readonly("brake_command_nm", &core::Shares::brake_command_nm)
      .def_readonly("motor_saturated", &core::Shares::motor_saturated)
      .def_readonly("brake_saturated", &core::Shares::brake_saturated);
  PYBIND11_NUMPY_DTYPE(core::Shares, motor_command_nm, brake_command_nm, motor_saturated,
                       brake_saturated);
  module.def(
      "partition",
      [](core::PartitionParams& params, const py::object& desired, const py::object& spring) {
        const auto torques = rows<float>("desired_nm", desired);
        const auto springs = rows<float>("spring_nm", spring);
        check_lengths(torques, springs);
        return py::vectorize([&](float desired_nm, float spring_nm) {
          return core::partition(params, desired_nm, spring_nm);
        })(torques, springs);
      },
      arg("params"), arg("desired_nm"), arg("spring_nm"),
      "Motor torque and brake command for a desired torque.");
}

}  // namespace

void bind_core(py::module_& parent) {
  py::module_ module =
      parent.def_submodule("core", "The device's control mathematics, in its 32-bit floats.");
  bind_motion(module);
  bind_brake_model(module);
  bind_soft_sensor(module);
  bind_partition(module);
}

}  // namespace torsio::bindings
