// torsio._torsio.emulator.ClosedLoop: runs of the control law and the plant.
#include "emulator/closed_loop.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "attributes.hpp"
#include "bytes.hpp"
#include "conversion/configuration.hpp"
#include "conversion/scene_encoding.hpp"
#include "emulator_convert.hpp"
#include "interpreter.hpp"
#include "module.hpp"
#include "python_values.hpp"
#include "stepper_capsule.hpp"
#include "torsio/emulator.hpp"

namespace torsio::bindings {
namespace {

using emulator::ClosedLoopOptions;
using Rows = py::array_t<LoopRow>;

/// A device's settings before such a loop: rounded and checked as on their way there.
struct Told {
  protocol::ActuatorConfig actuator;
  protocol::ControlConfig control;
  protocol::ShaftConfig shaft;
  conversion::ConvertedScene scene;
};

Told read_told(const Attributes& from, const PlantParams& plant) {
  const py::object given = from.get("actuator");
  const auto actuator =
      given.is_none() ? matching_config(plant) : from_python<ActuatorConfig>(given);
  const py::object bent = from.get("shaft");
  const auto shaft = bent.is_none() ? matching_shaft(plant) : from_python<ShaftConfig>(bent);
  Told told{conversion::to_wire(actuator),
            conversion::to_wire(from_python<ControlConfig>(from.get("control"))),
            conversion::to_wire(shaft),
            {}};
  if (const py::object scene = from.get("scene"); !scene.is_none()) {
    const auto period_ns = static_cast<std::uint32_t>(std::clamp<std::int64_t>(
        from.integer<std::int64_t>("control_period_ns"), 1, 1'000'000'000));
    told.scene = conversion::to_wire(
        scene_from_python(scene),
        {.counts_per_rev = actuator.counts_per_rev, .control_period_ns = period_ns});
  }
  return told;
}

/// The same as the bytes of reports, for those who have a controller of their own.
py::list loop_reports(const py::object& source) {
  const Attributes from(source);
  const Told told = read_told(from, from_python<PlantParams>(from.get("plant")));
  const conversion::EncodedScene scene = conversion::encode(told.scene);
  py::list reports;
  const auto add = [&](const protocol::ReportBytes& report) { reports.append(to_bytes(report)); };
  add(protocol::encode(told.actuator));
  add(protocol::encode(told.control));
  add(protocol::encode(told.shaft));
  for (const auto& slot : scene.slots) add(slot.report);
  for (const auto& piece : scene.pieces) add(piece);
  return reports;
}

Rows make_rows(std::uint64_t ticks, std::uint32_t every) {
  if (every == 0) throw py::value_error("record_every must be > 0");
  const std::uint64_t size = ticks / every + (ticks % every != 0 ? 1 : 0);
  return empty_rows<LoopRow>(static_cast<py::ssize_t>(size));
}

std::span<LoopRow> span_of(Rows& rows) {
  return {rows.mutable_data(), static_cast<std::size_t>(rows.size())};
}

using Counts = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;

py::array_t<ReplayRow> replay(const py::object& source, const Counts& counts) {
  if (counts.ndim() != 1) throw py::value_error("the counts must have one dimension");
  const ClosedLoopOptions options = loop_options_from_python(source);
  const auto size = static_cast<std::size_t>(counts.size());
  auto rows = empty_rows<ReplayRow>(counts.size());
  const std::span<const std::uint32_t> in(counts.data(), size);
  const std::span<ReplayRow> out(rows.mutable_data(), size);
  const Unlocked unlocked;
  emulator::replay(options, in, out);
  return rows;
}

}  // namespace

ClosedLoopOptions loop_options_from_python(const py::object& source) {
  const Attributes from(source);
  const auto plant = from_python<PlantParams>(from.get("plant"));
  Told told = read_told(from, plant);

  ClosedLoopOptions options;
  options.control_period_ns = from.integer<std::int64_t>("control_period_ns");
  options.delay_ticks = from.integer<std::uint32_t>("delay_ticks");
  options.first_tick = from.integer<std::uint64_t>("first_tick");
  options.actuator = told.actuator;
  options.control = told.control;
  options.shaft = told.shaft;
  options.scene = std::move(told.scene.effects);
  options.curve_torque_nm = std::move(told.scene.curve_torque_nm);
  options.plant = plant;
  if (!from.get("step_ns").is_none()) options.step_ns = from.integer<std::int64_t>("step_ns");
  options.make_stepper = stepper_from_python(from.get("stepper"));
  options.encoder = emulator::encoder_of(plant);
  if (const py::object board = from.get("board"); !board.is_none()) {
    options.board = conversion::to_wire(from_python<BoardConfig>(board));
  }
  options.sensor_seed = from.integer<std::uint64_t>("seed");
  options.encoder.seed = from.integer<std::uint64_t>("seed");
  options.hand = emulator_hand(from.get("hand"));
  std::optional<InitialState> initial;
  read(from, "initial", initial);
  if (initial) options.initial = emulator::state_of(*initial);
  read(from, "spin_up", options.spin_up);
  return options;
}

void bind_closed_loop(py::module_& module) {
  register_rows<LoopRow>();
  py::class_<emulator::ClosedLoop>(module, "ClosedLoop", "See torsio.closed_loop.")
      .def(py::init([](const py::object& source) {
             const ClosedLoopOptions options = loop_options_from_python(source);
             const Unlocked unlocked;
             return std::make_unique<emulator::ClosedLoop>(options);
           }),
           arg("options"))
      .def(
          "run",
          [](emulator::ClosedLoop& loop, std::uint64_t ticks, std::uint32_t every) {
            Rows rows = make_rows(ticks, every);
            const std::span<LoopRow> span = span_of(rows);
            const Unlocked unlocked;
            loop.run(ticks, span, every);
            return rows;
          },
          arg("ticks"), arg("every"))
      .def(
          "hold_command",
          [](emulator::ClosedLoop& loop, double motor_command_nm, double brake_command_nm) {
            loop.hold_command({motor_command_nm, brake_command_nm});
          },
          arg("motor_command_nm"), arg("brake_command_nm"))
      .def("release_command", &emulator::ClosedLoop::release_command)
      .def(
          "set_scene",
          [](emulator::ClosedLoop& loop, const py::object& options) {
            const Attributes from(options);
            Told told = read_told(from, from_python<PlantParams>(from.get("plant")));
            ClosedLoopOptions next;
            next.scene = std::move(told.scene.effects);
            next.curve_torque_nm = std::move(told.scene.curve_torque_nm);
            loop.set_scene(next);
          },
          arg("options"))
      .def("stream_local_model",
           [](emulator::ClosedLoop& loop, double torque_nm, double angle_rad,
              double stiffness_nm_per_rad, double damping_nm_s_per_rad) {
             loop.stream(conversion::to_wire(
                 LocalModel{torque_nm, angle_rad, stiffness_nm_per_rad, damping_nm_s_per_rad}));
           })
      .def(
          "set_hand",
          [](emulator::ClosedLoop& loop, const py::object& hand) {
            loop.set_hand(emulator_hand(hand));
          },
          arg("hand"));
  register_rows<ReplayRow>();
  module.attr("REPLAY_DTYPE") = py::dtype::of<ReplayRow>();
  module.def("replay", &replay, arg("options"), arg("counts"));
  module.def("loop_reports", &loop_reports, arg("options"));
}

}  // namespace torsio::bindings
