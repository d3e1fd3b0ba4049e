/// @file
/// How a method of the library becomes one of Python: arguments, lock, result.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "bytes.hpp"
#include "interpreter.hpp"
#include "module.hpp"
#include "own_transport.hpp"
#include "python_values.hpp"
#include "torsio/knob.hpp"

namespace torsio::bindings {

/// Closing waits for the device, so the lock must be free whichever way the knob goes.
class PyKnob {
 public:
  PyKnob(Knob&& knob, std::shared_ptr<Passing> passing)
      : knob_(std::make_unique<Knob>(std::move(knob))), passing_(std::move(passing)) {}
  PyKnob(PyKnob&&) = default;
  PyKnob(const PyKnob&) = delete;
  PyKnob& operator=(const PyKnob&) = delete;
  ~PyKnob() {
    if (!knob_) return;
    const Unlocked unlocked;
    knob_.reset();
  }

  Knob& operator*() const { return *get(); }
  Knob* operator->() const { return get(); }

  /// Runs what may wait without the interpreter's lock. Throws what a transport keeps for the
  /// program; signs of life and close() throw nothing themselves.
  template <class Act>
  auto run(Act&& act) const {
    if constexpr (std::is_void_v<decltype(act())>) {
      take(act);
      pass_on();
    } else {
      auto result = take(act);
      pass_on();
      return result;
    }
  }
  /// The same, but its result comes first; pass_on() must follow.
  template <class Act>
  auto take(Act&& act) const {
    try {
      const Unlocked unlocked;
      return act();
    } catch (...) {
      pass_on();
      throw;
    }
  }
  void pass_on() const { passing_->pass_on(); }

 private:
  /// A hand's function would wait for the step that waits for the function.
  [[nodiscard]] Knob* get() const {
    if (is_in_hand()) {
      throw Error(
          "the function of a hand cannot use a knob, because it runs in the middle of a step of "
          "the plant; use its arguments");
    }
    if (passing_->is_in_transport()) {
      throw Error(
          "a transport cannot use the knob behind it, nor can the handler of a signal that "
          "interrupts the transport");
    }
    return knob_.get();
  }

  std::unique_ptr<Knob> knob_;
  std::shared_ptr<Passing> passing_;
};

inline py::array as_record(std::vector<TelemetrySample>&& samples) {
  clear_padding(samples);
  return as_array(std::move(samples));
}

/// Python's argument where a method takes a T.
template <class T>
using Given =
    std::conditional_t<std::is_arithmetic_v<T> || std::is_same_v<T, std::optional<double>>, T,
                       py::object>;

template <class T>
T take(const Given<T>& given) {
  if constexpr (std::is_same_v<T, Given<T>>) {
    return given;
  } else if constexpr (Listed<T>) {
    return from_python<T>(given);
  } else if constexpr (Named<T>) {
    const auto name = given.template cast<std::string>();
    std::string allowed;
    for (std::size_t i = 0; i < Names<T>::values.size(); ++i) {
      if (Names<T>::values[i] == name) return static_cast<T>(i);
      allowed += (i == 0 ? "" : ", ") + std::string(Names<T>::values[i]);
    }
    // Every method that takes a name calls it so.
    throw InvalidArgument("state is \"" + name + "\", allowed are " + allowed);
  } else if constexpr (std::is_same_v<T, Scene>) {
    return scene_from_python(given);
  } else if constexpr (std::is_same_v<T, Hand>) {
    return hand_from_python(given);
  } else {
    return bytes_of(given);
  }
}

/// A method's result, as Python has it.
template <class T>
py::object told(T&& value) {
  if constexpr (std::is_same_v<T, std::vector<TruthSample>>) {
    return as_array(std::move(value));
  } else if constexpr (std::is_same_v<T, std::vector<TelemetrySample>>) {
    return as_record(std::move(value));
  } else if constexpr (std::is_same_v<T, TelemetrySample>) {
    return as_record({value});
  } else if constexpr (std::is_convertible_v<T, std::span<const std::uint8_t>>) {
    return to_bytes(value);
  } else {
    return to_python(value);
  }
}

/// The knob, the world round an emulated one, or its game interface.
template <class Owner>
Owner& owner_in(const PyKnob& self) {
  if constexpr (std::is_same_v<Owner, Knob>) {
    return *self;
  } else if constexpr (std::is_same_v<Owner, Emulator>) {
    return self->emulator();
  } else {
    return self->emulator().game();
  }
}

/// A method of the library as Python calls it. It runs without the interpreter's lock, because it
/// may take long or call a hand's function.
template <class Owner, class Result, class... Parameters>
struct Calling {
  template <class Method>
  static auto by(Method method) {
    return [method](const PyKnob& self, const Given<std::decay_t<Parameters>>&... given) {
      const std::tuple<std::decay_t<Parameters>...> taken{take<std::decay_t<Parameters>>(given)...};
      const auto run = [&] {
        return self.run([&] {
          return std::apply(
              [&](const auto&... each) { return (owner_in<Owner>(self).*method)(each...); }, taken);
        });
      };
      if constexpr (std::is_void_v<Result>) {
        run();
      } else {
        return told(run());
      }
    };
  }
};

template <class Owner, class Result, class... Parameters>
auto call(Result (Owner::*method)(Parameters...)) {
  return Calling<Owner, Result, Parameters...>::by(method);
}
template <class Owner, class Result, class... Parameters>
auto call(Result (Owner::*method)(Parameters...) const) {
  return Calling<Owner, Result, Parameters...>::by(method);
}

}  // namespace torsio::bindings
