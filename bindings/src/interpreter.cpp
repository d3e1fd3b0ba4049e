#include "interpreter.hpp"

#include <pybind11/pybind11.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace py = pybind11;

namespace torsio::bindings {
namespace {

constexpr std::chrono::seconds kLastWords{1};

/// Threads that take or have the lock, and whether any still may. Never destroyed: threads may be
/// in it for as long as there is a process.
struct Gate {
  std::mutex mutex;
  std::condition_variable changed;
  int entering = 0;
  int inside = 0;  // how often C++ below has called Python
  bool ending = false;
  std::thread::id ender;

  static Gate& instance() {
    static Gate& gate = *new Gate;
    return gate;
  }

  /// How often this thread is inside.
  static int& depth() {
    thread_local int depth = 0;
    return depth;
  }

  /// Returns unless Python ends by another thread: then this one stays here, without Python's lock.
  void wait(std::unique_lock<std::mutex>& lock) {
    if (!ending || ender == std::this_thread::get_id()) return;
    // Once Python has forgotten its threads, it says of each that it has the lock.
    const bool has_lock = PyGILState_Check() != 0 && PyGILState_GetThisThreadState() != nullptr;
    if (has_lock) PyEval_SaveThread();
    inside -= depth();
    changed.notify_all();
    changed.wait(lock, [] { return false; });
  }

  void enter() {
    std::unique_lock lock(mutex);
    wait(lock);
    ++entering;
  }

  void entered(int goes_inside) {
    const std::lock_guard lock(mutex);
    --entering;
    go_inside(goes_inside);
  }

  void left() {
    const std::lock_guard lock(mutex);
    go_inside(-1);
  }

  /// Asks for the mutex to be held.
  void go_inside(int steps) {
    inside += steps;
    depth() += steps;
    changed.notify_all();
  }

  /// Returns when nobody is about to take the lock any more, and, unless that takes long, nobody
  /// runs Python.
  void end() {
    std::unique_lock lock(mutex);
    ending = true;
    ender = std::this_thread::get_id();
    changed.wait(lock, [&] { return entering == 0; });
    changed.wait_for(lock, kLastWords, [&] { return inside == 0; });
  }
};

/// Python runs below C++ while it lives. A thread that Python ends there would take the objects of
/// the C++ with it, without the lock.
struct Inside {
  Inside() {
    Gate& gate = Gate::instance();
    std::unique_lock lock(gate.mutex);
    gate.wait(lock);
    gate.go_inside(1);
  }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;
  ~Inside() { Gate::instance().left(); }
};

/// In a forked child the other threads are gone.
void start_anew() {
  Gate& gate = Gate::instance();
  new (&gate) Gate;
  gate.inside = Gate::depth();
}

using Failure = std::optional<py::error_already_set>;

/// Calls once more what fails, for it may be an interrupt that has ended it, and more often what
/// interrupts end. Keeps what is raised first, or an interrupt, which the program must see.
template <class Call>
void do_one(Failure& failure, Call&& call) {
  for (int attempts_left = kAttempts; attempts_left > 0; --attempts_left) {
    try {
      call();
      return;
    } catch (py::error_already_set& error) {
      const bool interrupts = !error.matches(PyExc_Exception);
      if (!interrupts) attempts_left = std::min(attempts_left, 2);
      if (!failure || (interrupts && failure->matches(PyExc_Exception))) failure.emplace(error);
    }
  }
}

}  // namespace

py::object all_of(const py::function& steps) {
  py::options options;
  options.disable_function_signatures();
  const py::cpp_function done(
      [steps](const py::args& arguments) {
        const Inside inside;
        Failure failure;
        py::object all = py::tuple();
        do_one(failure, [&] { all = steps(*arguments); });
        for (const py::handle step : py::tuple(all)) do_one(failure, [&] { step(); });
        if (failure) throw *failure;
      },
      py::name(steps.attr("__name__").cast<std::string>().c_str()),
      py::doc(steps.attr("__doc__").is_none() ? ""
                                              : steps.attr("__doc__").cast<std::string>().c_str()));
  return py::reinterpret_steal<py::object>(PyInstanceMethod_New(done.ptr()));
}

Unlocked::~Unlocked() {
  Gate& gate = Gate::instance();
  gate.enter();
  PyEval_RestoreThread(state_);
  gate.entered(0);
}

Locked::Locked() {
  Gate& gate = Gate::instance();
  gate.enter();
  state_ = PyGILState_Ensure();
  gate.entered(1);
}

Locked::~Locked() {
  // Python ends, and this thread in the middle of it: it stays here until the process is gone.
  while (PyGILState_Check() == 0) std::this_thread::sleep_for(kLastWords);
  PyGILState_Release(state_);
  Gate::instance().left();
}

bool check_signals() {
  const Locked locked;
  if (Py_MakePendingCalls() != 0) throw py::error_already_set();
  return false;
}

bool raise_in_main_thread(const py::error_already_set& error) {
  auto kept = std::make_unique<py::error_already_set>(error);
  const auto raise = [](void* given) {
    std::unique_ptr<py::error_already_set>(static_cast<py::error_already_set*>(given))->restore();
    return -1;
  };
  if (Py_AddPendingCall(raise, kept.get()) != 0) return false;
  static_cast<void>(kept.release());
  return true;
}

void watch_interpreter() {
  const auto end = [] {
    PyThreadState* state = PyEval_SaveThread();
    Gate::instance().end();
    PyEval_RestoreThread(state);
  };
  // Last registered, first called. torsio.knob registers later, to close open knobs; that runs
  // while all threads still run.
  py::module_::import("atexit").attr("register")(py::cpp_function(end));
#ifndef _WIN32  // which does not fork
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") =
                                                         py::cpp_function(&start_anew));
#endif
}

}  // namespace torsio::bindings
