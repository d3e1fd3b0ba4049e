// torsio._torsio.emulator.ClosedLoop and simulate_many: many runs of the control law and the plant.
#include "emulator/closed_loop.hpp"

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "attributes.hpp"
#include "convert.hpp"
#include "emulator_convert.hpp"
#include "module.hpp"
#include "protocol/codec.hpp"
#include "protocol/registry.hpp"
#include "torsio/wire.hpp"
#include "wide/emulator/replay.hpp"

namespace py = pybind11;
using py::arg;

namespace torsio::bindings {
namespace {

using emulator::ClosedLoopOptions;
using emulator::LoopRow;
using Rows = py::array_t<LoopRow>;

/// The scene and the configuration go through the wire's own bytes, so that they are rounded and
/// checked as on their way to a device.
void read_effect(const WireReport& bytes, ClosedLoopOptions& options) {
  protocol::for_each_report<protocol::EffectReports>([&]<class Report>(std::type_identity<Report>) {
    Report report;
    if (bytes[0] == protocol::Layout<Report>::id && protocol::decode(bytes, report).ok()) {
      options.scene.emplace_back(report);
    }
  });
  protocol::CurvePoints points;
  if (bytes[0] == protocol::Layout<protocol::CurvePoints>::id &&
      protocol::decode(bytes, points).ok()) {
    options.curve_torque_nm.insert(options.curve_torque_nm.end(), points.torque_nm.begin(),
                                   points.torque_nm.begin() + points.points);
  }
}

template <class Config, class Source>
Config read_config(const Source& source) {
  Config config;
  // Cannot fail: what was encoded a moment ago has been checked.
  (void)protocol::decode(wire_report(source), config);
  return config;
}

void read_integration(const Attributes& from, emulator::PlantParams& plant) {
  const py::object method = from.get("method");
  if (!method.is_none()) plant.integration.method = emulator_method(method.cast<std::string>());
  if (!from.get("step_ns").is_none()) {
    plant.integration.step_ns = from.integer<std::int64_t>("step_ns");
  }
  if (const py::object given = from.get("tolerance"); !given.is_none()) {
    plant.integration.tolerance = from.number("tolerance");
  }
}

ClosedLoopOptions read_options(const py::object& source) {
  const Attributes from(source);
  const py::object plant_source = from.get("plant");
  const PlantParams plant = plant_from_python(plant_source);
  const py::object actuator_source = from.get("actuator");
  const ActuatorConfig actuator = actuator_source.is_none()
                                      ? matching_config(plant)
                                      : actuator_config_from_python(actuator_source);

  ClosedLoopOptions options;
  options.control_period_ns = from.integer<std::int64_t>("control_period_ns");
  options.delay_ticks = from.integer<std::uint32_t>("delay_ticks");
  options.first_tick = from.integer<std::uint64_t>("first_tick");
  options.actuator = read_config<protocol::ActuatorConfig>(actuator);
  options.control =
      read_config<protocol::ControlConfig>(control_config_from_python(from.get("control")));
  options.plant = emulator_plant(plant_source);
  read_integration(from, options.plant);
  options.encoder = emulator_encoder(plant_source);
  options.encoder.seed = from.integer<std::uint64_t>("seed");
  options.hand = emulator_hand(from.get("hand"));
  if (const py::object initial = from.get("initial"); !initial.is_none()) {
    options.initial = initial_state_from_python(initial);
  }
  if (const py::object scene = from.get("scene"); !scene.is_none()) {
    const auto period_ns = static_cast<std::uint32_t>(
        std::clamp<std::int64_t>(options.control_period_ns, 1, 1'000'000'000));
    for (const WireReport& report :
         wire_reports(scene_from_python(scene), actuator.counts_per_rev, period_ns)) {
      read_effect(report, options);
    }
  }
  if (const py::object given = from.get("spin_up"); !given.is_none()) {
    const Attributes spin_up(given);
    options.spin_up = {.motor_torque_nm = spin_up.number("motor_torque_nm"),
                       .speed_rad_s = spin_up.number("speed_rad_s"),
                       .longest_s = spin_up.number("longest_s")};
  }
  return options;
}

Rows make_rows(std::uint64_t ticks, std::uint32_t every) {
  if (every == 0) throw py::value_error("record_every must be > 0");
  const std::uint64_t size = ticks / every + (ticks % every != 0 ? 1 : 0);
  Rows rows(static_cast<py::ssize_t>(size));
  // Padding after the flags would otherwise be whatever was in memory.
  std::fill_n(reinterpret_cast<unsigned char*>(rows.mutable_data()), sizeof(LoopRow) * size,
              static_cast<unsigned char>(0));
  return rows;
}

std::span<LoopRow> span_of(Rows& rows) {
  return {rows.mutable_data(), static_cast<std::size_t>(rows.size())};
}

/// One closed loop after the other from a list, on several threads.
class Batch {
 public:
  Batch(std::vector<ClosedLoopOptions> options, std::vector<std::uint64_t> ticks,
        std::vector<std::span<LoopRow>> rows, std::uint32_t every)
      : options_(std::move(options)),
        ticks_(std::move(ticks)),
        rows_(std::move(rows)),
        every_(every) {}

  /// @param attend called about 20 times a second with the number of runs that are done; may throw
  void run(unsigned threads, const std::function<void(std::size_t)>& attend) {
    std::vector<std::thread> workers;
    for (unsigned i = 0; i < threads; ++i) workers.emplace_back([this] { work(); });
    std::exception_ptr interruption;
    try {
      std::unique_lock lock(mutex_);
      while (!changed_.wait_for(lock, std::chrono::milliseconds(50),
                                [&] { return done_ == options_.size() || failure_; })) {
        const std::size_t done = done_;
        lock.unlock();
        attend(done);
        lock.lock();
      }
    } catch (...) {
      interruption = std::current_exception();
    }
    next_ = options_.size();
    for (std::thread& worker : workers) worker.join();
    if (interruption) std::rethrow_exception(interruption);
    if (failure_) std::rethrow_exception(failure_);
    attend(done_);
  }

 private:
  void work() {
    for (std::size_t i = next_++; i < options_.size(); i = next_++) {
      try {
        emulator::ClosedLoop loop(options_[i]);
        loop.run(ticks_[i], rows_[i], every_);
        const std::lock_guard lock(mutex_);
        ++done_;
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        next_ = options_.size();
      }
      changed_.notify_one();
    }
  }

  std::vector<ClosedLoopOptions> options_;
  std::vector<std::uint64_t> ticks_;
  std::vector<std::span<LoopRow>> rows_;
  std::uint32_t every_;
  std::atomic<std::size_t> next_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t done_ = 0;
  std::exception_ptr failure_;
};

py::list simulate_many(const py::list& sources, const std::vector<std::uint64_t>& ticks,
                       std::uint32_t every, unsigned threads, const py::object& on_progress) {
  if (sources.size() != ticks.size()) throw py::value_error("one number of ticks for each run");
  std::vector<ClosedLoopOptions> options;
  std::vector<std::span<LoopRow>> spans;
  py::list results;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    options.push_back(read_options(sources[i]));
    Rows rows = make_rows(ticks[i], every);
    spans.push_back(span_of(rows));
    results.append(rows);
  }
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  threads =
      std::min<unsigned>(threads, static_cast<unsigned>(std::max<std::size_t>(1, ticks.size())));
  Batch batch(std::move(options), ticks, std::move(spans), every);
  const py::gil_scoped_release release;
  batch.run(threads, [&](std::size_t done) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!on_progress.is_none()) on_progress(done);
  });
  return results;
}

using Counts = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
using emulator::ReplayRow;

py::array_t<ReplayRow> replay(const py::object& source, const Counts& counts, bool wide) {
  if (counts.ndim() != 1) throw py::value_error("the counts must have one dimension");
  const ClosedLoopOptions options = read_options(source);
  const auto size = static_cast<std::size_t>(counts.size());
  py::array_t<ReplayRow> rows(counts.size());
  std::fill_n(reinterpret_cast<unsigned char*>(rows.mutable_data()), sizeof(ReplayRow) * size,
              static_cast<unsigned char>(0));
  const std::span<const std::uint32_t> in(counts.data(), size);
  const std::span<ReplayRow> out(rows.mutable_data(), size);
  const py::gil_scoped_release release;
  if (wide) {
    torsio::wide::emulator::replay(options, in, out);
  } else {
    emulator::replay(options, in, out);
  }
  return rows;
}

}  // namespace

emulator::PlantState initial_state_from_python(const py::object& source) {
  const Attributes from(source);
  emulator::PlantState state;
  state.time_ns = static_cast<std::int64_t>(std::llround(1e9 * from.number("time_s")));
  state.knob_angle = emulator::Angle::from_rad(from.number("angle_rad"));
  state.knob_angle.revolutions += from.integer<std::int64_t>("revolutions");
  state.speed_rad_s.fill(from.number("speed_rad_s"));
  state.twist_rad[0] = from.number("twist_rad");
  state.motor_torque_nm = from.number("motor_torque_nm");
  state.brake_capacity_nm = from.number("brake_torque_nm");
  state.brake_target_nm = state.brake_capacity_nm;
  return state;
}

void bind_closed_loop(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(LoopRow, time_s, angle_rad, brake_angle_rad, speed_rad_s, brake_speed_rad_s,
                       spring_torque_nm, motor_torque_nm, brake_torque_nm, brake_capacity_nm,
                       hand_torque_nm, knob_friction_torque_nm, position_counts,
                       estimated_speed_rad_s, desired_torque_nm, motor_command_nm, brake_command_nm,
                       sensed_spring_torque_nm, sensed_brake_torque_nm, knob_sticks, brake_sticks,
                       motor_saturated, brake_saturated, numeric_error);
  module.attr("LOOP_DTYPE") = py::dtype::of<LoopRow>();
  py::class_<emulator::ClosedLoop>(module, "ClosedLoop", "See torsio.closed_loop.")
      .def(py::init([](const py::object& source) {
             const ClosedLoopOptions options = read_options(source);
             const py::gil_scoped_release release;
             return std::make_unique<emulator::ClosedLoop>(options);
           }),
           arg("options"))
      .def(
          "run",
          [](emulator::ClosedLoop& loop, std::uint64_t ticks, std::uint32_t every) {
            Rows rows = make_rows(ticks, every);
            const std::span<LoopRow> span = span_of(rows);
            const py::gil_scoped_release release;
            loop.run(ticks, span, every);
            return rows;
          },
          arg("ticks"), arg("every"))
      .def(
          "hold_command",
          [](emulator::ClosedLoop& loop, double motor_torque_nm, double brake_torque_nm) {
            loop.hold_command({motor_torque_nm, brake_torque_nm});
          },
          arg("motor_torque_nm"), arg("brake_torque_nm"))
      .def("release_command", &emulator::ClosedLoop::release_command)
      .def(
          "set_hand",
          [](emulator::ClosedLoop& loop, const py::object& hand) {
            loop.set_hand(emulator_hand(hand));
          },
          arg("hand"))
      .def_property_readonly("fidelity", [](const emulator::ClosedLoop& loop) {
        return fidelity_to_python(loop.plant().fidelity());
      });
  PYBIND11_NUMPY_DTYPE(ReplayRow, position_counts, speed_rad_s, desired_torque_nm, motor_torque_nm,
                       brake_torque_nm, spring_torque_nm, numeric_error);
  module.attr("REPLAY_DTYPE") = py::dtype::of<ReplayRow>();
  module.def("replay", &replay, arg("options"), arg("counts"), arg("wide"));
  module.def("simulate_many", &simulate_many, arg("options"), arg("ticks"), arg("every"),
             arg("threads"), arg("on_progress"));
}

}  // namespace torsio::bindings
