// torsio._torsio.Knob: the SDK's knob. The Python package wraps it into a class with documentation;
// here are the calls, the lock and the arrays.
//
// Every call that may wait lets go of the interpreter's lock, so that other Python threads run, and
// asks for signals while it waits, so that Ctrl-C ends it at once.
#include "torsio/knob.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "conversion/configuration.hpp"
#include "convert.hpp"
#include "interpreter.hpp"
#include "module.hpp"
#include "own_transport.hpp"
#include "protocol/codec.hpp"
#include "torsio/config_file.hpp"

namespace py = pybind11;
using py::arg;
using Release = py::call_guard<torsio::bindings::Unlocked>;

namespace torsio::bindings {
namespace {

State state_from_name(const std::string& name) {
  const auto& names = Names<State>::values;
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    throw InvalidArgument("state must be 'disarmed', 'armed', 'fault' or 'disconnected', is '" +
                          name + "'");
  }
  return static_cast<State>(found - names.begin());
}

/// Closing waits for the device, so the lock must be free whichever way the knob goes.
class PyKnob {
 public:
  explicit PyKnob(Knob&& knob) : knob_(std::make_unique<Knob>(std::move(knob))) {}
  PyKnob(PyKnob&&) = default;
  PyKnob(const PyKnob&) = delete;
  PyKnob& operator=(const PyKnob&) = delete;
  ~PyKnob() {
    if (!knob_) return;
    const Unlocked unlocked;
    knob_.reset();
  }

  Knob& operator*() const { return *get(); }
  Knob* operator->() const { return get(); }

 private:
  /// A hand's function would wait for the step that waits for the function.
  [[nodiscard]] Knob* get() const {
    if (is_in_hand()) {
      throw Error(
          "the function of a hand cannot use a knob: it is called in the middle of a step of the "
          "plant; what it may know are its arguments");
    }
    return knob_.get();
  }

  std::unique_ptr<Knob> knob_;
};

/// An EmulatorOptions of the package, which has looked at the kinds of its values.
EmulatorOptions emulator_options_from_python(const py::object& source) {
  EmulatorOptions options;
  options.seed = source.attr("seed").cast<std::uint64_t>();
  options.control_rate_hz = source.attr("control_rate_hz").cast<double>();
  const auto given = [&](const char* name, auto&& take) {
    const py::object value = source.attr(name);
    if (!value.is_none()) take(value);
  };
  given("plant", [&](const py::object& value) { options.plant = from_python<PlantParams>(value); });
  given("hand", [&](const py::object& value) { options.hand = hand_from_python(value); });
  options.serial = source.attr("serial").cast<std::string>();
  given("actuator",
        [&](const py::object& value) { options.actuator = from_python<ActuatorConfig>(value); });
  given("control",
        [&](const py::object& value) { options.control = from_python<ControlConfig>(value); });
  given("board", [&](const py::object& value) { options.board = from_python<BoardConfig>(value); });
  given("game", [&](const py::object& value) { options.game = from_python<GameConfig>(value); });
  options.paced = source.attr("paced").cast<bool>();
  options.log_truth = source.attr("log_truth").cast<bool>();
  options.log_inputs = source.attr("log_inputs").cast<bool>();
  return options;
}

/// @param way a selector or a torsio.Transport
PyKnob open_knob(const py::object& way, const py::object& emulator, double command_timeout_s,
                 std::size_t ring_samples) {
  OpenOptions options;
  if (!emulator.is_none()) options.emulator = emulator_options_from_python(emulator);
  options.command_timeout_s = command_timeout_s;
  options.ring_samples = ring_samples;
  options.interrupted = &check_signals;
  if (py::isinstance<py::str>(way)) {
    const std::string selector = way.cast<std::string>();
    const Unlocked unlocked;
    return PyKnob(Knob::open(selector, options));
  }
  std::unique_ptr<Transport> transport = transport_from_python(way);
  const Unlocked unlocked;
  return PyKnob(Knob::open(std::move(transport), options));
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

/// Runs a call without the interpreter's lock and gives what it returns as Python has it.
template <class Call>
py::object told(Call&& call) {
  auto value = [&] {
    const Unlocked unlocked;
    return call();
  }();
  return to_python(value);
}

void play(const PyKnob& knob, const py::object& source) {
  const Scene scene = scene_from_python(source);
  const Unlocked unlocked;
  knob->play(scene);
}

py::array read(const PyKnob& knob, std::size_t max_samples, double timeout_s) {
  std::vector<TelemetrySample> samples;
  {
    const Unlocked unlocked;
    samples = knob->read(max_samples, timeout_s);
    clear_padding(samples);
  }
  return as_array(std::move(samples));
}

py::array as_record(std::vector<TelemetrySample>&& samples) {
  clear_padding(samples);
  return as_array(std::move(samples));
}

/// @param kept a list that gets the samples, however the recording ends, and then how the torque
///        went, or None
void record(const PyKnob& knob, double duration_s, std::optional<double> rate_hz,
            bool must_stay_armed, py::list kept) {
  Recording samples;
  const auto keep = [&] { kept.append(as_record(std::move(samples))); };
  try {
    const Unlocked unlocked;
    knob->record(samples, duration_s, rate_hz, must_stay_armed);
  } catch (...) {
    keep();
    throw;
  }
  const std::optional<Disarm> disarmed = samples.disarmed;
  keep();
  kept.append(disarmed ? to_python(*disarmed) : py::none());
}

/// A Python function that C++ may call from any thread and destroy there. What it raises is shown
/// as Python shows what nobody can catch, and the next event is told all the same; Ctrl-C goes on
/// to the main thread.
std::function<void(const Event&)> callback_from_python(const py::object& source) {
  if (source.is_none()) return {};
  return [callback = keep(source)](const Event& event) {
    const Locked locked;
    try {
      (*callback)(to_python(event));
    } catch (py::error_already_set& error) {
      if (error.matches(PyExc_KeyboardInterrupt)) {
        PyErr_SetInterrupt();  // Ctrl-C is for the program, whose main thread gets it next
      } else {
        error.discard_as_unraisable(*callback);
      }
    }
  };
}

py::list events(const PyKnob& knob, double timeout_s) {
  std::vector<Event> taken;
  {
    const Unlocked unlocked;
    taken = knob->events(timeout_s);
  }
  py::list list;
  for (const Event& event : taken) list.append(to_python(event));
  return list;
}

std::span<const std::uint8_t> bytes_of(const py::bytes& bytes) {
  const std::string_view view = bytes;
  return {reinterpret_cast<const std::uint8_t*>(view.data()), view.size()};
}

py::bytes to_bytes(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void bind_emulator_calls(py::class_<PyKnob>& knob) {
  knob.def_property_readonly("is_emulated", [](const PyKnob& self) { return self->is_emulated(); });
  knob.def("set_hand", [](const PyKnob& self, const py::object& source) {
    const Hand hand = hand_from_python(source);
    const Unlocked unlocked;
    self->emulator().set_hand(hand);
  });
  knob.def("truth", [](const PyKnob& self) {
    std::vector<TruthSample> samples;
    {
      const Unlocked unlocked;
      samples = self->emulator().truth();
    }
    return as_array(std::move(samples));
  });
  knob.def("inputs", [](const PyKnob& self) {
    std::vector<DeviceInput> inputs;
    {
      const Unlocked unlocked;
      inputs = self->emulator().inputs();
    }
    py::list list;
    for (const DeviceInput& input : inputs) {
      list.append(py::make_tuple(input.tick, input.kind, to_bytes(input.bytes)));
    }
    return list;
  });
  knob.def(
      "emulator_time_s", [](const PyKnob& self) { return self->emulator().time_s(); }, Release());
  knob.def(
      "advance",
      [](const PyKnob& self, double duration_s) { self->emulator().advance(duration_s); },
      Release());
  knob.def("electrics", [](const PyKnob& self) { return to_python(self->emulator().electrics()); });
  knob.def("set_current_sensor", [](const PyKnob& self, const std::string& state) {
    for (std::size_t i = 0; i < Names<CurrentSensorState>::values.size(); ++i) {
      if (Names<CurrentSensorState>::values[i] == state) {
        const Unlocked unlocked;
        self->emulator().set_current_sensor(static_cast<CurrentSensorState>(i));
        return;
      }
    }
    throw InvalidArgument("state is \"" + state + "\", allowed are works, dead, stuck, saturated");
  });
  knob.def(
      "set_supply",
      [](const PyKnob& self, double supply_v) { self->emulator().set_supply(supply_v); },
      Release());
  // These wait for their turn as well, and whoever has it may be the function of a hand.
  knob.def("game_write", [](const PyKnob& self, const py::bytes& report) {
    const auto bytes = bytes_of(report);
    const Unlocked unlocked;
    self->emulator().game().write(bytes);
  });
  knob.def("game_read", [](const PyKnob& self) {
    return to_bytes([&] {
      const Unlocked unlocked;
      return self->emulator().game().read();
    }());
  });
  knob.def("game_set_feature", [](const PyKnob& self, const py::bytes& report) {
    const auto bytes = bytes_of(report);
    const Unlocked unlocked;
    return self->emulator().game().set_feature(bytes);
  });
  knob.def("game_get_feature", [](const PyKnob& self, std::uint8_t id) {
    return to_bytes([&] {
      const Unlocked unlocked;
      return self->emulator().game().get_feature(id);
    }());
  });
  knob.def(
      "game_set_buttons",
      [](const PyKnob& self, std::uint8_t pressed) {
        self->emulator().game().set_buttons(pressed);
      },
      Release());
  knob.def("unplug", [](const PyKnob& self) { self->emulator().unplug(); }, Release());
  knob.def(
      "set_emergency_stop",
      [](const PyKnob& self, bool pressed) { self->emulator().set_emergency_stop(pressed); },
      Release());
  knob.def(
      "set_actuator_fault",
      [](const PyKnob& self, bool present) { self->emulator().set_actuator_fault(present); },
      Release());
  knob.def(
      "freeze_encoder",
      [](const PyKnob& self, bool frozen) { self->emulator().freeze_encoder(frozen); }, Release());
  knob.def(
      "jump_encoder",
      [](const PyKnob& self, std::int32_t counts) { self->emulator().jump_encoder(counts); },
      Release());
  knob.def(
      "skip_ticks",
      [](const PyKnob& self, std::uint32_t count) { self->emulator().skip_ticks(count); },
      Release());
  knob.def(
      "set_link_faults",
      [](const PyKnob& self, double drop_output, double corrupt_output, double drop_input,
         double corrupt_input) {
        self->emulator().set_link_faults({drop_output, corrupt_output, drop_input, corrupt_input});
      },
      py::kw_only(), arg("drop_output"), arg("corrupt_output"), arg("drop_input"),
      arg("corrupt_input"), Release());
  knob.def(
      "cut_power_in_next_save",
      [](const PyKnob& self, std::uint32_t after_bytes) {
        self->emulator().cut_power_in_next_save(after_bytes);
      },
      Release());
}

/// Both ways of one configuration: NAME_config() and configure_NAME(config).
template <class Config>
void bind_config(py::class_<PyKnob>& knob, const std::string& name, Config (Knob::*get)()) {
  knob.def((name + "_config").c_str(),
           [get](const PyKnob& self) { return told([&] { return ((*self).*get)(); }); });
  knob.def(("configure_" + name).c_str(), [](const PyKnob& self, const py::object& source) {
    const auto config = from_python<Config>(source);
    const Unlocked unlocked;
    self->configure(config);
  });
  // As it travels.
  knob.def_static(("encode_" + name).c_str(), [](const py::object& source) {
    const auto bytes = protocol::encode(conversion::to_wire(from_python<Config>(source)));
    return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  });
}

void bind_orders(py::class_<PyKnob>& knob) {
  knob.def("arm", [](const PyKnob& self) { self->arm(); }, Release());
  knob.def("disarm", [](const PyKnob& self) { self->disarm(); }, Release());
  knob.def("stop", [](const PyKnob& self) { self->stop(); }, Release());
  knob.def("zero", [](const PyKnob& self) { self->zero(); }, Release());
  knob.def("relax", [](const PyKnob& self) { self->relax(); }, Release());
  knob.def("clear_fault", [](const PyKnob& self) { self->clear_fault(); }, Release());
  knob.def("dump_config", [](const PyKnob& self) { return dump_config(*self); }, Release());
  knob.def(
      "load_config", [](const PyKnob& self, const std::string& text) { load_config(*self, text); },
      Release());
  knob.def("save", [](const PyKnob& self) { self->save(); }, Release());
  knob.def("load_defaults", [](const PyKnob& self) { self->load_defaults(); }, Release());
  knob.def("play", &play);
  knob.def(
      "stream_local_model",
      [](const PyKnob& self, double torque_nm, double angle_rad, double stiffness_nm_per_rad,
         double damping_nm_s_per_rad, double deadline_s) {
        self->stream_local_model(
            {torque_nm, angle_rad, stiffness_nm_per_rad, damping_nm_s_per_rad, deadline_s});
      },
      arg("torque_nm"), arg("angle_rad"), arg("stiffness_nm_per_rad"), arg("damping_nm_s_per_rad"),
      arg("deadline_s"), Release());
  knob.def("excite", [](const PyKnob& self, const py::object& source) {
    const auto excitation = from_python<Excitation>(source);
    const Unlocked unlocked;
    self->excite(excitation);
  });
  bind_config(knob, "actuator", &Knob::actuator_config);
  bind_config(knob, "control", &Knob::control_config);
  bind_config(knob, "board", &Knob::board_config);
  bind_config(knob, "game", &Knob::game_config);
}

void bind_tap(py::module_& module) {
  py::class_<ReportTap, std::shared_ptr<ReportTap>>(module, "ReportTap")
      .def("take", [](ReportTap& tap) {
        py::list list;
        for (const LoggedReport& report : tap.take()) {
          list.append(py::make_tuple(report.tick, report.sent,
                                     to_bytes({report.bytes.begin(), report.bytes.end()})));
        }
        return list;
      });
}

void bind_telemetry(py::class_<PyKnob>& knob) {
  knob.def(
      "tap", [](const PyKnob& self, bool with_telemetry) { return self->tap(with_telemetry); },
      arg("with_telemetry"), Release());
  knob.def("feature", [](const PyKnob& self, std::uint8_t id) {
    ReportBytes report{};
    {
      const Unlocked unlocked;
      report = self->feature(id);
    }
    return to_bytes({report.begin(), report.end()});
  });
  knob.def(
      "start_telemetry",
      [](const PyKnob& self, std::optional<double> rate_hz, bool prompt) {
        return self->start_telemetry(rate_hz, prompt);
      },
      arg("rate_hz"), arg("prompt"), Release());
  knob.def("stop_telemetry", [](const PyKnob& self) { self->stop_telemetry(); }, Release());
  knob.def("read", &read, arg("max_samples"), arg("timeout_s"));
  knob.def("latest", [](const PyKnob& self) {
    std::vector<TelemetrySample> samples(1);
    {
      const Unlocked unlocked;
      samples.front() = self->latest();
    }
    return as_record(std::move(samples));
  });
  knob.def("record", &record, arg("duration_s"), arg("rate_hz"), arg("must_stay_armed"),
           arg("kept"));
  knob.def("events", &events, arg("timeout_s"));
  knob.def("on_event", [](const PyKnob& self, const py::object& source) {
    auto callback = callback_from_python(source);
    const Unlocked unlocked;
    self->on_event(std::move(callback));
  });
  knob.def("last_disarm", [](const PyKnob& self) -> py::object {
    const std::optional<Disarm> disarm = [&] {
      const Unlocked unlocked;
      return self->last_disarm();
    }();
    return disarm ? to_python(*disarm) : py::none();
  });
  knob.def(
      "sleep", [](const PyKnob& self, double duration_s) { self->sleep(duration_s); },
      arg("duration_s"), Release());
  knob.def(
      "every", [](const PyKnob& self, double period_s) { return self->every(period_s); },
      arg("period_s"), py::keep_alive<0, 1>());
  knob.def("wait_for", [](const PyKnob& self, const std::string& name, double timeout_s) {
    const State state = state_from_name(name);
    const Unlocked unlocked;
    return self->wait_for(state, timeout_s);
  });
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

  py::class_<PyKnob> knob(module, "Knob");
  py::class_<Steps>(module, "Steps").def("wait", [](Steps& steps) {
    const Step step = [&] {
      const Unlocked unlocked;
      return steps.wait();
    }();
    return py::make_tuple(step.index, step.time_s, step.late_steps);
  });
  module.def("open_knob", &open_knob, arg("way"), py::kw_only(), arg("emulator"),
             arg("command_timeout_s"), arg("ring_samples"));
  knob.def("close", [](const PyKnob& self) { self->close(); }, Release());
  knob.def_property_readonly("is_open", [](const PyKnob& self) { return self->is_open(); });
  knob.def_property_readonly(
      "state", [](const PyKnob& self) { return told([&] { return self->state(); }); });
  knob.def("info", [](const PyKnob& self) { return to_python(self->info()); });
  knob.def("health", [](const PyKnob& self) { return told([&] { return self->health(); }); });
  knob.def("energies", [](const PyKnob& self) { return told([&] { return self->energies(); }); });
  knob.def("limits", [](const PyKnob& self) { return told([&] { return self->limits(); }); });
  knob.def("faults", [](const PyKnob& self) { return told([&] { return self->faults(); }); });
  knob.def("clock", [](const PyKnob& self) { return told([&] { return self->clock(); }); });
  knob.def("game_status",
           [](const PyKnob& self) { return told([&] { return self->game_status(); }); });
  knob.def("game_effects",
           [](const PyKnob& self) { return told([&] { return self->game_effects(); }); });
  knob.def("stable_stiffness",
           [](const PyKnob& self) { return told([&] { return self->stable_stiffness(); }); });
  knob.def("statistics",
           [](const PyKnob& self) { return told([&] { return self->statistics(); }); });
  knob.def("position_rad", [](const PyKnob& self) { return self->position_rad(); }, Release());
  bind_orders(knob);
  bind_telemetry(knob);
  bind_emulator_calls(knob);
}

}  // namespace torsio::bindings
