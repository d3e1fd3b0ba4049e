#include "emulator/fidelity.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace torsio::emulator {
namespace {

// Smaller ranges than these are not worth a relative error: a knob that nobody has moved yet has a
// range of 0. An encoder of 8192 counts resolves 0.8e-3 rad, and friction hides 1e-3 N m.
constexpr double kSmallestRangeRad = 1e-3;
constexpr double kSmallestPeakNm = 1e-3;

// theta = 1/2 is of second order where nothing sticks or slips within a step; theta = 1 is only of
// first order but forgets what is too fast for its steps, where 1/2 rings.
constexpr std::array kChoices{
    FidelityChoice{Method::trapezoid, 1}, FidelityChoice{Method::semi_implicit, 1},
    FidelityChoice{Method::trapezoid, 2}, FidelityChoice{Method::trapezoid, 4},
    FidelityChoice{Method::exact, 1},
};

}  // namespace

std::span<const FidelityChoice> fidelity_choices() { return kChoices; }

void FidelityAccount::meet(const Error& error) {
  worst_.angle_rad = std::max(worst_.angle_rad, carried_.angle_rad + error.angle_rad);
  worst_.torque_nm = std::max(worst_.torque_nm, carried_.torque_nm + error.torque_nm);
}

void FidelityAccount::carry(const Error& error) {
  carried_.angle_rad += error.angle_rad;
  carried_.torque_nm += error.torque_nm;
  carried_.speed_rad_s += error.speed_rad_s;
  meet({});
}

void FidelityAccount::drift(double duration_s) {
  if (carried_.speed_rad_s == 0.0) return;
  carried_.angle_rad += carried_.speed_rad_s * duration_s;
  meet({});
}

void FidelityAccount::see(double angle_rad, double torque_nm) {
  lowest_rad_ = seen_ ? std::min(lowest_rad_, angle_rad) : angle_rad;
  highest_rad_ = seen_ ? std::max(highest_rad_, angle_rad) : angle_rad;
  peak_nm_ = std::max(peak_nm_, std::abs(torque_nm));
  seen_ = true;
}

double FidelityAccount::relative(const Error& error) const {
  return std::max(error.torque_nm / std::max(peak_nm_, kSmallestPeakNm),
                  error.angle_rad / std::max(highest_rad_ - lowest_rad_, kSmallestRangeRad));
}

double FidelityAccount::carried_with(const Error& error) const {
  return relative({carried_.angle_rad + error.angle_rad, carried_.torque_nm + error.torque_nm});
}

void FidelityAccount::restart() {
  const Counts kept = counts;
  *this = FidelityAccount(tolerance_);
  counts = kept;  // work done stays done
  ++counts.restarts;
}

FidelityReport FidelityAccount::report(std::int64_t step_ns) const {
  return {
      .tolerance = tolerance_,
      .method = counts.choice.method,
      .step_ns = step_ns / counts.choice.substeps,
      .estimated_error = estimate(),
      .steps = counts.by_method,
      .steps_checked = counts.checked,
      .relative_cost = counts.exact_cost_ns > 0.0 ? counts.cost_ns / counts.exact_cost_ns : 1.0};
}

}  // namespace torsio::emulator
