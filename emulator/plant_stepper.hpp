#pragma once

#include <cstdint>
#include <memory>

#include "emulator/plant_model.hpp"
#include "emulator/plant_params.hpp"
#include "emulator/plant_state.hpp"

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

  /// Work done so far, as nanoseconds of a nominal machine: the same on every machine, so that what
  /// is decided by it is repeatable. `./dev bench emulator` sets real nanoseconds beside them.
  [[nodiscard]] double nominal_cost_ns() const { return nominal_cost_ns_; }

 protected:
  double nominal_cost_ns_ = 0.0;
};

/// Exact but for rounding: matrix exponentials between located events.
/// @param step_ns the duration that most steps have; others are as exact, and slower
/// @throws std::invalid_argument if the plant moves too fast for any such step
[[nodiscard]] std::unique_ptr<Stepper> make_exact_stepper(PlantModel model, std::int64_t step_ns);

/// theta-method with set-valued friction; theta 1 is semi-implicit, 1/2 the trapezoid rule.
[[nodiscard]] std::unique_ptr<Stepper> make_theta_stepper(PlantModel model, double theta);

/// Runge-Kutta 4 over friction that is smoothed around rest; see plant_rk4.cpp for what it is for.
[[nodiscard]] std::unique_ptr<Stepper> make_regularised_stepper(PlantModel model,
                                                                double smoothing_rad_s);

/// Nominal cost of one step of make_theta_stepper()'s.
[[nodiscard]] double theta_step_cost_ns(const PlantModel& model);

/// The stepper that `integration` names.
[[nodiscard]] std::unique_ptr<Stepper> make_stepper(PlantModel model,
                                                    const Integration& integration);

}  // namespace torsio::emulator
