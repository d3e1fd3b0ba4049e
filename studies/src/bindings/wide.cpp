// torsio_studies._studies.replay_wide: the 64-bit build of the controller over recorded counts.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "bindings/module.hpp"
#include "emulator/closed_loop_options.hpp"
#include "protocol/codec.hpp"
#include "wide/emulator/replay.hpp"

namespace torsio::studies::bindings {
namespace {

using Counts = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
using Bytes = py::array_t<std::uint8_t>;

/// Bytes of the rows, which torsio.closed_loop.REPLAY_DTYPE describes.
Bytes replay_wide(const std::vector<py::bytes>& reports, std::int64_t control_period_ns,
                  std::uint64_t first_tick, const Counts& counts) {
  if (counts.ndim() != 1) throw py::value_error("the counts must have one dimension");
  emulator::ClosedLoopOptions options;
  options.control_period_ns = control_period_ns;
  options.first_tick = first_tick;
  for (const py::bytes& each : reports) {
    const std::string_view from = each;
    protocol::ReportBytes bytes{};
    if (from.size() == bytes.size()) std::ranges::copy(from, bytes.begin());
    if (!emulator::take_report(bytes, options)) {
      throw py::value_error("a report is neither a configuration nor part of a scene");
    }
  }
  const auto size = static_cast<std::size_t>(counts.size());
  std::vector<ReplayRow> rows(size);
  {
    const py::gil_scoped_release release;
    wide::emulator::replay(options, {counts.data(), size}, rows);
  }
  const std::span<const std::byte> bytes = std::as_bytes(std::span(rows));
  return Bytes(static_cast<py::ssize_t>(bytes.size()),
               reinterpret_cast<const std::uint8_t*>(bytes.data()));
}

}  // namespace

void bind_wide(py::module_& module) {
  module.def("replay_wide", &replay_wide, arg("reports"), py::kw_only(), arg("control_period_ns"),
             arg("first_tick"), arg("counts"),
             "What 64 bits decide: the bytes of torsio.closed_loop.REPLAY_DTYPE rows.");
}

}  // namespace torsio::studies::bindings
