/// @file
/// A transport that is written in Python.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>

#include "torsio/transport.hpp"

namespace torsio::bindings {

/// An exception of a Python transport that is no Exception, such as KeyboardInterrupt. It goes on
/// to the program as it is. Used with the interpreter's lock.
class Passing {
 public:
  void keep(pybind11::error_already_set& error) { error_.emplace(error); }
  /// @throws what was kept, once
  void pass_on();
  /// True while this thread runs a method of the transport.
  [[nodiscard]] bool is_in_transport() const;

 private:
  std::optional<pybind11::error_already_set> error_;
};

/// @param transport a torsio.Transport
/// @param passing is told what is no Exception
std::unique_ptr<Transport> transport_from_python(pybind11::object transport,
                                                 std::shared_ptr<Passing> passing);

}  // namespace torsio::bindings
