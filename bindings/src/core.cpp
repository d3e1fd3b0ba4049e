// torsio._torsio.core: the device's control mathematics on their own. Every function works on an
// explicit state, once per control tick; its `_record` twin runs over the arrays of a whole record
// and gives the same numbers.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/brake_model.hpp"
#include "core/motion.hpp"
#include "core/partition.hpp"
#include "core/soft_sensor.hpp"
#include "interpreter.hpp"
#include "module.hpp"
#include "protocol/enumerations.hpp"

namespace py = pybind11;
using py::arg;

namespace torsio::bindings {
namespace {

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Counts = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;

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

py::ssize_t common_length(const Floats& a, const Floats& b) {
  if (a.ndim() != 1 || b.ndim() != 1 || a.size() != b.size()) {
    throw py::value_error("the arrays of a record must have one dimension and the same length");
  }
  return a.size();
}

// The same as core::Motion but without padding, so that NumPy can see it.
struct MotionRow {
  std::int64_t position_counts;
  std::int32_t delta_counts;
  float delta_rad;
  float speed_rad_s;
  float acceleration_rad_s2;
};

py::array_t<MotionRow> track_motion_record(core::MotionState& state,
                                           const core::MotionParams& params,
                                           const Counts& encoder_count) {
  if (encoder_count.ndim() != 1) throw py::value_error("encoder_count needs one dimension");
  py::array_t<MotionRow> rows(encoder_count.size());
  const std::uint32_t* count = encoder_count.data();
  MotionRow* row = rows.mutable_data();
  const Unlocked unlocked;
  for (py::ssize_t i = 0; i < encoder_count.size(); ++i) {
    const core::Motion motion = core::track_motion(state, params, count[i]);
    row[i] = {motion.position_counts, motion.delta_counts, motion.delta_rad, motion.speed_rad_s,
              motion.acceleration_rad_s2};
  }
  return rows;
}

Floats model_brake_record(core::BrakeState& state, const core::BrakeParams& params,
                          const Floats& held_command_nm) {
  if (held_command_nm.ndim() != 1) throw py::value_error("held_command_nm needs one dimension");
  Floats capacity_nm(held_command_nm.size());
  const float* command = held_command_nm.data();
  float* capacity = capacity_nm.mutable_data();
  const Unlocked unlocked;
  for (py::ssize_t i = 0; i < held_command_nm.size(); ++i) {
    capacity[i] = core::model_brake(state, params, command[i]);
  }
  return capacity_nm;
}

Floats sense_spring_record(core::SoftSensorState& state, const Floats& delta_rad,
                           const Floats& capacity_nm, float stiffness_nm_per_rad) {
  const py::ssize_t size = common_length(delta_rad, capacity_nm);
  Floats spring_nm(size);
  const float* delta = delta_rad.data();
  const float* capacity = capacity_nm.data();
  float* spring = spring_nm.mutable_data();
  const Unlocked unlocked;
  for (py::ssize_t i = 0; i < size; ++i) {
    spring[i] = core::sense_spring(state, stiffness_nm_per_rad, delta[i], capacity[i]);
  }
  return spring_nm;
}

py::tuple partition_record(const core::PartitionParams& params, const Floats& desired_nm,
                           const Floats& spring_nm) {
  const py::ssize_t size = common_length(desired_nm, spring_nm);
  Floats motor_nm(size);
  Floats brake_nm(size);
  const float* desired = desired_nm.data();
  const float* spring = spring_nm.data();
  float* motor = motor_nm.mutable_data();
  float* brake = brake_nm.mutable_data();
  {
    const Unlocked unlocked;
    for (py::ssize_t i = 0; i < size; ++i) {
      const core::Shares shares = core::partition(params, desired[i], spring[i]);
      motor[i] = shares.motor_command_nm;
      brake[i] = shares.brake_command_nm;
    }
  }
  return py::make_tuple(motor_nm, brake_nm);
}

void bind_motion(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(MotionRow, position_counts, delta_counts, delta_rad, speed_rad_s,
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
           py::kw_only(), arg("counts_per_rev") = 8192, arg("period_ns") = 1'000'000,
           arg("counter_bits") = 32, arg("reversed") = false, arg("speed_bandwidth_hz") = 100.0F);
  py::class_<core::MotionState>(module, "MotionState")
      .def(py::init<>())
      .def_readwrite("position_counts", &core::MotionState::position_counts);
  py::class_<core::Motion>(module, "Motion")
      .def_readonly("position_counts", &core::Motion::position_counts)
      .def_readonly("delta_counts", &core::Motion::delta_counts)
      .def_readonly("delta_rad", &core::Motion::delta_rad)
      .def_readonly("speed_rad_s", &core::Motion::speed_rad_s)
      .def_readonly("acceleration_rad_s2", &core::Motion::acceleration_rad_s2);
  module.def("track_motion", &core::track_motion, arg("state"), arg("params"), arg("encoder_count"),
             "One tick: position, speed and acceleration from a wrapping counter.");
  module.def("track_motion_record", &track_motion_record, arg("state"), arg("params"),
             arg("encoder_count"), "track_motion over a record; structured array, shape (n,).");
}

void bind_brake_model(py::module_& module) {
  py::class_<core::BrakeParams>(module, "BrakeParams")
      .def(py::init([](float time_constant_s, float period_s, float floor_nm, float drag_nm) {
             return core::make_brake_params(time_constant_s, period_s, floor_nm, drag_nm);
           }),
           py::kw_only(), arg("time_constant_s") = 60e-3F, arg("period_s") = 1e-3F,
           arg("floor_nm") = 3.3e-3F, arg("drag_nm") = 0.0F)
      .def_readonly("decay", &core::BrakeParams::decay)
      .def_readonly("floor_nm", &core::BrakeParams::floor_nm)
      .def_readonly("drag_nm", &core::BrakeParams::drag_nm);
  py::class_<core::BrakeState>(module, "BrakeState")
      .def(py::init([](float capacity_nm) { return core::BrakeState{capacity_nm}; }), py::kw_only(),
           arg("capacity_nm") = 0.0F)
      .def_readwrite("capacity_nm", &core::BrakeState::capacity_nm);
  module.def("model_brake", &core::model_brake, arg("state"), arg("params"), arg("held_command_nm"),
             "One tick: what the brake can hold now, N m.");
  module.def("model_brake_record", &model_brake_record, arg("state"), arg("params"),
             arg("held_command_nm"), "model_brake over a record; shape (n,).");
}

void bind_soft_sensor(py::module_& module) {
  py::class_<core::SoftSensorState>(module, "SoftSensorState")
      .def(py::init([](float torque_nm) { return core::SoftSensorState{torque_nm}; }),
           py::kw_only(), arg("spring_torque_nm") = 0.0F)
      .def_readwrite("spring_torque_nm", &core::SoftSensorState::spring_torque_nm);
  module.def(
      "sense_spring",
      [](core::SoftSensorState& state, float delta_rad, float capacity_nm,
         float stiffness_nm_per_rad) {
        return core::sense_spring(state, stiffness_nm_per_rad, delta_rad, capacity_nm);
      },
      arg("state"), arg("delta_rad"), arg("capacity_nm"), py::kw_only(),
      arg("stiffness_nm_per_rad") = 2.873F,
      "One tick: the shaft spring's torque on the knob, N m.");
  module.def("sense_spring_record", &sense_spring_record, arg("state"), arg("delta_rad"),
             arg("capacity_nm"), py::kw_only(), arg("stiffness_nm_per_rad") = 2.873F,
             "sense_spring over a record; shape (n,).");
}

void bind_partition(py::module_& module) {
  py::class_<core::PartitionParams>(module, "PartitionParams")
      .def(py::init([](const std::string& law, float beta, float motor_nm, float brake_nm) {
             return core::PartitionParams{law_from_name(law), beta, motor_nm, brake_nm};
           }),
           py::kw_only(), arg("law") = "paper", arg("beta") = 0.5F,
           arg("motor_torque_max_nm") = 85e-3F, arg("brake_torque_max_nm") = 110e-3F)
      .def_property_readonly("law",
                             [](const core::PartitionParams& params) {
                               return std::string(protocol::Enumerators<protocol::Law>::names.at(
                                   static_cast<std::size_t>(params.law)));
                             })
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
  module.def("partition", &core::partition, arg("params"), arg("desired_nm"), arg("spring_nm"),
             "Motor torque and brake command for a desired torque.");
  module.def("partition_record", &partition_record, arg("params"), arg("desired_nm"),
             arg("spring_nm"), "partition over a record: motor and brake torque, each shape (n,).");
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
