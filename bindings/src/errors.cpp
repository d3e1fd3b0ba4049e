// C++ exceptions as the classes of torsio.errors, which live in Python so that they can also derive
// from Python's own (PermissionError, TimeoutError ...).
#include <pybind11/pybind11.h>

#include <exception>
#include <stdexcept>
#include <string_view>

#include "attributes.hpp"
#include "module.hpp"
#include "torsio/error.hpp"

namespace torsio::bindings {
namespace {

template <class... Arguments>
void raise(const char* class_name, std::string_view message, const Arguments&... arguments) {
  const py::object type = py::module_::import("torsio.errors").attr(class_name);
  PyErr_SetObject(type.ptr(), type(to_text(message), arguments...).ptr());
}

void translate(std::exception_ptr pointer) {
  if (!pointer) return;
  try {
    std::rethrow_exception(pointer);
  } catch (const Refused& error) {
    raise("Refused", error.what(), error.status(), error.report(), error.field(), error.reason());
  } catch (const Disarmed& error) {
    raise("Disarmed", error.what(), error.reason());
  } catch (const InvalidArgument& error) {
    raise("InvalidArgument", error.what());
  } catch (const DeviceNotFound& error) {
    raise("DeviceNotFound", error.what());
  } catch (const PermissionDenied& error) {
    raise("PermissionDenied", error.what());
  } catch (const DeviceBusy& error) {
    raise("DeviceBusy", error.what());
  } catch (const ProtocolMismatch& error) {
    raise("ProtocolMismatch", error.what());
  } catch (const Timeout& error) {
    raise("Timeout", error.what());
  } catch (const Disconnected& error) {
    raise("Disconnected", error.what());
  } catch (const Closed& error) {
    raise("Closed", error.what());
  } catch (const Error& error) {
    raise("Error", error.what());
  } catch (const std::invalid_argument& error) {
    raise("InvalidArgument", error.what());
  }
}

}  // namespace

void bind_errors(py::module_&) { py::register_local_exception_translator(&translate); }

}  // namespace torsio::bindings
