// torsio._torsio.FirmwarePlan and what is done with it: new firmware for a knob.
#include "torsio/firmware.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "interpreter.hpp"
#include "module.hpp"
#include "python_values.hpp"
#include "torsio/knob.hpp"

namespace torsio::bindings {
namespace {

namespace fs = std::filesystem;

py::dict file_to_python(const FirmwareFile& file) {
  return py::dict(arg("path") = file.path, arg("chip") = file.chip, arg("board") = file.board,
                  arg("version") = file.version, arg("fingerprint") = file.fingerprint,
                  arg("size") = file.size);
}

/// As pybind11's own conversion, which loses a Ctrl-C in the middle of it.
fs::path path_from_python(const py::object& source) {
  const auto text = py::reinterpret_steal<py::object>(PyOS_FSPath(source.ptr()));
  if (!text) throw py::error_already_set();
  return text.cast<fs::path>();
}

/// A torsio.knob.firmware.FirmwareHost, or None.
FirmwareHost host_from_python(const py::object& source) {
  if (source.is_none()) return {};
  const auto host = keep(source);
  return {.list_devices =
              [host] {
                const Locked locked;
                std::vector<ListedDevice> devices;
                for (const py::handle device : host->attr("list_devices")()) {
                  devices.push_back(from_python<ListedDevice>(device));
                }
                return devices;
              },
          .examine =
              [host](const std::string& path) {
                const Locked locked;
                const py::object answer = host->attr("examine")(path);
                if (answer.is_none()) throw ProtocolMismatch("the knob is of another release");
                const Attributes from(answer, "answer of a knob");
                return ExaminedKnob{from_python<DeviceInfo>(from.get("info")),
                                    from.choice<Owner>("owner", Names<Owner>::values),
                                    from.text("configuration")};
              },
          .start_bootloader =
              [host](const std::string& path) {
                const Locked locked;
                host->attr("start_bootloader")(path);
              },
          .root = path_from_python(host->attr("root"))};
}

FirmwarePlan prepare(const py::object& source, const std::string& selector, const py::object& drive,
                     double timeout_s, const py::object& say, const py::object& host) {
  const fs::path path = path_from_python(source);
  const UpdateOptions options{.drive = drive.is_none() ? fs::path() : path_from_python(drive),
                              .timeout_s = timeout_s,
                              .say =
                                  [say = keep(say)](std::string_view step) {
                                    const Locked locked;
                                    (*say)(to_text(step));
                                  },
                              .interrupted = &check_signals,
                              .host = host_from_python(host)};
  const Unlocked unlocked;
  return prepare_update(path, selector, options);
}

py::dict carry_out_plan(const FirmwarePlan& plan) {
  const FirmwareUpdate done = [&] {
    const Unlocked unlocked;
    return carry_out(plan);
  }();
  return py::dict(arg("file") = file_to_python(done.file), arg("before") = to_python(done.before),
                  arg("after") = to_python(done.after), arg("kept") = done.kept,
                  arg("configuration") = done.configuration);
}

}  // namespace

void bind_firmware(py::module_& module) {
  py::class_<FirmwarePlan>(module, "FirmwarePlan")
      .def_property_readonly("file",
                             [](const FirmwarePlan& plan) { return file_to_python(plan.file); })
      .def_property_readonly("device",
                             [](const FirmwarePlan& plan) { return to_python(plan.device); })
      .def_property_readonly("before",
                             [](const FirmwarePlan& plan) { return to_python(plan.before); })
      .def_property_readonly("configuration",
                             [](const FirmwarePlan& plan) { return plan.configuration; })
      .def_property_readonly("loses_configuration", &FirmwarePlan::loses_configuration)
      .def_property_readonly("text", &FirmwarePlan::text);
  module.def("read_firmware", [](const py::object& source) {
    return file_to_python([path = path_from_python(source)] {
      const Unlocked unlocked;
      return read_firmware(path);
    }());
  });
  module.def("prepare_update", &prepare, arg("path"), arg("selector"), arg("drive"),
             arg("timeout_s"), arg("say"), arg("host"));
  module.def("carry_out", &carry_out_plan, arg("plan"));
  module.def("start_bootloader", [](const std::string& selector) {
    OpenOptions options;
    options.interrupted = &check_signals;
    const Unlocked unlocked;
    start_bootloader(selector, options);
  });
}

}  // namespace torsio::bindings
