// torsio._torsio.emulator: the emulated device and its parts, each on its own: plant, encoder, and
// the whole device at the level of report bytes.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "bytes.hpp"
#include "device/usb_descriptors.hpp"
#include "emulator/emulated_device.hpp"
#include "emulator/encoder.hpp"
#include "emulator/plant/circuit.hpp"
#include "emulator/plant/plant.hpp"
#include "emulator/replayed_device.hpp"
#include "emulator/rows.hpp"
#include "emulator/truth.hpp"
#include "emulator_convert.hpp"
#include "interpreter.hpp"
#include "module.hpp"
#include "python_values.hpp"
#include "stepper_capsule.hpp"

namespace torsio::bindings {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Release = py::call_guard<Unlocked>;

PlantParams plant_params(const py::object& source) {
  return source.is_none() ? PlantParams{} : from_python<PlantParams>(source);
}

PlantRow plant_row(const emulator::Plant& plant) {
  PlantRow row{};
  emulator::tell_truth(plant, row);
  return row;
}

template <class... Others>
py::ssize_t common_length(const char* what, const Doubles& first, const Others&... others) {
  if (first.ndim() != 1 || (... || (others.ndim() != 1 || others.size() != first.size()))) {
    throw py::value_error(std::string("the ") + what +
                          " must have one dimension and the same length");
  }
  return first.size();
}

std::unique_ptr<emulator::Plant> make_plant(const py::object& params, const py::object& held_by,
                                            std::int64_t step_ns, const py::object& stepper) {
  return std::make_unique<emulator::Plant>(plant_params(params), emulator_hand(held_by), step_ns,
                                           stepper_from_python(stepper));
}

py::array_t<PlantRow> plant_record(emulator::Plant& plant, const Doubles& motor_command_nm,
                                   const Doubles& brake_command_nm, std::int64_t period_ns) {
  const py::ssize_t size = common_length("commands", motor_command_nm, brake_command_nm);
  auto rows = empty_rows<PlantRow>(size);
  const double* motor = motor_command_nm.data();
  const double* brake = brake_command_nm.data();
  PlantRow* row = rows.mutable_data();
  const Unlocked unlocked;
  for (py::ssize_t i = 0; i < size; ++i) {
    row[i] = plant_row(plant);
    plant.set_command({motor[i], brake[i]});
    plant.advance(period_ns);
  }
  return rows;
}

const emulator::Electrics& electrics_of(const emulator::Plant& plant) {
  if (plant.params().electrics) return *plant.params().electrics;
  throw py::value_error("the plant has no electrics; give it PlantParams(electrics=Electrics())");
}

/// As plant_record, of a plant with electrics: shares of the supply in place of commands.
py::tuple plant_record_bridges(emulator::Plant& plant, const Doubles& motor_share,
                               const Doubles& brake_share, const Doubles& enabled,
                               std::int64_t period_ns) {
  const emulator::Electrics& electrics = electrics_of(plant);
  const py::ssize_t size = common_length("shares", motor_share, brake_share, enabled);
  auto rows = empty_rows<PlantRow>(size);
  py::array_t<double> supply_v(size);
  PlantRow* row = rows.mutable_data();
  emulator::Circuit circuit(electrics);
  for (py::ssize_t i = 0; i < size; ++i) {
    row[i] = plant_row(plant);
    supply_v.mutable_data()[i] = circuit.supply_v();
    circuit.advance(plant, {motor_share.data()[i], brake_share.data()[i], enabled.data()[i] != 0.0},
                    period_ns);
  }
  return py::make_tuple(rows, supply_v);
}

/// A plant's electrics, for a board that runs elsewhere.
class PlantCircuit {
 public:
  explicit PlantCircuit(emulator::Plant& plant) : plant_(plant), circuit_(electrics_of(plant)) {}

  void advance(std::int64_t duration_ns, double motor_share, double brake_share, bool enabled) {
    shares_ = {motor_share, brake_share, enabled};
    circuit_.advance(plant_, shares_, duration_ns);
  }
  [[nodiscard]] double current_a(double offset_s) const {
    if (!std::isfinite(offset_s)) throw py::value_error("offset_s must be finite");
    return circuit_.current_a(plant_) + circuit_.ripple_a(shares_, offset_s);
  }
  [[nodiscard]] ElectricsState state() const { return circuit_.state(plant_); }
  void set_supply(double supply_v) { circuit_.set_supply(supply_v); }

 private:
  emulator::Plant& plant_;
  emulator::Circuit circuit_;
  emulator::BridgeShares shares_;
};

/// Like plant_record, but with cheap columns only, so that the stepping dominates the time.
py::array_t<double> plant_drive(emulator::Plant& plant, const Doubles& motor_command_nm,
                                const Doubles& brake_command_nm, std::int64_t period_ns) {
  const py::ssize_t size = common_length("commands", motor_command_nm, brake_command_nm);
  py::array_t<double> angles({size, py::ssize_t{2}});
  const double* motor = motor_command_nm.data();
  const double* brake = brake_command_nm.data();
  double* row = angles.mutable_data();
  const Unlocked unlocked;
  for (py::ssize_t i = 0; i < size; ++i) {
    plant.set_command({motor[i], brake[i]});
    plant.advance(period_ns);
    *row++ = plant.state().knob_angle_rad();
    *row++ = plant.state().brake_angle_rad();
  }
  return angles;
}

void bind_plant(py::module_& module) {
  register_rows<PlantRow>();
  py::class_<emulator::Plant>(module, "Plant",
                              "Motor, knob, shaft spring, brake and hand under a virtual clock.")
      .def(py::init(&make_plant), arg("params") = py::none(), arg("hand") = py::none(),
           py::kw_only(), arg("step_ns") = emulator::Plant::kStepNs, arg("stepper") = py::none())
      .def(
          "set_command",
          [](emulator::Plant& plant, double motor_command_nm, double brake_command_nm) {
            plant.set_command({motor_command_nm, brake_command_nm});
          },
          py::kw_only(), arg("motor_command_nm") = 0.0, arg("brake_command_nm") = 0.0)
      .def(
          "set_hand",
          [](emulator::Plant& plant, const py::object& source) {
            plant.set_hand(emulator_hand(source));
          },
          arg("hand"), "Another hand takes over; times of its profiles are plant time.")
      .def("advance", &emulator::Plant::advance, arg("duration_ns"), Release())
      .def_property_readonly("time_ns",
                             [](const emulator::Plant& plant) { return plant.state().time_ns; })
      .def_property_readonly(
          "angle_rad", [](const emulator::Plant& plant) { return plant.state().knob_angle_rad(); },
          "Of the knob.")
      .def_property_readonly(
          "state", [](const emulator::Plant& plant) { return to_python(plant_row(plant)); },
          "Where the plant is; keys as PLANT_DTYPE.")
      .def("record", &plant_record, arg("motor_command_nm"), arg("brake_command_nm"), py::kw_only(),
           arg("period_ns") = 1'000'000)
      .def("record_bridges", &plant_record_bridges, arg("motor_share"), arg("brake_share"),
           arg("enabled"), py::kw_only(), arg("period_ns") = 25'000)
      .def("drive", &plant_drive, arg("motor_command_nm"), arg("brake_command_nm"), py::kw_only(),
           arg("period_ns") = 1'000'000)
      .def(
          "set_state",
          [](emulator::Plant& plant, const py::object& state) {
            plant.set_state(emulator::state_of(from_python<InitialState>(state)));
          },
          arg("state"), "Put it into a torsio.closed_loop.InitialState, its time included.")
      .def(
          "restart",
          [](emulator::Plant& plant) {
            plant.set_command({});
            plant.set_state({});
          },
          "Back to rest at time 0 and angle 0.");
}

void bind_circuit(py::module_& module) {
  py::class_<PlantCircuit>(module, "Circuit", "Windings, bridges and supply of a plant.")
      .def(py::init<emulator::Plant&>(), arg("plant"), py::keep_alive<1, 2>())
      .def("advance", &PlantCircuit::advance, arg("duration_ns"), py::kw_only(),
           arg("motor_share") = 0.0, arg("brake_share") = 0.0, arg("enabled") = false)
      .def("current_a", &PlantCircuit::current_a, arg("offset_s") = 0.0,
           "The motor's current so long after the middle of the driven time, ripple included.")
      .def_property_readonly("state",
                             [](const PlantCircuit& circuit) { return to_python(circuit.state()); })
      .def("set_supply", &PlantCircuit::set_supply, arg("supply_v"));
}

void bind_encoder(py::module_& module) {
  py::class_<emulator::Encoder>(module, "Encoder", "Incremental encoder on the knob's shaft.")
      .def(
          py::init([](std::uint32_t counts_per_rev, const std::string& rounding, int direction,
                      double phase_counts, double noise_counts, std::uint64_t seed) {
            if (rounding != "floor" && rounding != "nearest") {
              throw py::value_error("rounding must be 'floor' or 'nearest', is '" + rounding + "'");
            }
            return emulator::Encoder(
                {counts_per_rev,
                 rounding == "floor" ? EncoderRounding::floor : EncoderRounding::nearest,
                 static_cast<std::int8_t>(direction), phase_counts, noise_counts, seed});
          }),
          py::kw_only(), arg("counts_per_rev") = emulator::EncoderParams{}.counts_per_rev,
          arg("rounding") = "floor", arg("direction") = 1, arg("phase_counts") = 0.0,
          arg("noise_counts") = 0.0, arg("seed") = 0)
      .def(
          "sample",
          [](emulator::Encoder& encoder, double angle_rad) {
            return encoder.sample(emulator::Angle::from_rad(angle_rad));
          },
          arg("angle_rad"), "The 32-bit counter at an angle.");
}

protocol::ReportBytes report_bytes(const py::bytes& data) {
  const auto bytes = bytes_of(data);
  protocol::ReportBytes report{};
  if (bytes.size() != report.size()) {
    throw py::value_error("a report has 64 bytes, not " + std::to_string(bytes.size()));
  }
  std::ranges::copy(bytes, report.begin());
  return report;
}

template <class Device>
py::object feature_of(Device& device, std::uint8_t id) {
  protocol::ReportBytes report{};
  if (device.get_feature(id, report) != protocol::Status::ok) return py::none();
  return to_bytes(report);
}

std::unique_ptr<emulator::EmulatedDevice> make_device(std::uint64_t seed,
                                                      std::int64_t control_period_ns,
                                                      const py::object& plant,
                                                      const py::object& held_by,
                                                      const std::string& serial) {
  emulator::EmulatedDeviceOptions options;
  options.seed = seed;
  options.control_period_ns = control_period_ns;
  options.plant = plant_params(plant);
  options.encoder = emulator::encoder_of(options.plant);
  options.hand = emulator_hand(held_by);
  options.serial = serial;
  return std::make_unique<emulator::EmulatedDevice>(std::move(options));
}

void bind_device(py::module_& module) {
  using emulator::EmulatedDevice;
  py::class_<EmulatedDevice>(module, "EmulatedDevice",
                             "A whole knob without hardware, at the level of report bytes.")
      .def(py::init(&make_device), py::kw_only(), arg("seed") = 0,
           arg("control_period_ns") = emulator::EmulatedDeviceOptions{}.control_period_ns,
           arg("plant") = py::none(), arg("hand") = py::none(), arg("serial") = kEmulatedSerial)
      .def("advance", &EmulatedDevice::advance, arg("duration_ns"), Release(), "Let time pass.")
      .def_property_readonly("time_ns", &EmulatedDevice::time_ns)
      .def_property_readonly("connected", &EmulatedDevice::connected)
      .def(
          "write",
          [](EmulatedDevice& device, const py::bytes& report) {
            return device.write(report_bytes(report));
          },
          arg("report"), "Queue an output report; False if the host's queue is full.")
      .def(
          "read",
          [](EmulatedDevice& device) -> py::object {
            protocol::ReportBytes report{};
            if (!device.read(report)) return py::none();
            return to_bytes(report);
          },
          "Take the oldest input report, or None.")
      .def(
          "set_feature",
          [](EmulatedDevice& device, const py::bytes& report) {
            const protocol::Verdict verdict = device.set_feature(bytes_of(report));
            return std::pair(static_cast<int>(verdict.status), static_cast<int>(verdict.field));
          },
          arg("report"), "Send a feature report of any length: status code and field index.")
      .def("get_feature", &feature_of<EmulatedDevice>, arg("report_id"),
           "Ask for a feature report; None if the device stalls.")
      .def(
          "set_hand",
          [](EmulatedDevice& device, const py::object& source) {
            device.set_hand(emulator_hand(source));
          },
          arg("hand"), "The hand takes over at the next tick; its times are device time.")
      .def_property_readonly(
          "plant_state",
          [](const EmulatedDevice& device) { return to_python(plant_row(device.plant())); },
          "Where the plant is; keys as PLANT_DTYPE.")
      .def("set_plugged", &EmulatedDevice::set_plugged, arg("plugged"))
      .def("set_powered", &EmulatedDevice::set_powered, arg("powered"))
      .def("set_emergency_stop", &EmulatedDevice::set_emergency_stop, arg("pressed"));
}

InputKind input_kind(const std::string& name) {
  const auto& names = Names<InputKind>::values;
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) throw py::value_error("there is no input '" + name + "'");
  return static_cast<InputKind>(found - names.begin());
}

void bind_replayed_device(py::module_& module) {
  using emulator::ReplayedDevice;
  py::class_<ReplayedDevice>(module, "ReplayedDevice",
                             "The firmware's device without a plant, given another one's inputs.")
      .def(py::init([](std::int64_t control_period_ns, bool moves_parts) {
             // Its name makes no difference; its wiring rule does.
             emulator::EmulatedDeviceOptions options;
             options.control_period_ns = control_period_ns;
             device::BoardInfo board = emulator::EmulatedDevice(options).board();
             board.moves_parts = moves_parts;
             return std::make_unique<ReplayedDevice>(board);
           }),
           py::kw_only(),
           arg("control_period_ns") = emulator::EmulatedDeviceOptions{}.control_period_ns,
           arg("moves_parts") = false)
      .def(
          "take",
          [](ReplayedDevice& device, const std::string& kind, const py::bytes& content) {
            device.take(input_kind(kind), bytes_of(content));
          },
          arg("kind"), arg("content"), "Give it the next input.")
      .def("get_feature", &feature_of<ReplayedDevice>, arg("report_id"),
           "Ask for a feature report; None if the device stalls.")
      .def(
          "take_outputs",
          [](ReplayedDevice& device) {
            py::list list;
            for (const auto& output : device.take_outputs()) {
              list.append(py::make_tuple(output.tick, to_bytes(output.report)));
            }
            return list;
          },
          "Input reports since the last call, each with the control ticks that had run.")
      .def_property_readonly("ticks", &ReplayedDevice::ticks);
}

}  // namespace

emulator::Hand emulator_hand(const py::object& source) {
  return emulator::take_hold(hand_from_python(source));
}

void bind_emulator(py::module_& parent) {
  py::module_ module =
      parent.def_submodule("emulator", "The emulated device and its parts, each on its own.");
  module.def(
      "usb_report_descriptor",
      [](std::uint8_t interface, bool dial) {
        const auto interfaces = device::usb_interfaces(dial ? device::Personality::dial
                                                            : device::Personality::game_controller);
        if (interface >= interfaces.size()) throw py::value_error("there is no such interface");
        return to_bytes(interfaces[interface].report_descriptor);
      },
      arg("interface"), arg("dial") = false,
      "HID report descriptor of interface 0 (control) or 1 (game, or dial).");
  bind_plant(module);
  bind_circuit(module);
  bind_encoder(module);
  bind_device(module);
  bind_replayed_device(module);
  bind_closed_loop(module);
  bind_batch(module);
}

}  // namespace torsio::bindings
