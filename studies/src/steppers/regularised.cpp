// Classical Runge-Kutta with friction smoothed to f tanh(speed / smoothing). It is a warning: a
// shaft that friction should hold creeps. A finer smoothing creeps less, but needs smaller steps.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "steppers/lag.hpp"
#include "steppers/steppers.hpp"

namespace torsio::studies {
namespace {

using emulator::HeldInputs;
using emulator::PlantModel;
using emulator::PlantState;
using emulator::Stepper;

class RegularisedStepper final : public Stepper {
 public:
  RegularisedStepper(PlantModel model, double smoothing_rad_s)
      : model_(std::move(model)), smoothing_rad_s_(smoothing_rad_s) {}

  void step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) override;

 private:
  struct Point {
    std::array<double, 3> speed;
    std::array<double, 2> twist;
    double travel;
  };

  /// Derivatives of a point, `time_s` after the begin of the step.
  [[nodiscard]] Point rates(const PlantState& begin, const HeldInputs& inputs, const Point& point,
                            double time_s) const;

  PlantModel model_;
  double smoothing_rad_s_;
};

RegularisedStepper::Point RegularisedStepper::rates(const PlantState& begin,
                                                    const HeldInputs& inputs, const Point& point,
                                                    double time_s) const {
  // Lags have solutions of their own; only the mechanics are integrated.
  const auto lagged = [&](double from, double to, double time_constant_s) {
    if (time_constant_s == 0.0) return to;
    return to + (from - to) * std::exp(-time_s / time_constant_s);
  };
  PlantState now = begin;
  now.knob_angle.add(point.travel);
  now.speed_rad_s = point.speed;
  now.twist_rad = point.twist;
  now.motor_torque_nm =
      lagged(begin.motor_torque_nm, inputs.motor_command_nm, model_.motor_time_constant_s);
  const double capacity_nm =
      model_.brake_drag_nm +
      lagged(begin.brake_magnetic_nm, begin.brake_target_nm, model_.brake_time_constant_s);
  Point rate{};
  const std::size_t last = static_cast<std::size_t>(model_.last_shaft());
  for (std::size_t i = 0; i <= last; ++i) {
    double torque = friction_demand_nm(model_, now, inputs, static_cast<int>(i));
    const double smooth_sign = std::tanh(point.speed[i] / smoothing_rad_s_);
    // The demand has the hand's torque at the begin of the step; its slope comes on top.
    if (i == 0) {
      torque += hand_force(model_, now, inputs).slope_nm_per_s * time_s;
      torque -= model_.knob_coulomb_nm * smooth_sign;
    }
    if (i == last && i > 0) torque -= capacity_nm * smooth_sign;
    rate.speed[i] = torque / model_.inertia_kg_m2[i];
  }
  if (model_.knob_is_driven()) rate.speed[0] = 0.0;
  for (std::size_t i = 0; i < last; ++i) rate.twist[i] = point.speed[i] - point.speed[i + 1];
  rate.travel = point.speed[0];
  return rate;
}

void RegularisedStepper::step(PlantState& state, const HeldInputs& inputs,
                              std::int64_t duration_ns) {
  const double step_s = 1e-9 * static_cast<double>(duration_ns);
  const auto moved = [](const Point& from, const Point& rate, double by_s) {
    Point to = from;
    for (std::size_t i = 0; i < 3; ++i) to.speed[i] += by_s * rate.speed[i];
    for (std::size_t i = 0; i < 2; ++i) to.twist[i] += by_s * rate.twist[i];
    to.travel += by_s * rate.travel;
    return to;
  };
  const Point begin{state.speed_rad_s, state.twist_rad, 0.0};
  const Point k1 = rates(state, inputs, begin, 0.0);
  const Point k2 = rates(state, inputs, moved(begin, k1, step_s / 2), step_s / 2);
  const Point k3 = rates(state, inputs, moved(begin, k2, step_s / 2), step_s / 2);
  const Point k4 = rates(state, inputs, moved(begin, k3, step_s), step_s);
  Point end = moved(begin, k1, step_s / 6);
  end = moved(end, k2, step_s / 3);
  end = moved(end, k3, step_s / 3);
  end = moved(end, k4, step_s / 6);

  state.time_ns += duration_ns;
  state.knob_angle.add(end.travel);
  state.speed_rad_s = end.speed;
  state.twist_rad = end.twist;
  for (std::size_t i = static_cast<std::size_t>(model_.shafts); i < 3; ++i) {
    state.speed_rad_s[i] = state.speed_rad_s[i - 1];
  }
  const auto lag = [&](double& value, double target, double time_constant_s) {
    const double left = Lag::over(step_s, time_constant_s).end;
    value = target + emulator::settled((value - target) * left);
  };
  lag(state.motor_torque_nm, inputs.motor_command_nm, model_.motor_time_constant_s);
  lag(state.brake_magnetic_nm, state.brake_target_nm, model_.brake_time_constant_s);
}

}  // namespace

std::unique_ptr<Stepper> make_regularised_stepper(PlantModel model, double smoothing_rad_s) {
  if (!std::isfinite(smoothing_rad_s) || smoothing_rad_s <= 0.0) {
    throw std::invalid_argument("smoothing_rad_s must be finite and > 0, is " +
                                std::to_string(smoothing_rad_s));
  }
  return std::make_unique<RegularisedStepper>(std::move(model), smoothing_rad_s);
}

}  // namespace torsio::studies
