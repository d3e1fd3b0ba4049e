#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "emulator/plant_stepper.hpp"

namespace torsio::emulator {

/// A way to cover one step of Integration::step_ns.
struct FidelityChoice {
  Method method;
  int substeps;  ///< of equal length that the step is cut into
};

/// What there is to choose from when a tolerance is asked for; the last one is exact. Smoothed
/// friction is not among them: it lets a held knob creep, by an error that grows with time.
[[nodiscard]] std::span<const FidelityChoice> fidelity_choices();

/// The error that no method goes below, relative: rounding, summed up over a run.
constexpr double kFinestTolerance = 1e-9;

/// What was chosen to keep a tolerance, and what came of it.
struct FidelityReport {
  double tolerance = 0.0;  ///< 0: none was asked for, and method and step_ns are as they were given
  Method method = Method::exact;  ///< in use now
  std::int64_t step_ns = 0;       ///< its step
  /// The larger of two estimates: of the knob's angle, as a fraction of the range that it has
  /// covered, and of the spring's torque, as a fraction of its peak. 0 without a tolerance.
  double estimated_error = 0.0;
  std::array<std::int64_t, 4> steps{};  ///< taken so far, by Method
  std::int64_t steps_checked = 0;       ///< that were also taken exactly, to estimate the error
  /// Work done over the work that the exact stepper alone would have had, checks included, from the
  /// nominal cost of steps; 1 without a tolerance.
  double relative_cost = 1.0;
};

/// The error of a run as it adds up. The flow of the plant is not expansive: two motions under the
/// same inputs never come further apart in the energy norm
///
///     |d|^2 = sum J dw^2 + K dtwist^2 + (hand's stiffness) dangle^2,
///
/// because springs and dampers are linear and friction is monotone (Moreau's sweeping process, see
/// Brezis 1973). So the error at any time is at most the sum of what the single steps add, each
/// measured against an exact step from the same begin. Which step is measured is the stepper's
/// affair; here they are summed.
class FidelityAccount {
 public:
  explicit FidelityAccount(double tolerance) : tolerance_(tolerance) {}

  [[nodiscard]] double tolerance() const { return tolerance_; }

  /// What one step adds, and how much of it reaches angle and torque.
  struct Defect {
    double energy_norm = 0.0;    // sqrt(J) rad
    double angle_rad = 0.0;      // of the knob
    double drift_rad_s = 0.0;    // speed of the whole
    double torque_per_norm = 0;  // N m of the spring at most, over energy_norm
  };
  void add(const Defect& defect, double weight);

  /// A step went by in which differences of speed move the knob, or are at an end.
  void drift(double duration_s) { angle_rad_ += drift_rad_s_ * duration_s; }
  void stop_drift() { drift_rad_s_ = 0.0; }

  /// The knob was seen there.
  void see(double angle_rad, double torque_nm);

  [[nodiscard]] double estimate() const { return estimate_with({}, 0.0); }
  /// The estimate if so many more defects came.
  [[nodiscard]] double estimate_with(const Defect& defect, double times) const;

  /// Begins anew: the plant was put somewhere else.
  void restart();

  /// @param step_ns that the choice's substeps make up
  [[nodiscard]] FidelityReport report(std::int64_t step_ns) const;

  // Kept for the stepper, which is made anew when another hand takes over.
  struct Counts {
    FidelityChoice choice{Method::exact, 1};  // in use
    std::array<std::int64_t, 4> by_method{};
    std::int64_t checked = 0;
    double cost_ns = 0.0;
    double exact_cost_ns = 0.0;
  };
  Counts counts;

 private:
  double tolerance_;
  double torque_nm_ = 0.0;
  double angle_rad_ = 0.0;
  double drift_rad_s_ = 0.0;
  double lowest_rad_ = 0.0;
  double highest_rad_ = 0.0;
  double peak_nm_ = 0.0;
  bool seen_ = false;
};

/// Takes in each step the cheapest of fidelity_choices() that keeps the account's tolerance.
/// @throws std::invalid_argument as make_exact_stepper does; step() throws std::runtime_error when
///         not even exact steps keep the tolerance
[[nodiscard]] std::unique_ptr<Stepper> make_fidelity_stepper(
    const PlantModel& model, const Integration& integration,
    const std::shared_ptr<FidelityAccount>& account);

}  // namespace torsio::emulator
