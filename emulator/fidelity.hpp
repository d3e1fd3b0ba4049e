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

/// The error of a run: what is estimated of it now, the worst so far, and what to compare it with.
///
/// The flow of the plant is not expansive: two motions under the same inputs never come further
/// apart in the energy norm
///
///     |d|^2 = sum J dw^2 + K dtwist^2 + (hand's stiffness) dangle^2,
///
/// because springs and dampers are linear and friction is monotone (Moreau's sweeping process, see
/// Brezis 1973). So an error that a run has once does not swell while exact steps follow. It is
/// carried on as it is, and an error of speed moves a knob that nothing holds until that rests.
class FidelityAccount {
 public:
  explicit FidelityAccount(double tolerance) : tolerance_(tolerance) {}

  [[nodiscard]] double tolerance() const { return tolerance_; }

  struct Error {
    double angle_rad = 0.0;    // of the knob
    double torque_nm = 0.0;    // of the shaft spring
    double speed_rad_s = 0.0;  // of the knob, where an error of it can drift on
  };
  /// So much is estimated to be added at this moment to what is carried.
  void meet(const Error& error);
  /// From now on so much more is carried.
  void carry(const Error& error);
  /// A step goes by in which an error of speed moves the knob, or the knob comes to rest.
  void drift(double duration_s);
  void rest() { carried_.speed_rad_s = 0.0; }

  /// The knob was seen there.
  void see(double angle_rad, double torque_nm);

  /// The worst so far.
  [[nodiscard]] double estimate() const { return relative(worst_); }
  /// Of what is carried.
  [[nodiscard]] double carried() const { return relative(carried_); }
  [[nodiscard]] double carried_with(const Error& error) const;
  [[nodiscard]] double peak_nm() const { return peak_nm_; }

  /// Begins anew: the plant was put somewhere else.
  void restart();

  /// @param step_ns that the choice's substeps make up
  [[nodiscard]] FidelityReport report(std::int64_t step_ns) const;

  // Kept for the stepper, which is made anew when another hand takes over.
  struct Counts {
    FidelityChoice choice{Method::exact, 1};  // in use
    std::array<std::int64_t, 4> by_method{};
    std::int64_t checked = 0;
    std::int64_t restarts = 0;
    double cost_ns = 0.0;
    double exact_cost_ns = 0.0;
  };
  Counts counts;
  /// What the stepper believes to be the error at this moment, beyond what is carried.
  Error pending;

 private:
  [[nodiscard]] double relative(const Error& error) const;

  double tolerance_;
  Error carried_;
  Error worst_;
  double lowest_rad_ = 0.0;
  double highest_rad_ = 0.0;
  double peak_nm_ = 0.0;
  bool seen_ = false;
};

/// Takes exact steps, unless a hand holds or leads the knob and another of fidelity_choices() keeps
/// the account's tolerance and pays.
/// @throws std::invalid_argument as make_exact_stepper does; step() throws std::runtime_error when
///         not even exact steps keep the tolerance
[[nodiscard]] std::unique_ptr<Stepper> make_fidelity_stepper(
    const PlantModel& model, const Integration& integration,
    const std::shared_ptr<FidelityAccount>& account);

}  // namespace torsio::emulator
