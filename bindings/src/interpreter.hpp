/// @file
/// Letting go of the interpreter's lock and taking it, also while the interpreter ends.
///
/// A thread that asks for the lock of an interpreter that is ending is ended itself, out of the
/// middle of C++, which aborts the process. So from then on only the thread that ends the
/// interpreter asks for it. The others stop where they are until the process is gone.
#pragma once

#include <pybind11/pybind11.h>

namespace torsio::bindings {

/// How often what an interrupt ends is called at most, if it must be done.
inline constexpr int kAttempts = 10;

/// Other threads may run while it lives.
class Unlocked {
 public:
  Unlocked() : state_(PyEval_SaveThread()) {}
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;
  ~Unlocked();

 private:
  PyThreadState* state_;
};

/// This thread may use Python while it lives.
class Locked {
 public:
  Locked();
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;
  ~Locked();

 private:
  PyGILState_STATE state_;
};

/// For `interrupted`: in the main thread runs Python's signal handlers and what waits for this
/// thread, and never says so itself.
/// @throws what they raise (KeyboardInterrupt), which ends the waiting call
bool check_signals();

/// Has the main thread raise it next, as Python does with what a signal's handler raises.
/// @returns false if too many wait
bool raise_in_main_thread(const pybind11::error_already_set& error);

/// Turns a Python function that gives steps into one that does them. It does each step even if
/// another raises, and Ctrl-C cannot leave one out.
pybind11::object all_of(const pybind11::function& steps);

/// Has the interpreter say when it begins to end.
void watch_interpreter();

}  // namespace torsio::bindings
