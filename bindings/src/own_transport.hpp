/// @file
/// A transport that is written in Python.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "torsio/transport.hpp"

namespace torsio::bindings {

/// @param transport a torsio.Transport
std::unique_ptr<Transport> transport_from_python(pybind11::object transport);

}  // namespace torsio::bindings
