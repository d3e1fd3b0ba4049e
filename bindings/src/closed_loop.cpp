// torsio._torsio.emulator.ClosedLoop and simulate_many: many runs of the control law and the plant.
#include "emulator/closed_loop.hpp"

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "attributes.hpp"
#include "conversion/configuration.hpp"
#include "conversion/scene_encoding.hpp"
#include "convert.hpp"
#include "emulator_convert.hpp"
#include "interpreter.hpp"
#include "module.hpp"
#include "stepper_capsule.hpp"
#include "torsio/emulator.hpp"

namespace py = pybind11;
using py::arg;

namespace torsio::bindings {
namespace {

using emulator::ClosedLoopOptions;
using Rows = py::array_t<LoopRow>;

/// What a device would be told before such a loop: rounded and checked as on its way there.
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
  const auto add = [&](const protocol::ReportBytes& report) {
    reports.append(py::bytes(reinterpret_cast<const char*>(report.data()), report.size()));
  };
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
class Runs {
 public:
  Runs(std::vector<ClosedLoopOptions> options, std::vector<std::uint64_t> ticks,
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
    options.push_back(loop_options_from_python(sources[i]));
    Rows rows = make_rows(ticks[i], every);
    spans.push_back(span_of(rows));
    results.append(rows);
  }
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  threads =
      std::min<unsigned>(threads, static_cast<unsigned>(std::max<std::size_t>(1, ticks.size())));
  Runs runs(std::move(options), ticks, std::move(spans), every);
  const Unlocked unlocked;
  runs.run(threads, [&](std::size_t done) {
    const Locked locked;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!on_progress.is_none()) on_progress(done);
  });
  return results;
}

using Counts = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
using emulator::ReplayRow;

py::array_t<ReplayRow> replay(const py::object& source, const Counts& counts) {
  if (counts.ndim() != 1) throw py::value_error("the counts must have one dimension");
  const ClosedLoopOptions options = loop_options_from_python(source);
  const auto size = static_cast<std::size_t>(counts.size());
  py::array_t<ReplayRow> rows(counts.size());
  std::fill_n(reinterpret_cast<unsigned char*>(rows.mutable_data()), sizeof(ReplayRow) * size,
              static_cast<unsigned char>(0));
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
  if (const py::object initial = from.get("initial"); !initial.is_none()) {
    options.initial = initial_state_from_python(initial);
  }
  if (const py::object given = from.get("spin_up"); !given.is_none()) {
    const Attributes spin_up(given);
    options.spin_up = {.motor_command_nm = spin_up.number("motor_command_nm"),
                       .speed_rad_s = spin_up.number("speed_rad_s"),
                       .longest_s = spin_up.number("longest_s")};
  }
  return options;
}

emulator::PlantState initial_state_from_python(const py::object& source) {
  const Attributes from(source);
  emulator::PlantState state;
  state.time_ns = static_cast<std::int64_t>(std::llround(1e9 * from.number("time_s")));
  state.knob_angle = emulator::Angle::from_rad(from.number("angle_rad"));
  state.knob_angle.revolutions += from.integer<std::int64_t>("revolutions");
  state.speed_rad_s.fill(from.number("speed_rad_s"));
  state.twist_rad[0] = from.number("twist_rad");
  state.motor_torque_nm = from.number("motor_torque_nm");
  state.brake_magnetic_nm = from.number("brake_magnetic_nm");
  state.brake_target_nm = state.brake_magnetic_nm;
  return state;
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
          "set_hand",
          [](emulator::ClosedLoop& loop, const py::object& hand) {
            loop.set_hand(emulator_hand(hand));
          },
          arg("hand"));
  PYBIND11_NUMPY_DTYPE(ReplayRow, position_counts, speed_rad_s, desired_torque_nm, motor_command_nm,
                       brake_command_nm, spring_torque_nm, numeric_error);
  module.attr("REPLAY_DTYPE") = py::dtype::of<ReplayRow>();
  module.def("replay", &replay, arg("options"), arg("counts"));
  module.def("loop_reports", &loop_reports, arg("options"));
  module.def("simulate_many", &simulate_many, arg("options"), arg("ticks"), arg("every"),
             arg("threads"), arg("on_progress"));
}

}  // namespace torsio::bindings
