/// @file
/// The Python package's data classes as the emulator's own structures.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstring>

#include "emulator/closed_loop_options.hpp"
#include "emulator/plant/hand.hpp"
#include "emulator/plant/plant.hpp"

namespace torsio::bindings {

/// @throws InvalidArgument, TypeError or std::invalid_argument that names what is wrong
emulator::Hand emulator_hand(const pybind11::object& source);

/// @param source a LoopOptions of the package
emulator::ClosedLoopOptions loop_options_from_python(const pybind11::object& source);

/// Rows to be filled in. Padding behind the flags would otherwise be whatever was in memory.
template <class Row>
pybind11::array_t<Row> empty_rows(pybind11::ssize_t size) {
  pybind11::array_t<Row> rows(size);
  std::memset(static_cast<void*>(rows.mutable_data()), 0,
              sizeof(Row) * static_cast<std::size_t>(size));
  return rows;
}

}  // namespace torsio::bindings
