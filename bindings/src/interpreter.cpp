#include "interpreter.hpp"

#include <pybind11/pybind11.h>

#include <condition_variable>
#include <mutex>
#include <thread>

namespace py = pybind11;

namespace torsio::bindings {
namespace {

/// Who is about to take the lock, and whether anybody still may. Never destroyed: threads may be
/// in it for as long as there is a process.
struct Gate {
  std::mutex mutex;
  std::condition_variable changed;
  int entering = 0;
  bool ending = false;
  std::thread::id ender;

  static Gate& instance() {
    static Gate& gate = *new Gate;
    return gate;
  }

  void enter() {
    std::unique_lock lock(mutex);
    // Never true again for the others, so this is where they stay.
    changed.wait(lock, [&] { return !ending || ender == std::this_thread::get_id(); });
    ++entering;
  }

  void entered() {
    {
      const std::lock_guard lock(mutex);
      --entering;
    }
    changed.notify_all();
  }

  /// Returns when nobody is about to take the lock any more.
  void end() {
    std::unique_lock lock(mutex);
    ending = true;
    ender = std::this_thread::get_id();
    changed.wait(lock, [&] { return entering == 0; });
  }
};

/// In a child that was forked the others are gone, whatever they were about to do.
void start_anew() {
  Gate& gate = Gate::instance();
  new (&gate) Gate;
}

}  // namespace

Unlocked::~Unlocked() {
  Gate& gate = Gate::instance();
  gate.enter();
  PyEval_RestoreThread(state_);
  gate.entered();
}

Locked::Locked() {
  Gate& gate = Gate::instance();
  gate.enter();
  state_ = PyGILState_Ensure();
  gate.entered();
}

bool check_signals() {
  const Locked locked;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  return false;
}

void watch_interpreter() {
  const auto end = [] {
    PyThreadState* state = PyEval_SaveThread();
    Gate::instance().end();
    PyEval_RestoreThread(state);
  };
  // Last registered, first called: what is registered later, as torsio.knob does to close what is
  // open, runs while all threads still do.
  py::module_::import("atexit").attr("register")(py::cpp_function(end));
#ifndef _WIN32  // which does not fork
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") =
                                                         py::cpp_function(&start_anew));
#endif
}

}  // namespace torsio::bindings
