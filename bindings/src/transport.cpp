// torsio._torsio.Transport: the way to a device without the SDK's session, to pass reports on as
// they are. The package's studio is one.
#include "torsio/transport.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bytes.hpp"
#include "module.hpp"
#include "python_values.hpp"
#include "torsio/emulator.hpp"
#include "torsio/knob.hpp"

namespace torsio::bindings {
namespace {

/// Destroying one may wait for a thread, so the lock must be free whichever way it goes.
class PyTransport {
 public:
  explicit PyTransport(std::unique_ptr<Transport> transport) : transport_(std::move(transport)) {}
  PyTransport(const PyTransport&) = delete;
  PyTransport& operator=(const PyTransport&) = delete;
  ~PyTransport() {
    const py::gil_scoped_release release;
    close();
    transport_.reset();
  }

  Transport* operator->() const { return transport_.get(); }

  [[nodiscard]] Emulator& world() const {
    if (Emulator* world = transport_->emulator()) return *world;
    throw Error("this device is real hardware: it has no emulator");
  }

  void close() {
    if (!closed_) transport_->close();
    closed_ = true;
  }

 private:
  std::unique_ptr<Transport> transport_;
  bool closed_ = false;
};

ReportBytes report_of(const std::string_view bytes) {
  ReportBytes report{};
  if (bytes.size() != report.size()) {
    throw InvalidArgument("a report has 64 bytes, this one " + std::to_string(bytes.size()));
  }
  std::ranges::copy(bytes, report.begin());
  return report;
}

std::unique_ptr<PyTransport> open(const std::string& selector, const py::object& emulator) {
  OpenOptions options;
  if (!emulator.is_none()) options.emulator = from_python<EmulatorOptions>(emulator);
  const py::gil_scoped_release release;
  return std::make_unique<PyTransport>(open_transport(selector, options));
}

/// A switch of the world round an emulated device.
auto in_world(void (Emulator::*turn)(bool)) {
  return [turn](const PyTransport& self, bool on) { (self.world().*turn)(on); };
}

}  // namespace

void bind_transport(py::module_& module) {
  using Release = py::call_guard<py::gil_scoped_release>;
  py::class_<PyTransport>(module, "Transport")
      .def(py::init(&open), arg("selector"), arg("emulator"))
      .def("close", &PyTransport::close, Release())
      .def(
          "write",
          [](const PyTransport& self, const std::string& report) {
            return self->write(report_of(report));
          },
          arg("report"), Release())
      .def(
          "read",
          [](const PyTransport& self, double timeout_s) -> std::optional<py::bytes> {
            ReportBytes report{};
            {
              const py::gil_scoped_release release;
              const auto timeout = std::chrono::duration<double>(std::clamp(timeout_s, 0.0, 0.02));
              if (!self->read(report,
                              std::chrono::duration_cast<std::chrono::nanoseconds>(timeout))) {
                return std::nullopt;
              }
            }
            return to_bytes(report);
          },
          arg("timeout_s"))
      .def(
          "get_feature",
          [](const PyTransport& self, std::uint8_t id) -> std::optional<py::bytes> {
            ReportBytes report{};
            {
              const py::gil_scoped_release release;
              if (!self->get_feature(id, report)) return std::nullopt;
            }
            return to_bytes(report);
          },
          arg("report_id"))
      .def(
          "set_feature",
          [](const PyTransport& self, const std::string& report) {
            return self->set_feature(report_of(report));
          },
          arg("report"), Release())
      .def(
          "set_hand",
          [](const PyTransport& self, const py::object& source) {
            const Hand hand = hand_from_python(source);
            const py::gil_scoped_release release;
            self.world().set_hand(hand);
          },
          arg("hand"))
      .def("set_emergency_stop", in_world(&Emulator::set_emergency_stop), arg("pressed"), Release())
      .def("set_actuator_fault", in_world(&Emulator::set_actuator_fault), arg("present"), Release())
      .def("freeze_encoder", in_world(&Emulator::freeze_encoder), arg("frozen"), Release())
      .def(
          "set_current_sensor",
          [](const PyTransport& self, const std::string& state) {
            const auto& names = Names<CurrentSensorState>::values;
            const auto* const found = std::ranges::find(names, state);
            if (found == names.end()) throw InvalidArgument("no state of a sensor: " + state);
            self.world().set_current_sensor(static_cast<CurrentSensorState>(found - names.begin()));
          },
          arg("state"), Release())
      .def("truth", [](const PyTransport& self) {
        std::vector<TruthSample> rows;
        {
          const py::gil_scoped_release release;
          rows = self.world().truth();
        }
        clear_padding(rows);
        return as_array(std::move(rows));
      });
}

}  // namespace torsio::bindings
