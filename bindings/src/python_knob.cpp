// torsio._torsio.Knob: the SDK's knob. The Python package wraps it into a class with documentation;
// here is the list of its calls, and those that are more than a method of the library.
//
// Every call that may wait lets go of the interpreter's lock, so that other Python threads run, and
// asks for signals while it waits, so that Ctrl-C ends it at once.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "bytes.hpp"
#include "calls.hpp"
#include "conversion/config_kinds.hpp"
#include "conversion/configuration.hpp"
#include "interpreter.hpp"
#include "module.hpp"
#include "own_transport.hpp"
#include "protocol/codec.hpp"
#include "python_values.hpp"
#include "torsio/config_file.hpp"
#include "torsio/knob.hpp"

namespace torsio::bindings {
namespace {

/// @param way a selector or a torsio.Transport
PyKnob open_knob(const py::object& way, const py::object& emulator, double command_timeout_s,
                 std::size_t ring_samples) {
  OpenOptions options;
  if (!emulator.is_none()) options.emulator = from_python<EmulatorOptions>(emulator);
  options.command_timeout_s = command_timeout_s;
  options.ring_samples = ring_samples;
  options.interrupted = &check_signals;
  auto passing = std::make_shared<Passing>();
  if (py::isinstance<py::str>(way)) {
    const std::string selector = way.cast<std::string>();
    const Unlocked unlocked;
    return {Knob::open(selector, options), std::move(passing)};
  }
  std::unique_ptr<Transport> transport = transport_from_python(way, passing);
  try {
    const Unlocked unlocked;
    return {Knob::open(std::move(transport), options), passing};
  } catch (...) {
    passing->pass_on();
    throw;
  }
}

/// Raises no error of the knob, but says it.
void close_knob(const PyKnob& self) {
  if (!self.take([&] { return self->close(); })) {
    PyErr_SetString(py::module_::import("torsio.errors").attr("Error").ptr(),
                    "the transport took no order, so the knob was not told to disarm; its "
                    "watchdog disarms it");
    PyErr_WriteUnraisable(py::str("torsio.Knob.close").ptr());
  }
  self.pass_on();
}

py::list list_all() {
  std::vector<ListedDevice> devices;
  {
    const Unlocked unlocked;
    devices = list_devices();
  }
  py::list list;
  for (const ListedDevice& device : devices) list.append(to_python(device));
  return list;
}

/// The steps of a program's own loop; the knob outlives them.
class PySteps {
 public:
  PySteps(const PyKnob& knob, double period_s) : knob_(knob), steps_(knob->every(period_s)) {}

  py::tuple wait() {
    static_cast<void>(*knob_);  // a hand or a transport may not
    const Step step = knob_.run([&] { return steps_.wait(); });
    return py::make_tuple(step.index, step.time_s, step.late_steps);
  }

 private:
  const PyKnob& knob_;
  Steps steps_;
};

/// @param kept a list that gets the samples too, so that no interrupt comes between
py::array read(const PyKnob& knob, std::size_t max_samples, double timeout_s, py::list kept) {
  py::array samples = as_record(knob.take([&] { return knob->read(max_samples, timeout_s); }));
  kept.append(samples);
  return samples;
}

/// @param kept a list that gets the samples, however the recording ends. If it ends well, the list
/// also gets why the torque went, or None, and whether the torque came late
/// @returns the samples, behind those before it that nobody had read
py::array record(const PyKnob& knob, double duration_s, std::optional<double> rate_hz,
                 bool must_stay_armed, py::list kept) {
  TelemetryRecord samples;
  try {
    knob.take([&] { knob->record(samples, duration_s, rate_hz, must_stay_armed); });
  } catch (...) {
    kept.append(as_record(std::move(samples)));
    throw;
  }
  const std::optional<Disarm> disarmed = samples.disarmed;
  const bool armed_late = samples.armed_late;
  std::vector<TelemetrySample> taken = std::move(samples.unread_before);
  taken.insert(taken.end(), samples.begin(), samples.end());
  kept.append(as_record(std::move(samples)));
  kept.append(disarmed ? to_python(*disarmed) : py::none());
  kept.append(armed_late);
  return as_record(std::move(taken));
}

/// A Python function that C++ may call from any thread and destroy there. Python shows its
/// exceptions as unraisable, and the next event is told all the same. What is no Exception goes on
/// in the main thread, as from a signal's handler.
std::function<void(const Event&)> callback_from_python(const py::object& source) {
  if (source.is_none()) return {};
  return [callback = keep(source)](const Event& event) {
    const Locked locked;
    try {
      (*callback)(to_python(event));
    } catch (py::error_already_set& error) {
      if (error.matches(PyExc_KeyboardInterrupt)) {
        PyErr_SetInterrupt();  // which wakes asyncio's loop too
      } else if (error.matches(PyExc_Exception) || !raise_in_main_thread(error)) {
        error.discard_as_unraisable(*callback);
      }
    }
  };
}

void bind_emulator_calls(py::class_<PyKnob>& knob) {
  knob.def_property_readonly("is_emulated", call(&Knob::is_emulated))
      .def("set_hand", call(&Emulator::set_hand))
      .def("truth", call(&Emulator::truth))
      .def("inputs", call(&Emulator::inputs))
      .def("emulator_time_s", call(&Emulator::time_s))
      .def("advance", call(&Emulator::advance))
      .def("electrics", call(&Emulator::electrics))
      .def("set_current_sensor", call(&Emulator::set_current_sensor))
      .def("set_supply", call(&Emulator::set_supply))
      .def("game_write", call(&GamePort::write))
      .def("game_read", call(&GamePort::read))
      .def("game_set_feature", call(&GamePort::set_feature))
      .def("game_get_feature", call(&GamePort::get_feature))
      .def("game_set_buttons", call(&GamePort::set_buttons))
      .def("unplug", call(&Emulator::unplug))
      .def("set_emergency_stop", call(&Emulator::set_emergency_stop))
      .def("set_actuator_fault", call(&Emulator::set_actuator_fault))
      .def("freeze_encoder", call(&Emulator::freeze_encoder))
      .def("jump_encoder", call(&Emulator::jump_encoder))
      .def("skip_ticks", call(&Emulator::skip_ticks))
      .def("set_link_faults", call(&Emulator::set_link_faults))
      .def("cut_power_in_next_save", call(&Emulator::cut_power_in_next_save));
}

/// Calls `use(kind)` for the configuration of this name.
template <class Result, class Use>
Result with_config(std::string_view name, Use&& use) {
  std::optional<Result> result;
  std::apply(
      [&](const auto&... kind) {
        ((kind.name == name ? static_cast<void>(result.emplace(use(kind))) : void()), ...);
      },
      kConfigKinds);
  if (!result) throw py::value_error("there is no configuration " + std::string(name));
  return *std::move(result);
}

/// Both ways of a configuration, and how it travels.
void bind_configs(py::class_<PyKnob>& knob) {
  knob.def("config",
           [](const PyKnob& self, const std::string& name) {
             return with_config<py::object>(
                 name, [&](const auto& kind) -> py::object { return call(kind.get)(self); });
           })
      .def("configure",
           [](const PyKnob& self, const std::string& name, const py::object& source) {
             with_config<bool>(name, [&]<class Config>(const ConfigKind<Config>&) {
               const auto config = from_python<Config>(source);
               self.run([&] { self->configure(config); });
               return true;
             });
           })
      .def_static("encode_config", [](const std::string& name, const py::object& source) {
        return with_config<py::bytes>(name, [&]<class Config>(const ConfigKind<Config>&) {
          return to_bytes(protocol::encode(conversion::to_wire(from_python<Config>(source))));
        });
      });
}

void bind_orders(py::class_<PyKnob>& knob) {
  knob.def("arm", call(&Knob::arm))
      .def("disarm", call(&Knob::disarm))
      .def("stop", call(&Knob::stop))
      .def("zero", call(&Knob::zero))
      .def("relax", call(&Knob::relax))
      .def("clear_fault", call(&Knob::clear_fault))
      .def("dump_config",
           [](const PyKnob& self) { return self.run([&] { return dump_config(*self); }); })
      .def("load_config",
           [](const PyKnob& self, const std::string& text) {
             self.run([&] { load_config(*self, text); });
           })
      .def("save", call(&Knob::save))
      .def("load_defaults", call(&Knob::load_defaults))
      .def("play",
           [](const PyKnob& self, const py::object& given) {
             const Scene scene = scene_from_python(given);
             return self.run([&] {
               std::string swings = self->play(scene);
               return std::pair(std::move(swings), self->state() == State::disarmed);
             });
           })
      .def("stream_local_model",
           [](const PyKnob& self, double torque_nm, double angle_rad, double stiffness_nm_per_rad,
              double damping_nm_s_per_rad, double deadline_s) {
             return self.run([&] {
               return self->stream_local_model(
                   {torque_nm, angle_rad, stiffness_nm_per_rad, damping_nm_s_per_rad, deadline_s});
             });
           })
      .def("excite", call(&Knob::excite));
  bind_configs(knob);
}

void bind_tap(py::module_& module) {
  py::class_<ReportTap, std::shared_ptr<ReportTap>>(module, "ReportTap")
      .def("take", [](ReportTap& tap) {
        py::list list;
        for (const LoggedReport& report : tap.take()) {
          list.append(py::make_tuple(report.tick, report.sent, to_bytes(report.bytes)));
        }
        return list;
      });
}

void bind_telemetry(py::class_<PyKnob>& knob) {
  knob.def("tap", call(&Knob::tap), arg("with_telemetry"))
      .def("feature", call(&Knob::feature))
      .def("start_telemetry", call(&Knob::start_telemetry))
      .def("stop_telemetry", call(&Knob::stop_telemetry))
      .def("read", &read)
      .def("latest", call(&Knob::latest))
      .def("record", &record)
      .def("events", call(&Knob::events))
      .def("on_event",
           [](const PyKnob& self, const py::object& source) {
             self.run([&, callback = callback_from_python(source)] { self->on_event(callback); });
           })
      .def("last_disarm", call(&Knob::last_disarm))
      .def("sleep", call(&Knob::sleep))
      .def(
          "every", [](const PyKnob& self, double period_s) { return PySteps(self, period_s); },
          py::keep_alive<0, 1>())
      .def("wait_for", call(&Knob::wait_for));
}

}  // namespace

void bind_knob(py::module_& module) {
  bind_tap(module);
  module.attr("TELEMETRY_DTYPE") = row_type<TelemetrySample>();
  module.attr("TRUTH_DTYPE") = row_type<TruthSample>();

  module.def("list_devices", &list_all);
  module.def("matching_config", [](const py::object& plant) {
    return to_python(matching_config(from_python<PlantParams>(plant)));
  });
  module.def("matching_shaft", [](const py::object& plant) {
    return to_python(matching_shaft(from_python<PlantParams>(plant)));
  });

  py::class_<PyKnob> knob(module, "Knob");
  py::class_<PySteps>(module, "Steps").def("wait", &PySteps::wait);
  module.def("open_knob", &open_knob, arg("way"), py::kw_only(), arg("emulator"),
             arg("command_timeout_s"), arg("ring_samples"));
  knob.def("close", &close_knob)
      .def("disarm_to_close", call(&Knob::disarm_to_close))
      .def("pass_on", &PyKnob::pass_on)
      .def_property_readonly("is_open", call(&Knob::is_open))
      .def_property_readonly("state", call(&Knob::state))
      .def("info", call(&Knob::info))
      .def("health", call(&Knob::health))
      .def("energies", call(&Knob::energies))
      .def("motor_current", call(&Knob::motor_current))
      .def("limits", call(&Knob::limits))
      .def("faults", call(&Knob::faults))
      .def("clock", call(&Knob::clock))
      .def("game_status", call(&Knob::game_status))
      .def("game_effects", call(&Knob::game_effects))
      .def("stable_stiffness", call(&Knob::stable_stiffness))
      .def("statistics", call(&Knob::statistics))
      .def("position_rad", call(&Knob::position_rad));
  bind_orders(knob);
  bind_telemetry(knob);
  bind_emulator_calls(knob);
}

}  // namespace torsio::bindings
