// Takes each step with the cheapest method that keeps a tolerance.
//
// Cheap steps are taken only where the flow brings motions together: while a hand holds the knob
// firmly enough, or leads it. A knob that nothing holds turns a small error of speed into an error
// of angle without end, and no estimate made in time could keep that within a tolerance.
//
// A cheap method covers only what is smooth. Where friction catches or lets go, a spring meets its
// knee, the command or the hand's path jumps, or the motion is rougher than any that was checked,
// the step is exact: these few steps would add most of the error, each a different one, so that no
// sample could speak for the others.
//
// What the smooth steps add is measured by a twin, a second motion under the same inputs. In a
// trial the plant goes exactly and twins try the choices, so that their true error is seen, for a
// while. Once a choice is in use the plant takes its steps and so does the twin, except that one in
// 8 of the twin's is exact. What the two differ by is what those steps would have added, with
// everything that cancels or dies away; 8 times that, and as much again, is the estimate. Which
// steps they are follows the golden ratio, which keeps time with nothing that repeats. (Step
// doubling would not do: it presumes an order of convergence. Nor would a sum of what single steps
// add: it forgets nothing, and comes out a hundred times too large for a held knob.)
//
// The tolerance is a budget. A choice is given up when it has used three tenths of what is left of
// it, as an estimate may be low; its error is carried on, and exact steps follow until another
// trial, each after twice the time.
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
#include "emulator/plant_difference.hpp"
#include "emulator/plant_stepper.hpp"

namespace torsio::emulator {
namespace {

using Error = FidelityAccount::Error;

constexpr std::size_t kMostChoices = 4;   // besides exact steps
constexpr std::int64_t kSampleOneIn = 8;  // of the twin's steps
constexpr std::int64_t kFirstTrial = 64;  // exact steps before it
constexpr std::int64_t kTrialSteps = 64;
constexpr std::int64_t kTrialPause = 128;   // exact steps before the second trial
constexpr std::int64_t kWatched = 64;       // of these, the last ones; the others are just taken
constexpr std::int64_t kHalvesOneIn = 256;  // exact steps that are checked with halves, ...
constexpr double kRoundingMatters = 1e-6;   // ... for tolerances below this
constexpr double kSpendable = 0.3;          // of what is left of the tolerance
constexpr double kTrialShare = 0.25;        // of that, in a trial
constexpr double kLeastSaving = 0.15;       // of the exact cost, or a choice is not worth it
constexpr double kJump = 1.0 / 16.0;        // of the peak torque
constexpr std::int64_t kSettling = 4;       // steps after a jump
constexpr double kRougher = 2.0;            // than anything in the trial: not smooth
constexpr double kStepShare = 1.0 / 16.0;   // of what may be spent, in one step
constexpr double kMargin = 2.0;             // on what the samples stand for
constexpr double kForget = 1.0 / 128.0;     // weight of the newest in a recent mean
// Nominal, like the costs of steps: what a step in use takes besides the steps of plant and twin.
constexpr double kCareNs = 100.0;

class FidelityStepper final : public Stepper {
 public:
  FidelityStepper(const PlantModel& model, const Integration& integration,
                  std::shared_ptr<FidelityAccount> account);

  void step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) override;

 private:
  enum class Mode : std::uint8_t { exact, trial, cheap };

  /// How much the speeds change in a step, and how much that change does, as sqrt(energy).
  struct Roughness {
    double change = 0.0;
    double bend = 0.0;
  };

  /// Everything that changes from step to step, so that a step can be taken back.
  struct Memory {
    Mode mode = Mode::exact;
    std::size_t chosen = 0;
    std::int64_t steps = 0;
    std::int64_t next_change = kFirstTrial;  // value of `steps`
    std::int64_t pause = kTrialPause;
    std::int64_t restarts = 0;
    // Inputs of the last step:
    double motor_nm = 0.0;
    double brake_nm = 0.0;
    double loudest_nm = 0.0;  // motor command so far
    // Recent means:
    double events = 0.0;  // share of the steps that must be exact
    double event_cost_ns = 0.0;
    double smooth_cost_ns = 0.0;
    std::int64_t settled = 0;              // value of `steps`
    std::array<double, 3> change_rad_s{};  // of the speeds, in the last step
    // Of the trial's smooth steps; one for what rests and what moves, none for what was not seen:
    std::array<Roughness, 4> roughest{};
    std::int64_t chosen_at = 0;  // value of `steps`
    // In a trial one twin for each choice, otherwise the first one only:
    std::array<PlantState, kMostChoices> twins;
    std::array<Error, kMostChoices> worst{};
    std::array<bool, kMostChoices> fails{};
  };

  /// @returns the nominal cost
  double take_exact(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns);
  double take_cheap(std::size_t choice, PlantState& state, const HeldInputs& inputs,
                    std::int64_t duration_ns);
  [[nodiscard]] double cost_of(std::size_t choice) const {
    return choices_[choice].substeps * theta_step_cost_ns(model_);
  }
  /// Whether inputs jump at the begin of the step, or did so just before.
  [[nodiscard]] bool jumps(const PlantState& state, const HeldInputs& inputs);
  [[nodiscard]] std::size_t moving(const PlantState& state) const {
    const auto last = static_cast<std::size_t>(model_.last_shaft());
    return (state.speed_rad_s[0] != 0.0 ? 1U : 0U) + (state.speed_rad_s[last] != 0.0 ? 2U : 0U);
  }
  [[nodiscard]] Roughness roughness(const PlantState& before, const PlantState& after) const;
  void keep_in_step(PlantState& twin, const PlantState& state) const;
  /// A twin's way through a step that the plant takes exactly: their difference goes the choice's
  /// way, and nothing is added to it.
  void follow(std::size_t choice, PlantState& twin, const PlantState& before,
              const PlantState& after, const HeldInputs& inputs, std::int64_t duration_ns);

  /// Nothing is to be decided or learnt in the next step.
  [[nodiscard]] bool dozes() const;
  [[nodiscard]] bool must_check_rounding() const {
    return account_->tolerance() < kRoundingMatters &&
           now_.steps % kHalvesOneIn == kHalvesOneIn - 1;
  }
  void step_exactly(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns);
  void step_cheaply(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns);
  void learn(bool event, double exact_cost_ns);
  [[nodiscard]] bool pays(std::size_t choice, double least_saving) const;
  [[nodiscard]] double spendable() const;
  void begin_trial(const PlantState& state);
  void wait();
  void try_choices(const PlantState& before, const PlantState& after, const HeldInputs& inputs,
                   std::int64_t duration_ns, bool event);
  void end_trial(const PlantState& state);
  void give_up();
  void check_rounding(const PlantState& before, const PlantState& after, const HeldInputs& inputs,
                      std::int64_t duration_ns);

  PlantModel model_;
  std::shared_ptr<FidelityAccount> account_;
  std::int64_t step_ns_;
  std::unique_ptr<Stepper> exact_;
  std::unique_ptr<Stepper> halves_;      // exact steps of half the length, to check the exact ones
  std::vector<FidelityChoice> choices_;  // the cheap ones
  std::vector<std::unique_ptr<Stepper>> cheap_;
  bool free_;  // nothing brings the knob's angle back

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
      halves_(make_exact_stepper(model, std::max<std::int64_t>(1, integration.step_ns / 2))),
      free_(nothing_brings_back(model)) {
  for (const FidelityChoice& choice : fidelity_choices()) {
    if (free_) break;
    if (choice.method == Method::exact || choice.substeps > step_ns_) continue;
    if (choices_.size() == kMostChoices) break;
    choices_.push_back(choice);
    cheap_.push_back(make_theta_stepper(model, choice.method == Method::trapezoid ? 0.5 : 1.0));
  }
  // Another stepper may have been at work, for another hand.
  now_.restarts = account_->counts.restarts;
  account_->carry(account_->pending);
  account_->pending = {};
  account_->counts.choice = {Method::exact, 1};
}

double FidelityStepper::take_exact(PlantState& state, const HeldInputs& inputs,
                                   std::int64_t duration_ns) {
  const double before_ns = exact_->nominal_cost_ns();
  exact_->step(state, inputs, duration_ns);
  const double cost_ns = exact_->nominal_cost_ns() - before_ns;
  account_->counts.cost_ns += cost_ns;
  return cost_ns;
}

double FidelityStepper::take_cheap(std::size_t choice, PlantState& state, const HeldInputs& inputs,
                                   std::int64_t duration_ns) {
  const std::int64_t substeps = std::min<std::int64_t>(choices_[choice].substeps, duration_ns);
  const std::int64_t begin_ns = state.time_ns;
  for (std::int64_t i = 1; i <= substeps; ++i) {
    const std::int64_t end_ns = begin_ns + duration_ns * i / substeps;
    cheap_[choice]->step(state, inputs, end_ns - state.time_ns);
  }
  account_->counts.cost_ns += cost_of(choice);
  return cost_of(choice);
}

bool FidelityStepper::jumps(const PlantState& state, const HeldInputs& inputs) {
  const double jump_nm = std::abs(inputs.motor_command_nm - now_.motor_nm) +
                         std::abs(state.brake_target_nm - now_.brake_nm);
  if (inputs.hand.begin_ns == state.time_ns ||
      jump_nm > kJump * std::max(account_->peak_nm(), now_.loudest_nm)) {
    now_.settled = now_.steps + kSettling;
  }
  return now_.steps < now_.settled;
}

FidelityStepper::Roughness FidelityStepper::roughness(const PlantState& before,
                                                      const PlantState& after) const {
  double change_square = 0.0;
  double bend_square = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model_.shafts); ++i) {
    const double change = after.speed_rad_s[i] - before.speed_rad_s[i];
    const double bend = change - now_.change_rad_s[i];
    change_square += model_.inertia_kg_m2[i] * change * change;
    bend_square += model_.inertia_kg_m2[i] * bend * bend;
  }
  return {std::sqrt(change_square), std::sqrt(bend_square)};
}

void FidelityStepper::keep_in_step(PlantState& twin, const PlantState& state) const {
  twin.brake_target_nm = state.brake_target_nm;
  if (!model_.knob_is_driven()) return;
  twin.knob_angle = state.knob_angle;
  for (std::size_t i = 0; i < 3; ++i) {
    if (i == 0 || model_.shafts == 1) twin.speed_rad_s[i] = state.speed_rad_s[i];
  }
}

void FidelityStepper::follow(std::size_t choice, PlantState& twin, const PlantState& before,
                             const PlantState& after, const HeldInputs& inputs,
                             std::int64_t duration_ns) {
  PlantState from = before;
  take_cheap(choice, from, inputs, duration_ns);
  take_cheap(choice, twin, inputs, duration_ns);
  const PlantState to = twin;
  twin = after;
  twin.knob_angle.add(angle_between(to.knob_angle, from.knob_angle));
  for (std::size_t i = 0; i < 3; ++i) {
    // What friction holds is held in both.
    if (after.speed_rad_s[i] != 0.0) twin.speed_rad_s[i] += to.speed_rad_s[i] - from.speed_rad_s[i];
  }
  for (std::size_t i = 0; i < 2; ++i) twin.twist_rad[i] += to.twist_rad[i] - from.twist_rad[i];
}

void FidelityStepper::learn(bool event, double exact_cost_ns) {
  double& mean_ns = event ? now_.event_cost_ns : now_.smooth_cost_ns;
  mean_ns = mean_ns == 0.0 ? exact_cost_ns : mean_ns + kForget * (exact_cost_ns - mean_ns);
}

bool FidelityStepper::pays(std::size_t choice, double least_saving) const {
  const double exact_ns =
      now_.events * now_.event_cost_ns + (1.0 - now_.events) * now_.smooth_cost_ns;
  const double sampled_ns = now_.smooth_cost_ns / static_cast<double>(kSampleOneIn);
  const double in_use_ns = kCareNs + now_.events * (now_.event_cost_ns + cost_of(choice)) +
                           (1.0 - now_.events) * (2.0 * cost_of(choice) + sampled_ns);
  return in_use_ns < (1.0 - least_saving) * exact_ns;
}

double FidelityStepper::spendable() const {
  const double carried = account_->carried();
  return carried + kSpendable * (account_->tolerance() - carried);
}

void FidelityStepper::step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) {
  if (state.time_ns == begin_ns_) {
    now_ = before_;
    *account_ = account_before_;
  }
  begin_ns_ = -1;
  if (now_.restarts != account_->counts.restarts) {
    now_ = {};
    now_.restarts = account_->counts.restarts;
    account_->counts.choice = {Method::exact, 1};
  }
  if (duration_ns < step_ns_) {
    begin_ns_ = state.time_ns;
    before_ = now_;
    account_before_ = *account_;
  }

  now_.loudest_nm = std::max(now_.loudest_nm, std::abs(inputs.motor_command_nm));
  if (dozes()) {
    account_->counts.exact_cost_ns += take_exact(state, inputs, duration_ns);
    ++account_->counts.by_method[static_cast<std::size_t>(Method::exact)];
  } else {
    const std::array<double, 3> begin_rad_s = state.speed_rad_s;
    if (now_.mode == Mode::cheap) {
      step_cheaply(state, inputs, duration_ns);
    } else {
      step_exactly(state, inputs, duration_ns);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      now_.change_rad_s[i] = state.speed_rad_s[i] - begin_rad_s[i];
    }
    now_.motor_nm = inputs.motor_command_nm;
    now_.brake_nm = state.brake_target_nm;
  }
  ++now_.steps;
  account_->see(state.knob_angle_rad(),
                model_.has_spring() ? spring_torque_nm(model_, state.twist_rad[0]) : 0.0);
  const double duration_s = 1e-9 * static_cast<double>(duration_ns);
  if (!free_ || state.speed_rad_s[0] == 0.0) {
    account_->rest();
  } else {
    account_->drift(duration_s);
  }
}

bool FidelityStepper::dozes() const {
  if (now_.mode != Mode::exact || must_check_rounding()) return false;
  return choices_.empty() || now_.steps + kWatched < now_.next_change;
}

void FidelityStepper::step_exactly(PlantState& state, const HeldInputs& inputs,
                                   std::int64_t duration_ns) {
  FidelityAccount::Counts& counts = account_->counts;
  const PlantState before = state;
  const bool jump = jumps(state, inputs);
  const double cost_ns = take_exact(state, inputs, duration_ns);
  counts.exact_cost_ns += cost_ns;
  ++counts.by_method[static_cast<std::size_t>(Method::exact)];
  const bool event = jump || kinks(model_, before, state);
  now_.events += kForget * ((event ? 1.0 : 0.0) - now_.events);
  learn(event, cost_ns);
  if (must_check_rounding()) check_rounding(before, state, inputs, duration_ns);
  if (now_.mode == Mode::trial) try_choices(before, state, inputs, duration_ns, event);
  if (now_.steps < now_.next_change) return;
  if (now_.mode == Mode::trial) {
    end_trial(state);
  } else {
    begin_trial(state);
  }
}

void FidelityStepper::begin_trial(const PlantState& state) {
  bool any = false;
  now_.roughest = {};
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    now_.fails[i] = !pays(i, kLeastSaving);
    now_.twins[i] = state;
    now_.worst[i] = {};
    any = any || !now_.fails[i];
  }
  if (any) {
    now_.mode = Mode::trial;
    now_.next_change = now_.steps + kTrialSteps;
  } else {
    wait();
  }
}

void FidelityStepper::wait() {
  now_.next_change = now_.steps + now_.pause;
  now_.pause *= 2;
}

void FidelityStepper::try_choices(const PlantState& before, const PlantState& after,
                                  const HeldInputs& inputs, std::int64_t duration_ns, bool event) {
  ++account_->counts.checked;
  account_->counts.cost_ns += kCareNs;
  if (!event) {
    const Roughness rough = roughness(before, after);
    Roughness& known = now_.roughest[moving(before)];
    known = {std::max(known.change, rough.change), std::max(known.bend, rough.bend)};
  }
  const double allowed = account_->carried() + kTrialShare * (spendable() - account_->carried());
  bool any = false;
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    if (now_.fails[i]) continue;
    PlantState& twin = now_.twins[i];
    keep_in_step(twin, before);
    if (event) {
      follow(i, twin, before, after, inputs, duration_ns);
    } else {
      const PlantState begin = twin;
      take_cheap(i, twin, inputs, duration_ns);
      if (kinks(model_, begin, twin)) {
        twin = begin;
        take_exact(twin, inputs, duration_ns);
      }
    }
    now_.worst[i] = larger(now_.worst[i], between(model_, twin, after));
    now_.fails[i] = account_->carried_with(now_.worst[i]) > allowed;
    any = any || !now_.fails[i];
  }
  if (!any) now_.next_change = now_.steps;
}

void FidelityStepper::end_trial(const PlantState& state) {
  now_.mode = Mode::exact;
  double least_ns = 0.0;
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    if (now_.fails[i] || !pays(i, kLeastSaving)) continue;
    const double cost_ns = cost_of(i);
    const bool better =
        now_.mode == Mode::exact || cost_ns < least_ns ||
        (cost_ns == least_ns &&
         account_->carried_with(now_.worst[i]) < account_->carried_with(now_.worst[now_.chosen]));
    if (!better) continue;
    now_.mode = Mode::cheap;
    now_.chosen = i;
    least_ns = cost_ns;
  }
  if (now_.mode == Mode::cheap) {
    account_->counts.choice = choices_[now_.chosen];
    now_.chosen_at = now_.steps;
    now_.twins[0] = state;
    now_.worst[0] = now_.worst[now_.chosen];
    return;
  }
  wait();
}

void FidelityStepper::step_cheaply(PlantState& state, const HeldInputs& inputs,
                                   std::int64_t duration_ns) {
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15;
  FidelityAccount::Counts& counts = account_->counts;
  counts.cost_ns += kCareNs;
  const PlantState before = state;
  PlantState& twin = now_.twins[0];
  keep_in_step(twin, state);
  PlantState exact;
  double exact_cost_ns = 0.0;  // 0: not taken yet
  bool event = jumps(state, inputs);
  if (!event) {
    take_cheap(now_.chosen, state, inputs, duration_ns);
    event = kinks(model_, before, state);
    const Roughness rough = roughness(before, state);
    Roughness& known = now_.roughest[moving(before)];
    if (!event && (rough.change > kRougher * known.change || rough.bend > kRougher * known.bend)) {
      // Nothing like it has been checked, so it is now; the next one like it need not be.
      event = true;
      exact = before;
      exact_cost_ns = take_exact(exact, inputs, duration_ns);
      if (account_->carried_with(bound_between(model_, state, exact)) <
          account_->carried() + kStepShare * (spendable() - account_->carried())) {
        known = {std::max(known.change, rough.change), std::max(known.bend, rough.bend)};
      }
    }
  }
  now_.events += kForget * ((event ? 1.0 : 0.0) - now_.events);
  if (event) {
    if (exact_cost_ns == 0.0) {
      exact = before;
      exact_cost_ns = take_exact(exact, inputs, duration_ns);
    }
    state = exact;
    counts.exact_cost_ns += exact_cost_ns;
    ++counts.by_method[static_cast<std::size_t>(Method::exact)];
    learn(true, exact_cost_ns);
    follow(now_.chosen, twin, before, state, inputs, duration_ns);
  } else {
    counts.exact_cost_ns += now_.smooth_cost_ns;
    ++counts.by_method[static_cast<std::size_t>(choices_[now_.chosen].method)];
    const std::uint64_t dice = static_cast<std::uint64_t>(now_.steps) * kGolden;
    if (dice < UINT64_MAX / kSampleOneIn) {
      ++counts.checked;
      learn(false, take_exact(twin, inputs, duration_ns));
    } else {
      const PlantState begin = twin;
      take_cheap(now_.chosen, twin, inputs, duration_ns);
      if (kinks(model_, begin, twin)) {
        twin = begin;
        take_exact(twin, inputs, duration_ns);
      }
    }
  }

  // As much as the samples stand for, and no less than was seen in the trial.
  now_.worst[0] = larger(now_.worst[0], scaled(between(model_, state, twin),
                                               kMargin * static_cast<double>(kSampleOneIn)));
  account_->pending = now_.worst[0];
  account_->meet(now_.worst[0]);
  if (account_->carried_with(now_.worst[0]) > spendable() || !pays(now_.chosen, 0.0)) give_up();
}

void FidelityStepper::give_up() {
  account_->carry(now_.worst[0]);
  account_->pending = {};
  account_->counts.choice = {Method::exact, 1};
  now_.mode = Mode::exact;
  const bool short_lived = now_.steps - now_.chosen_at < now_.pause;
  now_.next_change = now_.steps + (short_lived ? now_.pause : 0);
  if (short_lived) now_.pause *= 2;
}

void FidelityStepper::check_rounding(const PlantState& before, const PlantState& after,
                                     const HeldInputs& inputs, std::int64_t duration_ns) {
  // Two exact steps of half the length go other ways through the stepper; what they differ by is
  // what rounding does.
  ++account_->counts.checked;
  PlantState halves = before;
  const double before_ns = halves_->nominal_cost_ns();
  halves_->step(halves, inputs, duration_ns - duration_ns / 2);
  if (duration_ns > 1) halves_->step(halves, inputs, duration_ns / 2);
  account_->counts.cost_ns += halves_->nominal_cost_ns() - before_ns;
  account_->carry(scaled(between(model_, halves, after), static_cast<double>(kHalvesOneIn)));
  const auto& taken = account_->counts.by_method;
  const bool always_exact = taken[static_cast<std::size_t>(Method::trapezoid)] == 0 &&
                            taken[static_cast<std::size_t>(Method::semi_implicit)] == 0;
  if (!always_exact || account_->estimate() <= account_->tolerance()) return;
  std::ostringstream text;
  text << "plant: nothing keeps the tolerance " << account_->tolerance()
       << " in this scene: rounding alone adds up to " << account_->estimate() << " after "
       << 1e-9 * static_cast<double>(after.time_ns) << " s";
  throw std::runtime_error(text.str());
}

}  // namespace

std::unique_ptr<Stepper> make_fidelity_stepper(const PlantModel& model,
                                               const Integration& integration,
                                               const std::shared_ptr<FidelityAccount>& account) {
  return std::make_unique<FidelityStepper>(model, integration, account);
}

}  // namespace torsio::emulator
