/// @file
/// The interface of a stepper: what takes the plant's equations through time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "emulator/plant/model.hpp"
#include "emulator/plant/state.hpp"

namespace torsio::emulator {

/// A way to take the plant's equations through one step of time. A stepper keeps no memory between
/// steps other than caches: its result is a function of state, inputs and duration alone.
class Stepper {
 public:
  Stepper() = default;
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;
  virtual ~Stepper() = default;

  /// Takes `state` forward by `duration_ns` > 0. Allocates nothing.
  virtual void step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) = 0;
};

/// Makes a stepper for a plant whose steps are mostly `step_ns` long. The emulator has the exact
/// one; others exist to be compared with it.
using MakeStepper = std::function<std::unique_ptr<Stepper>(PlantModel model, std::int64_t step_ns)>;

}  // namespace torsio::emulator
