// torsio._torsio.emulator.Batch: many closed loops at once, whose states and actions Python sees
// where they are, without copies.
#include "emulator/batch.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "bytes.hpp"
#include "emulator_convert.hpp"
#include "interpreter.hpp"
#include "module.hpp"

namespace torsio::bindings {
namespace {

using emulator::Batch;
using emulator::BatchAction;

template <class T>
using Numbers = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <class T>
std::span<const T> span_of(const Numbers<T>& numbers) {
  if (numbers.ndim() != 1) throw py::value_error("the array must have one dimension");
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

std::unique_ptr<Batch> make_batch(const py::list& kinds, const Numbers<std::uint32_t>& kind_of,
                                  const Numbers<std::uint64_t>& seeds, unsigned threads,
                                  bool acts_hand, bool acts_commands) {
  emulator::BatchOptions options;
  for (const py::handle kind : kinds) {
    options.kinds.push_back(loop_options_from_python(py::reinterpret_borrow<py::object>(kind)));
  }
  const auto which = span_of(kind_of);
  options.kind_of.assign(which.begin(), which.end());
  const auto seeded = span_of(seeds);
  options.seeds.assign(seeded.begin(), seeded.end());
  options.threads = threads;
  options.acts_hand = acts_hand;
  options.acts_commands = acts_commands;
  const Unlocked unlocked;
  return std::make_unique<Batch>(std::move(options));
}

/// The batch's own memory; `self` keeps it.
template <class T>
py::array_t<T> view(const py::object& self, std::span<T> rows) {
  return py::array_t<T>(static_cast<py::ssize_t>(rows.size()), rows.data(), self);
}

}  // namespace

void bind_batch(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(BatchAction, hand_torque_nm, motor_command_nm, brake_command_nm);
  module.attr("ACTION_DTYPE") = py::dtype::of<BatchAction>();
  py::class_<Batch>(module, "Batch", "See torsio.batch.")
      .def(py::init(&make_batch), arg("kinds"), arg("kind_of"), arg("seeds"), arg("threads"),
           arg("acts_hand"), arg("acts_commands"))
      .def("step", &Batch::step, arg("ticks"), arg("goes_on"), py::call_guard<Unlocked>())
      .def(
          "reset",
          [](Batch& batch, const Numbers<std::uint32_t>& loops,
             const Numbers<std::uint64_t>& seeds) {
            const auto which = span_of(loops);
            const auto seeded = span_of(seeds);
            const Unlocked unlocked;
            batch.reset(which, seeded);
          },
          arg("loops"), arg("seeds"))
      .def("save", [](const Batch& batch) { return to_bytes(batch.save()); })
      .def(
          "restore", [](Batch& batch, const py::bytes& saved) { batch.restore(bytes_of(saved)); },
          arg("saved"))
      .def_property_readonly("states",
                             [](const py::object& self) {
                               py::array_t<LoopRow> rows = view(self, self.cast<Batch&>().states());
                               rows.attr("flags").attr("writeable") = false;
                               return rows;
                             })
      .def_property_readonly("actions", [](const py::object& self) {
        return view(self, self.cast<Batch&>().actions());
      });
}

}  // namespace torsio::bindings
