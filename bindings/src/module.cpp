#include "module.hpp"

#include <cstddef>

#include "interpreter.hpp"

namespace torsio::bindings {
namespace {

/// Called where pybind11 would make raw memory of an object that `__new__` alone has made.
void* refuse_without_init(std::size_t) {
  throw py::type_error("the object was made with __new__ alone: call its class");
}

py::object refuse_to_pickle(const py::object& self) {
  throw py::type_error("cannot pickle or copy an object of " +
                       py::str(py::type::of(self)).cast<std::string>());
}

void prepare_classes(const py::handle& module) {
  for (const auto& [name, value] : py::dict(module.attr("__dict__"))) {
    if (PyModule_Check(value.ptr())) prepare_classes(value);
    if (!PyType_Check(value.ptr())) continue;
    auto* const info = py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr()));
    if (info == nullptr) continue;
    info->operator_new = &refuse_without_init;
    // Python's own would make an object of pybind11's base class, which ends the process.
    value.attr("__reduce__") =
        py::cpp_function(&refuse_to_pickle, py::name("__reduce__"), py::is_method(value));
  }
}

}  // namespace
}  // namespace torsio::bindings

PYBIND11_MODULE(_torsio_in_main, module) {
  using namespace torsio::bindings;
  module.doc() = "The C++ side of the torsio package. Use the package, not this module.";
  module.attr("__version__") = TORSIO_VERSION;
  watch_interpreter();
  module.def("all_of", &all_of);
  bind_errors(module);
  bind_protocol(module);
  bind_core(module);
  bind_scene(module);
  bind_emulator(module);
  bind_knob(module);
  bind_firmware(module);
  bind_watch(module);
  bind_transport(module);
  prepare_classes(module);
}

/// Python calls this one. In a sub-interpreter pybind11 hangs before the first line above.
PYBIND11_PLUGIN_IMPL(_torsio) {
  if (PyInterpreterState_Get() == PyInterpreterState_Main()) return PyInit__torsio_in_main();
  PyErr_SetString(PyExc_ImportError,
                  "torsio works in the main interpreter only: use a process instead");
  return nullptr;
}
