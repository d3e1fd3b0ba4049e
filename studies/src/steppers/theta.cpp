// theta-method with set-valued friction, after Moreau and Jean: velocities and friction impulses of
// one step are solved together, so that friction holds a shaft exactly and never overshoots.
//
//     A v+ = r + friction,   A = J/h + theta (B + theta h S)
//     r = J v/h - (1 - theta)(B + theta h S) v + forces at the old positions
//
// with J inertia, B damping, S stiffness. Positions follow from theta v+ + (1 - theta) v, the lags
// from their exact exponentials averaged over the step.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <tuple>
#include <utility>

#include "steppers/contacts.hpp"
#include "steppers/lag.hpp"
#include "steppers/steppers.hpp"

namespace torsio::studies {
namespace {

using emulator::CoggingPiece;
using emulator::HandForce;
using emulator::HeldInputs;
using emulator::PlantModel;
using emulator::PlantState;
using emulator::SpringPiece;
using emulator::Stepper;
using Vector = std::array<double, 3>;
using Matrix = std::array<std::array<double, 3>, 3>;

/// Inverse of a positive definite matrix of the first n rows and columns.
Matrix invert(Matrix matrix, std::size_t n) {
  Matrix inverse{};
  for (std::size_t i = 0; i < n; ++i) inverse[i][i] = 1.0;
  for (std::size_t pivot = 0; pivot < n; ++pivot) {
    const double scale = 1.0 / matrix[pivot][pivot];
    for (std::size_t j = 0; j < n; ++j) {
      matrix[pivot][j] *= scale;
      inverse[pivot][j] *= scale;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (i == pivot) continue;
      const double factor = matrix[i][pivot];
      for (std::size_t j = 0; j < n; ++j) {
        matrix[i][j] -= factor * matrix[pivot][j];
        inverse[i][j] -= factor * inverse[pivot][j];
      }
    }
  }
  return inverse;
}

class ThetaStepper final : public Stepper {
 public:
  ThetaStepper(PlantModel model, double theta)
      : model_(std::move(model)), shafts_(static_cast<std::size_t>(model_.shafts)), theta_(theta) {}

  void step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) override;

 private:
  struct Key {
    std::int64_t duration_ns = 0;
    double shaft_stiffness = 0.0;
    double knob_stiffness = 0.0;
    bool operator==(const Key&) const = default;
  };
  void prepare(const Key& key);
  [[nodiscard]] Vector solve_speeds(const Vector& rhs, double knob_nm, double brake_nm) const;

  PlantModel model_;
  std::size_t shafts_;
  double theta_;
  Key key_;
  double step_s_ = 0.0;
  Matrix damping_{};  // B + theta h S
  Matrix inverse_{};
  Lag motor_lag_;
  Lag brake_lag_;
};

void ThetaStepper::prepare(const Key& key) {
  if (key == key_) return;
  if (key.duration_ns != key_.duration_ns) {
    step_s_ = 1e-9 * static_cast<double>(key.duration_ns);
    motor_lag_ = Lag::over(step_s_, model_.motor_time_constant_s);
    brake_lag_ = Lag::over(step_s_, model_.brake_time_constant_s);
  }
  key_ = key;
  damping_ = {};
  damping_[0][0] = theta_ * step_s_ * key.knob_stiffness;
  const std::array<double, 2> stiffness{key.shaft_stiffness, model_.belt_stiffness_nm_per_rad};
  for (std::size_t i = 0; i < shafts_; ++i) damping_[i][i] += model_.viscous_nm_s_per_rad[i];
  for (std::size_t spring = 0; spring + 1 < shafts_; ++spring) {
    const double link = model_.damping_nm_s_per_rad[spring] + theta_ * step_s_ * stiffness[spring];
    damping_[spring][spring] += link;
    damping_[spring + 1][spring + 1] += link;
    damping_[spring][spring + 1] -= link;
    damping_[spring + 1][spring] -= link;
  }
  Matrix a{};
  for (std::size_t i = 0; i < shafts_; ++i) {
    for (std::size_t j = 0; j < shafts_; ++j) a[i][j] = theta_ * damping_[i][j];
    a[i][i] += model_.inertia_kg_m2[i] / step_s_;
  }
  if (model_.knob_is_driven()) {
    // The first equation becomes: speed of the knob = right side.
    a[0] = {1.0, 0.0, 0.0};
  }
  inverse_ = invert(a, shafts_);
}

Vector ThetaStepper::solve_speeds(const Vector& rhs, double knob_nm, double brake_nm) const {
  Vector speed{};
  for (std::size_t i = 0; i < shafts_; ++i) {
    for (std::size_t j = 0; j < shafts_; ++j) speed[i] += inverse_[i][j] * rhs[j];
  }
  const std::size_t last = shafts_ - 1;
  const Contact knob{inverse_[0][0], speed[0], -knob_nm, knob_nm};
  const Contact brake{inverse_[last][last], speed[last], -brake_nm, brake_nm};
  double knob_force = 0.0;
  double brake_force = 0.0;
  if (last == 0) {
    if (!model_.knob_is_driven()) knob_force = solve_contact(knob);
  } else if (model_.knob_is_driven()) {
    brake_force = solve_contact(brake);
  } else {
    std::tie(knob_force, brake_force) = solve_contacts(knob, brake, inverse_[0][last]);
  }
  for (std::size_t i = 0; i < shafts_; ++i) {
    speed[i] += inverse_[i][0] * knob_force;
    if (last > 0) speed[i] += inverse_[i][last] * brake_force;
  }
  // A force inside its bounds is one that holds: the speed is 0 by its very definition.
  if (!model_.knob_is_driven() && std::abs(knob_force) < knob_nm) speed[0] = 0.0;
  if (last > 0 && std::abs(brake_force) < brake_nm) speed[last] = 0.0;
  return speed;
}

void ThetaStepper::step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) {
  const CoggingPiece cogging = cogging_at(model_, state.knob_angle);
  SpringPiece spring{0.0, 0.0, 0.0, 0.0};
  if (model_.has_spring()) {
    spring =
        model_.shaft_spring[static_cast<std::size_t>(spring_piece_at(model_, state.twist_rad[0]))];
  }
  prepare({duration_ns, spring.stiffness_nm_per_rad,
           model_.hand_stiffness_nm_per_rad - cogging.slope_nm_per_rad});

  const HandForce hand = hand_force(model_, state, inputs);
  const double motor_gap = state.motor_torque_nm - inputs.motor_command_nm;
  const double brake_gap = state.brake_magnetic_nm - state.brake_target_nm;
  const std::array<double, 2> twisting{
      spring.stiffness_nm_per_rad * (state.twist_rad[0] - spring.rest_rad),
      model_.belt_stiffness_nm_per_rad * state.twist_rad[1]};

  const Vector old = state.speed_rad_s;
  Vector rhs{};
  rhs[0] = inputs.motor_command_nm + motor_gap * motor_lag_.mean + cogging.torque_nm +
           hand.force_nm + theta_ * step_s_ * hand.slope_nm_per_s;
  for (std::size_t i = 0; i < shafts_; ++i) {
    rhs[i] += model_.inertia_kg_m2[i] / step_s_ * old[i];
    for (std::size_t j = 0; j < shafts_; ++j) rhs[i] -= (1.0 - theta_) * damping_[i][j] * old[j];
    if (i + 1 < shafts_) rhs[i] -= twisting[i];
    if (i > 0) rhs[i] += twisting[i - 1];
  }
  if (model_.knob_is_driven()) rhs[0] = inputs.hand.slope_per_s;
  const double brake_nm =
      model_.brake_drag_nm + state.brake_target_nm + brake_gap * brake_lag_.mean;
  const Vector speed = solve_speeds(rhs, model_.knob_coulomb_nm, brake_nm);

  Vector moved{};
  for (std::size_t i = 0; i < shafts_; ++i) {
    moved[i] = step_s_ * (theta_ * speed[i] + (1.0 - theta_) * old[i]);
    state.speed_rad_s[i] = speed[i];
  }
  for (std::size_t i = shafts_; i < 3; ++i) {
    moved[i] = moved[i - 1];
    state.speed_rad_s[i] = state.speed_rad_s[i - 1];
  }
  state.knob_angle.add(moved[0]);
  state.twist_rad[0] += moved[0] - moved[1];
  state.twist_rad[1] += moved[1] - moved[2];
  state.motor_torque_nm = inputs.motor_command_nm + emulator::settled(motor_gap * motor_lag_.end);
  state.brake_magnetic_nm = state.brake_target_nm + emulator::settled(brake_gap * brake_lag_.end);
  state.time_ns += duration_ns;
}

}  // namespace

std::unique_ptr<Stepper> make_theta_stepper(PlantModel model, double theta) {
  return std::make_unique<ThetaStepper>(std::move(model), theta);
}

}  // namespace torsio::studies
