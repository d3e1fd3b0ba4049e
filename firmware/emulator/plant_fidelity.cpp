// Takes each step with the cheapest method that keeps a tolerance.
//
// Some steps, the samples, are checked: they are also taken exactly, and by every choice that would
// be cheaper, all from the same begin. So it is known what each choice would have added to the
// error and what exact steps cost. Steps in which friction changes are one kind and all others
// another, because they differ by orders of magnitude in both; each kind is sampled on its own, at
// first every step and in the long run one in 16, and a sample stands for all steps of its kind
// since the one before. (Step doubling would not do: it presumes an order of convergence, which is
// 1 at best where friction changes, and two half steps cost as much as one exact step.)
//
// The tolerance is a budget. A choice is taken if, after as much time again as has passed so far,
// half of the tolerance would still not be spent; so what a run spends does not depend on its
// length. When most of it is gone, exact steps, which add nothing, are all that is left.
//
// Decisions depend on the motion alone, never on a clock, and so are repeatable.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "emulator/fidelity.hpp"
#include "emulator/plant_stepper.hpp"

namespace torsio::emulator {
namespace {

using Defect = FidelityAccount::Defect;

constexpr std::size_t kMostChoices = 8;      // besides exact steps
constexpr int kDecideEvery = 64;             // steps
constexpr std::int64_t kSampleOneIn = 16;    // in the long run, ...
constexpr std::int64_t kSampleExactIn = 64;  // ... and while steps are exact, which costs no error
constexpr std::int64_t kSampleShare = 8;     // until then so many to a doubling, nearly
constexpr std::int64_t kHalvesOneIn = 4;     // samples of exact steps that are checked with halves
constexpr std::int64_t kFewestSamples = 8;   // that a choice is judged by
constexpr double kSpendable = 0.5;           // of the tolerance, by plan
constexpr double kExhausted = 0.9;           // of the tolerance, whatever the plan
constexpr double kLeastSaving = 0.9;         // of the exact cost; a change for less is not worth it
constexpr double kForget = 1.0 / 32.0;       // weight of the newest sample in a recent mean

/// Steps of one kind and what samples of them have shown.
struct Kind {
  std::int64_t steps = 0;
  std::int64_t sampled_at = 0;  // value of `steps`
  std::int64_t next_sample = 1;
  std::int64_t samples = 0;
  std::int64_t halved_at = 0;  // value of `steps`
  double exact_cost_ns = 0.0;  // recent mean
  struct Added {
    std::int64_t samples = 0;
    Defect mean;
    Defect recent;
  };
  std::array<Added, kMostChoices> added;  // by each choice, in one step
};

void blend(Defect& mean, const Defect& sample, double weight) {
  mean.energy_norm += weight * (sample.energy_norm - mean.energy_norm);
  mean.angle_rad += weight * (sample.angle_rad - mean.angle_rad);
  mean.drift_rad_s += weight * (sample.drift_rad_s - mean.drift_rad_s);
}

Defect larger(const Defect& a, const Defect& b) {
  return {std::max(a.energy_norm, b.energy_norm), std::max(a.angle_rad, b.angle_rad),
          std::max(a.drift_rad_s, b.drift_rad_s), 0.0};
}

double angle_between(const Angle& a, const Angle& b) {
  return static_cast<double>(a.revolutions - b.revolutions) * Angle::kTurnRad +
         (a.fraction_rad - b.fraction_rad);
}

class FidelityStepper final : public Stepper {
 public:
  FidelityStepper(const PlantModel& model, const Integration& integration,
                  std::shared_ptr<FidelityAccount> account);

  void step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) override;

 private:
  static constexpr std::size_t kExact = static_cast<std::size_t>(-1);

  /// Everything that changes from step to step, so that a step can be taken back.
  struct Memory {
    std::array<Kind, 2> kinds;
    std::size_t chosen = kExact;
    int until_decision = kDecideEvery;
    std::int64_t steps = 0;
  };

  void take(std::size_t choice, PlantState& state, const HeldInputs& inputs,
            std::int64_t duration_ns);
  [[nodiscard]] double cost_of(std::size_t choice) const;
  [[nodiscard]] Defect between(const PlantState& a, const PlantState& b) const;
  [[nodiscard]] bool friction_changes(const PlantState& a, const PlantState& b) const;
  void check(Kind& kind, const PlantState& before, const PlantState& after,
             const HeldInputs& inputs, std::int64_t duration_ns, double cost_ns);
  [[nodiscard]] double exact_cost_of_kinds() const;
  void decide();
  void choose(std::size_t choice) {
    now_.chosen = choice;
    account_->counts.choice =
        choice == kExact ? FidelityChoice{Method::exact, 1} : choices_[choice];
  }

  PlantModel model_;
  std::shared_ptr<FidelityAccount> account_;
  std::int64_t step_ns_;
  std::unique_ptr<Stepper> exact_;
  std::unique_ptr<Stepper> halves_;      // exact steps of half the length, to check the exact ones
  std::vector<FidelityChoice> choices_;  // the cheap ones
  std::vector<std::unique_ptr<Stepper>> cheap_;
  double torque_per_norm_ = 0.0;
  double total_inertia_ = 0.0;
  double stiffest_ = 0.0;

  Memory now_;
  // Before the last step, if that did not end on the grid: the plant may take it again.
  std::int64_t begin_ns_ = -1;
  Memory before_;
  FidelityAccount account_before_{0.0};
};

FidelityStepper::FidelityStepper(const PlantModel& model, const Integration& integration,
                                 std::shared_ptr<FidelityAccount> account)
    : model_(model),
      account_(std::move(account)),
      step_ns_(integration.step_ns),
      exact_(make_exact_stepper(model, integration.step_ns)),
      halves_(make_exact_stepper(model, std::max<std::int64_t>(1, integration.step_ns / 2))) {
  for (const FidelityChoice& choice : fidelity_choices()) {
    if (choice.method == Method::exact || choice.substeps > step_ns_) continue;
    if (choices_.size() == kMostChoices) break;
    choices_.push_back(choice);
    cheap_.push_back(make_theta_stepper(model, choice.method == Method::trapezoid ? 0.5 : 1.0));
  }
  choose(kExact);
  for (const SpringPiece& piece : model_.shaft_spring) {
    stiffest_ = std::max(stiffest_, piece.stiffness_nm_per_rad);
  }
  double inverse_inertia = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model_.shafts); ++i) {
    total_inertia_ += model_.inertia_kg_m2[i];
    if (i < 2) inverse_inertia += 1.0 / model_.inertia_kg_m2[i];
  }
  if (model_.has_spring()) {
    torque_per_norm_ =
        std::sqrt(stiffest_) + model_.damping_nm_s_per_rad[0] * std::sqrt(inverse_inertia);
  }
}

void FidelityStepper::take(std::size_t choice, PlantState& state, const HeldInputs& inputs,
                           std::int64_t duration_ns) {
  if (choice == kExact) {
    exact_->step(state, inputs, duration_ns);
    return;
  }
  const std::int64_t substeps = std::min<std::int64_t>(choices_[choice].substeps, duration_ns);
  const std::int64_t begin_ns = state.time_ns;
  for (std::int64_t i = 1; i <= substeps; ++i) {
    const std::int64_t end_ns = begin_ns + duration_ns * i / substeps;
    cheap_[choice]->step(state, inputs, end_ns - state.time_ns);
  }
}

double FidelityStepper::cost_of(std::size_t choice) const {
  return choices_[choice].substeps * theta_step_cost_ns(model_.shafts);
}

Defect FidelityStepper::between(const PlantState& a, const PlantState& b) const {
  const double angle = angle_between(a.knob_angle, b.knob_angle);
  double square = model_.hand_stiffness_nm_per_rad * angle * angle;
  double momentum = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model_.shafts); ++i) {
    const double speed = a.speed_rad_s[i] - b.speed_rad_s[i];
    square += model_.inertia_kg_m2[i] * speed * speed;
    momentum += model_.inertia_kg_m2[i] * speed;
  }
  const double twist = a.twist_rad[0] - b.twist_rad[0];
  const double belt = a.twist_rad[1] - b.twist_rad[1];
  square += stiffest_ * twist * twist + model_.belt_stiffness_nm_per_rad * belt * belt;
  return {std::sqrt(square), std::abs(angle), std::abs(momentum) / total_inertia_,
          torque_per_norm_};
}

bool FidelityStepper::friction_changes(const PlantState& a, const PlantState& b) const {
  const auto sign = [](double speed) { return (speed > 0.0) - (speed < 0.0); };
  const auto last = static_cast<std::size_t>(model_.last_shaft());
  return sign(a.speed_rad_s[0]) != sign(b.speed_rad_s[0]) ||
         sign(a.speed_rad_s[last]) != sign(b.speed_rad_s[last]);
}

void FidelityStepper::step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) {
  if (state.time_ns == begin_ns_) {
    now_ = before_;
    *account_ = account_before_;
  }
  begin_ns_ = -1;
  if (duration_ns < step_ns_) {
    begin_ns_ = state.time_ns;
    before_ = now_;
    account_before_ = *account_;
  }

  const std::size_t choice = now_.chosen;
  const PlantState before = state;
  const double cost_before_ns = exact_->nominal_cost_ns();
  take(choice, state, inputs, duration_ns);
  const double cost_ns =
      choice == kExact ? exact_->nominal_cost_ns() - cost_before_ns : cost_of(choice);

  FidelityAccount::Counts& counts = account_->counts;
  ++counts.by_method[static_cast<std::size_t>(choice == kExact ? Method::exact
                                                               : choices_[choice].method)];
  counts.cost_ns += cost_ns;
  Kind& kind = now_.kinds[friction_changes(before, state) ? 1 : 0];
  ++kind.steps;
  if (choice != kExact) {
    const bool moves = model_.hand_stiffness_nm_per_rad == 0.0 && !model_.knob_is_driven() &&
                       state.speed_rad_s[0] != 0.0 && state.brake_speed_rad_s() != 0.0;
    if (moves) {
      account_->drift(1e-9 * static_cast<double>(duration_ns));
    } else {
      account_->stop_drift();
    }
  }
  counts.exact_cost_ns += choice == kExact ? cost_ns : kind.exact_cost_ns;
  if (kind.steps >= kind.next_sample) check(kind, before, state, inputs, duration_ns, cost_ns);
  ++now_.steps;
  if (--now_.until_decision <= 0) decide();
}

void FidelityStepper::check(Kind& kind, const PlantState& before, const PlantState& after,
                            const HeldInputs& inputs, std::int64_t duration_ns, double cost_ns) {
  const std::size_t chosen = now_.chosen;
  FidelityAccount::Counts& counts = account_->counts;
  const auto stands_for = static_cast<double>(kind.steps - kind.sampled_at);
  kind.sampled_at = kind.steps;
  kind.next_sample =
      kind.steps + std::clamp<std::int64_t>(kind.steps / kSampleShare, 1,
                                            chosen == kExact ? kSampleExactIn : kSampleOneIn);
  ++kind.samples;
  ++counts.checked;

  PlantState exact = after;
  double exact_cost_ns = cost_ns;
  if (chosen == kExact) {
    if (kind.samples % kHalvesOneIn == 0) {
      // Two exact steps of half the length go other ways through the stepper; what they differ by
      // is what rounding does.
      PlantState halves = before;
      const double halves_before_ns = halves_->nominal_cost_ns();
      halves_->step(halves, inputs, duration_ns - duration_ns / 2);
      if (duration_ns > 1) halves_->step(halves, inputs, duration_ns / 2);
      counts.cost_ns += halves_->nominal_cost_ns() - halves_before_ns;
      account_->add(between(halves, after), static_cast<double>(kind.steps - kind.halved_at));
      kind.halved_at = kind.steps;
    }
  } else {
    exact = before;
    const double before_ns = exact_->nominal_cost_ns();
    exact_->step(exact, inputs, duration_ns);
    exact_cost_ns = exact_->nominal_cost_ns() - before_ns;
    counts.cost_ns += exact_cost_ns;
    account_->add(between(after, exact), stands_for);
  }
  account_->see(exact.knob_angle_rad(),
                model_.has_spring() ? spring_torque_nm(model_, exact.twist_rad[0]) : 0.0);
  // The first samples count alike.
  const double weight = std::max(kForget, 1.0 / static_cast<double>(kind.samples));
  kind.exact_cost_ns += weight * (exact_cost_ns - kind.exact_cost_ns);

  const double worth_ns = kLeastSaving * exact_cost_of_kinds();
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    if (i != chosen && cost_of(i) > worth_ns) continue;
    Defect added;
    if (i == chosen) {
      added = between(after, exact);
    } else {
      PlantState other = before;
      take(i, other, inputs, duration_ns);
      counts.cost_ns += cost_of(i);
      added = between(other, exact);
    }
    Kind::Added& known = kind.added[i];
    ++known.samples;
    const double share = 1.0 / static_cast<double>(known.samples);
    blend(known.mean, added, share);
    blend(known.recent, added, std::max(kForget, share));
  }

  const double estimate = account_->estimate();
  if (chosen == kExact && estimate > account_->tolerance() && counts.by_method[1] == 0 &&
      counts.by_method[2] == 0) {
    std::ostringstream text;
    text << "plant: nothing keeps the tolerance " << account_->tolerance()
         << " in this scene: rounding alone adds up to " << estimate << " after "
         << 1e-9 * static_cast<double>(after.time_ns) << " s";
    throw std::runtime_error(text.str());
  }
  if (chosen != kExact && estimate > kExhausted * account_->tolerance()) choose(kExact);
}

double FidelityStepper::exact_cost_of_kinds() const {
  double cost_ns = 0.0;
  for (const Kind& kind : now_.kinds) {
    cost_ns += static_cast<double>(kind.steps) * kind.exact_cost_ns;
  }
  return cost_ns / static_cast<double>(now_.kinds[0].steps + now_.kinds[1].steps);
}

void FidelityStepper::decide() {
  now_.until_decision = kDecideEvery;
  const double exact_ns = exact_cost_of_kinds();
  const auto steps = static_cast<double>(now_.steps);
  // As long again as so far, and one second at least.
  const double ahead = std::max(steps, 1e9 / static_cast<double>(step_ns_));
  std::size_t best = kExact;
  double best_ns = kLeastSaving * exact_ns;
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    const double cost_ns = cost_of(i) + exact_ns / static_cast<double>(kSampleOneIn);
    if (cost_ns >= best_ns) continue;
    Defect ahead_of_us{0.0, 0.0, 0.0, torque_per_norm_};
    bool known = true;
    for (const Kind& kind : now_.kinds) {
      // Of what is rare nothing may be known yet; the budget sees to it.
      known = known && kind.added[i].samples >= std::min(kind.steps, kFewestSamples);
      const double share = static_cast<double>(kind.steps) / steps;
      const Defect added = larger(kind.added[i].mean, kind.added[i].recent);
      ahead_of_us.energy_norm += share * added.energy_norm;
      ahead_of_us.angle_rad += share * added.angle_rad;
    }
    if (!known) continue;
    if (account_->estimate_with(ahead_of_us, ahead) > kSpendable * account_->tolerance()) continue;
    best = i;
    best_ns = cost_ns;
  }
  choose(best);
}

}  // namespace

std::unique_ptr<Stepper> make_fidelity_stepper(const PlantModel& model,
                                               const Integration& integration,
                                               const std::shared_ptr<FidelityAccount>& account) {
  return std::make_unique<FidelityStepper>(model, integration, account);
}

}  // namespace torsio::emulator
