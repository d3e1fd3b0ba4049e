/// @file
/// Targets of C's handles, and the end of every function: a result, never an exception.
#pragma once

#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "structures.hpp"
#include "torsio.h"
#include "torsio/hotplug.hpp"
#include "torsio/knob.hpp"

struct torsio_knob {
  torsio::Knob knob;
  std::mutex mutex{};  // guards `events`, which have left the knob and not yet this queue
  std::deque<torsio::Event> events{};
  std::deque<torsio::TruthSample> truth{};
};

struct torsio_scene {
  torsio::Scene effects{};
};

struct torsio_recording {
  torsio::TelemetryRecord samples{};
};

struct torsio_steps {
  torsio::Steps steps;
};

struct torsio_watch {
  torsio::DeviceWatch watch;
};

namespace torsio::c {

/// Keeps a sentence for torsio_last_error() and gives the result back. Needs no memory.
torsio_result fail(torsio_result result, const char* message) noexcept;
/// Keeps a sentence for torsio_last_warning().
void warn(const std::string& sentence) noexcept;
/// The result of the exception that is being handled.
torsio_result fail_with_current() noexcept;

/// Runs what a function does.
template <class Function>
torsio_result guarded(Function&& function) noexcept {
  try {
    std::forward<Function>(function)();
    return TORSIO_OK;
  } catch (...) {
    return fail_with_current();
  }
}

inline Knob& knob_of(torsio_knob* knob) { return need(knob, "knob").knob; }

/// Fills in size and defaults.
template <class Cpp, class C>
torsio_result init(C* structure) noexcept {
  return guarded([&] { need(structure, "structure") = to_c(Cpp{}); });
}

/// Puts an effect behind the others.
template <class C>
torsio_result add(torsio_scene* scene, const C* effect, const char* type) noexcept {
  return guarded([&] {
    need(scene, "scene").effects.emplace_back(from_c(need_sized(effect, "effect", type)));
  });
}

/// Gives what a member of Knob tells.
template <class C, class Member>
torsio_result get(torsio_knob* knob, C* out, const char* type, Member member) noexcept {
  return guarded([&] {
    C& known = need_sized(out, "the structure to fill in", type);
    known = to_c((knob_of(knob).*member)());
  });
}

/// Sets a configuration.
template <class Cpp, class C>
torsio_result configure(torsio_knob* knob, const C* config, const char* type) noexcept {
  return guarded([&] {
    const Cpp wanted = from_c(need_sized(config, "config", type));
    knob_of(knob).configure(wanted);
  });
}

}  // namespace torsio::c
