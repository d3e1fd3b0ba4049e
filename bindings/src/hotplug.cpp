// torsio._torsio.DeviceWatch: the SDK's watch for knobs that are plugged in and pulled
// out. The package makes an iterator and a callback of it.
#include "torsio/hotplug.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "interpreter.hpp"
#include "module.hpp"
#include "python_values.hpp"

namespace torsio::bindings {
namespace {

/// Stopping waits for a thread, so the lock must be free whichever way the watch goes.
struct Ending {
  void operator()(const DeviceWatch* watch) const {
    const Unlocked unlocked;
    delete watch;
  }
};
using Watch = std::unique_ptr<DeviceWatch, Ending>;

Watch make_watch(bool include_present, double permission_timeout_s) {
  const WatchOptions options{.include_present = include_present,
                             .permission_timeout_s = permission_timeout_s};
  const Unlocked unlocked;
  return Watch(new DeviceWatch(options));
}

/// Waits in slices, between which signals are handled: what they raise (KeyboardInterrupt) ends the
/// wait.
std::optional<DeviceEvent> next(DeviceWatch& watch, double timeout_s) {
  using Seconds = std::chrono::duration<double>;
  constexpr double kSliceS = 0.05;
  const auto begin = std::chrono::steady_clock::now();
  double left_s = timeout_s;
  while (true) {
    {
      const Unlocked unlocked;
      // A value that is no time gets through, to be refused.
      auto event = watch.next(left_s > kSliceS ? kSliceS : left_s);
      if (event || watch.is_stopped()) return event ? event : watch.next(0.0);
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    left_s = timeout_s - Seconds(std::chrono::steady_clock::now() - begin).count();
    if (left_s <= 0.0) return std::nullopt;
  }
}

}  // namespace

void bind_watch(py::module_& module) {
  py::class_<DeviceWatch, Watch>(module, "DeviceWatch")
      .def(py::init(&make_watch), py::kw_only(), arg("include_present"),
           arg("permission_timeout_s"))
      .def(
          "next",
          [](DeviceWatch& self, double timeout_s) -> py::object {
            const auto event = next(self, timeout_s);
            if (!event) return py::none();
            return py::make_tuple(
                event->kind == DeviceEvent::Kind::arrived ? "arrived" : "departed",
                to_python(event->device));
          },
          arg("timeout_s"))
      .def("stop", &DeviceWatch::stop, py::call_guard<Unlocked>())
      .def_property_readonly("is_stopped", &DeviceWatch::is_stopped);
}

}  // namespace torsio::bindings
