// The exact stepper. Between events the plant is linear, z' = M z, and exp(M t) takes it any
// distance in one step. At an event friction lets go or catches, the shaft spring passes its knee,
// or the cogging begins its next straight piece.
//
// Each regime has a ladder of step lengths h, h/2, h/4, ... with their exponentials. A step first
// tries the longest rung. It is taken if a bound proves that no event lies within. Otherwise the
// way is cut into cells as long as the last rung, and whole rungs lead up to the cell where the
// event appears to lie. Within a cell the solution is its Taylor series. The first root of each
// watched quantity is isolated and refined on that polynomial. A second series leads from the event
// to the end of the cell, where rungs fit again.

#include "emulator/plant/exact/stepper.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "emulator/plant/exact/chain.hpp"
#include "emulator/plant/exact/ladder.hpp"
#include "emulator/plant/exact/switched_plant.hpp"
#include "emulator/plant/exact/taylor.hpp"

namespace torsio::emulator {
namespace {

/// @tparam kPlain no prescribed path, and nothing that is linear in pieces only
template <int kShafts, bool kPlain = false>
class ExactStepper final : public Stepper {
 public:
  ExactStepper(PlantModel model, std::int64_t step_ns);

  void step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) override;

 private:
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;

  struct Outcome {
    double elapsed_s;
    Event event;
  };

  void load(Vector& z, const PlantState& state, const HeldInputs& inputs);
  void store(const Vector& z, PlantState& state, const HeldInputs& inputs,
             std::int64_t duration_ns) const;

  /// The ladder of the present regime, made when it is met for the first time.
  [[nodiscard]] std::span<Rung<kShafts>> ladder();

  /// Takes the first of `rungs` if that certainly holds no event; if it does not, reach_ tells how
  /// much of it is worth another try.
  [[nodiscard]] bool climb(std::span<Rung<kShafts>> rungs, Vector& z);
  [[nodiscard]] bool climb_cells(std::span<Rung<kShafts>> rungs);
  template <Moving kMoving>
  [[nodiscard]] bool climb_with(const Rung<kShafts>& rung, Vector& z);
  /// Goes on for `duration_ns` after the longest rung could not be taken.
  void go_in_cells(std::int64_t duration_ns);
  /// Takes the longest rung within `limit` cells that certainly holds no event. @returns which;
  /// rungs_: none. `reach` becomes the cells up to the next event if there are signs of one.
  [[nodiscard]] std::size_t climb_within(double limit, double& reach);
  [[nodiscard]] std::int64_t cells_of(std::size_t rung) const {
    return std::int64_t{1} << (rungs_ - 1 - rung);
  }

  /// Goes along Taylor series for `rest_s`, from event to event.
  void creep_through(double rest_s);
  /// Goes along the Taylor series for `step_s`, or up to the first event.
  [[nodiscard]] Outcome creep(double step_s);

  SwitchedPlant<kShafts, kPlain> plant_;
  std::size_t rungs_;
  std::int64_t step_ns_;
  std::int64_t cells_;                  // of a whole step
  std::int64_t longest_ns_;             // the whole step if the first rung is as long, otherwise 0
  double cell_s_;                       // the length of the last rung
  std::vector<Rung<kShafts>> ladders_;  // of all regimes, one after the other

  // State of the present step:
  Vector z_{};
  // State of the last rung tried:
  double reach_ = 1.0;     // the share of it that is free of events
  bool crossing_ = false;  // its end is beyond an event
  int stalled_ = 0;        // events in a row without any time between them
};

template <int kShafts, bool kPlain>
ExactStepper<kShafts, kPlain>::ExactStepper(PlantModel model, std::int64_t step_ns)
    : plant_(std::move(model)), step_ns_(step_ns) {
  const Cells whole = cells_of_step(plant_.chain, step_ns);
  rungs_ = whole.rungs;
  cells_ = whole.count;
  cell_s_ = whole.length_s;
  longest_ns_ = cells_ == cells_of(0) ? step_ns : 0;
  ladders_.resize(plant_.regimes() * (rungs_ + kFiner));
}

template <int kShafts, bool kPlain>
[[gnu::always_inline]] inline std::span<Rung<kShafts>> ExactStepper<kShafts, kPlain>::ladder() {
  const std::size_t length = rungs_ + kFiner;
  const std::span rungs{&ladders_[plant_.regime_index() * length], length};
  if (rungs[0].step_s == 0.0) [[unlikely]] {
    build_ladder<kShafts>(plant_.chain, plant_.regime, cell_s_ / kSamples, rungs);
  }
  return rungs;
}

template <int kShafts, bool kPlain>
[[gnu::always_inline]] inline void ExactStepper<kShafts, kPlain>::load(Vector& z,
                                                                       const PlantState& state,
                                                                       const HeldInputs& inputs) {
  stalled_ = 0;
  if (plant_.pieces() && !plant_.model.cogging_nm.empty()) {
    plant_.regime.cogging = cogging_at(plant_.model, state.knob_angle);
    plant_.travel_low = plant_.regime.cogging.begin_rad;
    plant_.travel_high = plant_.regime.cogging.end_rad;
  }
  const HandForce hand = hand_force(plant_.model, state, inputs);
  z[C::kForce] = inputs.motor_command_nm + hand.force_nm +
                 (plant_.pieces() ? plant_.regime.cogging.torque_nm : 0.0);
  z[C::kSlope] = hand.slope_nm_per_s;
  z[C::kCoulomb] = plant_.model.knob_coulomb_nm;
  z[C::kTravel] = 0.0;
  z[C::kMotorGap] =
      plant_.chain.motor_rate > 0.0 ? state.motor_torque_nm - inputs.motor_command_nm : 0.0;
  unrolled<kShafts>([&](auto i) { z[C::kSpeed + i] = state.speed_rad_s[i]; });
  if constexpr (kShafts > 1) {
    unrolled<C::kSprings>([&](auto i) { z[C::kTwist + i] = state.twist_rad[i]; });
    if (plant_.pieces()) {
      plant_.regime.spring_piece = spring_piece_at(plant_.model, state.twist_rad[0]);
      z[C::kTwist] -= plant_.spring_piece().rest_rad;
    }
    z[C::kCapacity] = state.brake_target_nm + plant_.model.brake_drag_nm;
    z[C::kBrakeGap] =
        plant_.chain.brake_rate > 0.0 ? state.brake_magnetic_nm - state.brake_target_nm : 0.0;
    const double speed = z[C::kLast];
    plant_.regime.brake = speed == 0.0 ? plant_.brake_at_rest(z) : direction_of(speed);
  }
  if (!plant_.driven()) {
    const double speed = z[C::kSpeed];
    plant_.regime.knob = speed == 0.0 ? plant_.knob_at_rest(z) : direction_of(speed);
  }
}

template <int kShafts, bool kPlain>
[[gnu::always_inline]] inline void ExactStepper<kShafts, kPlain>::store(
    const Vector& z, PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) const {
  state.time_ns += duration_ns;
  state.knob_angle.add(z[C::kTravel]);
  state.motor_torque_nm = inputs.motor_command_nm + settled(z[C::kMotorGap]);
  unrolled<3>(
      [&](auto i) { state.speed_rad_s[i] = z[C::kSpeed + std::min<std::size_t>(i, kShafts - 1)]; });
  if constexpr (kShafts > 1) {
    unrolled<C::kSprings>([&](auto i) { state.twist_rad[i] = z[C::kTwist + i]; });
    if (plant_.pieces()) state.twist_rad[0] += plant_.spring_piece().rest_rad;
    state.brake_magnetic_nm = state.brake_target_nm + settled(z[C::kBrakeGap]);
  }
}

template <int kShafts, bool kPlain>
[[gnu::always_inline]] inline bool ExactStepper<kShafts, kPlain>::climb(
    std::span<Rung<kShafts>> rungs, Vector& z) {
  if (!rungs[0].bends_known) [[unlikely]]
    find_bends<kShafts>(plant_.chain, plant_.regime, rungs);
  if constexpr (kShafts == 2) {
    const bool knob = plant_.regime.knob != Slip::held || plant_.driven();
    if (plant_.regime.brake == Slip::held) {
      return knob ? climb_with<Moving{true, false}>(rungs[0], z)
                  : climb_with<Moving{false, false}>(rungs[0], z);
    }
    if (!knob) return climb_with<Moving{false, true}>(rungs[0], z);
  }
  return climb_with<kAllMove>(rungs[0], z);
}

// Nearly all of the emulator's time is spent here.
template <int kShafts, bool kPlain>
template <Moving kMoving>
[[gnu::always_inline]] inline bool ExactStepper<kShafts, kPlain>::climb_with(
    const Rung<kShafts>& rung, Vector& z) {
  const auto drive = plant_.chain.drives(z, plant_.regime);
  const Vector next = advanced<kShafts, kMoving>(plant_.chain, plant_.regime, rung, z, drive);
  bool certain = true;
  reach_ = 1.0;
  crossing_ = false;
  // Between its ends a curve is nowhere lower than the lower end less the bend.
  const auto look = [&](double begin, double end, double bend) {
    if (std::min(begin, end) >= bend) return;
    certain = false;
    double reach = 0.5;
    if (end < 0.0) {
      crossing_ = true;
      reach = begin / (begin - end);
    } else if (begin < bend) {
      reach = std::sqrt(std::max(0.0, begin / bend));  // bends grow with the square of the step
    }
    reach_ = std::min(reach_, reach);
  };
  using Column = typename Rung<kShafts>::Column;
  const Pair friction_bends = bends_of<kShafts, kMoving>(&Column::friction_bend, rung, drive);
  if (!plant_.driven()) look(plant_.knob_room(z), plant_.knob_room(next), friction_bends[kKnob]);
  if constexpr (kShafts > 1)
    look(plant_.brake_room(z), plant_.brake_room(next), friction_bends[kBrake]);
  if (plant_.pieces()) {
    const Pair bends = bends_of<kShafts, kMoving>(&Column::piece_bend, rung, drive);
    if constexpr (kShafts > 1) {
      const SpringPiece& piece = plant_.spring_piece();
      const double begin = z[C::kTwist] + piece.rest_rad;
      const double end = next[C::kTwist] + piece.rest_rad;
      look(begin - piece.begin_rad, end - piece.begin_rad, bends[kTwisted]);
      look(piece.end_rad - begin, piece.end_rad - end, bends[kTwisted]);
    }
    const double bend = bends[kTravelled];
    look(z[C::kTravel] - plant_.travel_low, next[C::kTravel] - plant_.travel_low, bend);
    look(plant_.travel_high - z[C::kTravel], plant_.travel_high - next[C::kTravel], bend);
  }
  if (!certain) return false;
  unrolled<C::kVarying>([&](auto i) { z[i] = next[i]; });
  return true;
}

template <int kShafts, bool kPlain>
typename ExactStepper<kShafts, kPlain>::Outcome ExactStepper<kShafts, kPlain>::creep(
    double step_s) {
  constexpr int kMostStalled = 16;
  if (stalled_ == kMostStalled) {
    // Rounding makes laws contradict each other here: each sends the shaft to the other one. The
    // contradiction is gone a moment later.
    stalled_ = 0;
    const double moment_s = 1e-6 * step_s;
    z_ = value_at<kShafts>(taylor_series(plant_.chain, z_, plant_.regime, moment_s), 1.0);
    return {moment_s, Event::none};
  }

  const auto series = taylor_series(plant_.chain, z_, plant_.regime, step_s);
  EventSearch<kShafts> search(plant_.chain, plant_.regime, series);
  search.look_at_friction(plant_.driven(), step_s);
  if (plant_.pieces()) search.look_at_pieces(plant_.travel_low, plant_.travel_high);
  z_ = value_at<kShafts>(series, search.until());
  const double share = search.event() == Event::none ? 1.0 : search.until();
  return {share * step_s, search.event()};
}

template <int kShafts, bool kPlain>
void ExactStepper<kShafts, kPlain>::creep_through(double rest_s) {
  while (rest_s > 0.0) {
    const Outcome outcome = creep(rest_s);
    rest_s -= outcome.elapsed_s;
    if (outcome.event == Event::none) continue;
    stalled_ = outcome.elapsed_s > 1e-6 * cell_s_ ? 0 : stalled_ + 1;
    plant_.take(outcome.event, z_);
  }
}

// Apart, or the loop that calls it would take its registers.
template <int kShafts, bool kPlain>
[[gnu::noinline, gnu::flatten]] bool ExactStepper<kShafts, kPlain>::climb_cells(
    std::span<Rung<kShafts>> rungs) {
  return climb(rungs, z_);
}

template <int kShafts, bool kPlain>
std::size_t ExactStepper<kShafts, kPlain>::climb_within(double limit, double& reach) {
  const auto rungs = ladder();
  for (std::size_t rung = 0; rung < rungs_; ++rung) {
    const auto length = static_cast<double>(cells_of(rung));
    if (length > limit) continue;
    if (climb_cells(rungs.subspan(rung))) return rung;
    limit = reach_ * length;
    if (crossing_) reach = limit;
  }
  return rungs_;
}

template <int kShafts, bool kPlain>
[[gnu::noinline]] void ExactStepper<kShafts, kPlain>::go_in_cells(std::int64_t duration_ns) {
  constexpr double kAnywhere = std::numeric_limits<double>::infinity();
  // Whole cells, after what is left of the first one.
  std::int64_t cells = cells_;
  double reach = kAnywhere;  // cells up to the next event, if there are signs of one
  double limit = static_cast<double>(cells);  // cells that are worth a try
  if (duration_ns == longest_ns_) {
    limit *= reach_;
    if (crossing_) reach = limit;
  } else if (duration_ns != step_ns_) {
    const double duration_s = 1e-9 * static_cast<double>(duration_ns);
    constexpr double kRounding = 1e-12;
    cells = static_cast<std::int64_t>(duration_s / cell_s_ + kRounding);
    creep_through(std::max(0.0, duration_s - static_cast<double>(cells) * cell_s_));
    limit = kAnywhere;
  }
  while (cells > 0) {
    const std::size_t rung = climb_within(std::min(limit, static_cast<double>(cells)), reach);
    if (rung < rungs_) {
      cells -= cells_of(rung);
      reach -= static_cast<double>(cells_of(rung));
    } else {
      --cells;
      creep_through(cell_s_);
      reach = kAnywhere;
    }
    limit = reach;
  }
}

template <int kShafts, bool kPlain>
[[gnu::flatten]] void ExactStepper<kShafts, kPlain>::step(PlantState& state,
                                                          const HeldInputs& inputs,
                                                          std::int64_t duration_ns) {
  if (duration_ns != longest_ns_) {
    load(z_, state, inputs);
    go_in_cells(duration_ns);
    return store(z_, state, inputs, duration_ns);
  }
  Vector z{};
  load(z, state, inputs);
  if (!climb(ladder(), z)) [[unlikely]] {
    // A copy, so that elsewhere the state stays in registers; one by one, as a pair would wait for
    // what was just stored alone.
    unrolled<C::kSize>([&](auto i) { z_[i] = z[i]; });
    go_in_cells(duration_ns);
    unrolled<C::kSize>([&](auto i) { z[i] = z_[i]; });
  }
  store(z, state, inputs, duration_ns);
}

}  // namespace

std::unique_ptr<Stepper> make_exact_stepper(PlantModel model, std::int64_t step_ns) {
  switch (model.shafts) {
    case 1:
      return std::make_unique<ExactStepper<1>>(std::move(model), step_ns);
    case 2:
      if (model.shaft_spring.size() == 1 && model.cogging_nm.empty() && !model.knob_is_driven()) {
        return std::make_unique<ExactStepper<2, true>>(std::move(model), step_ns);
      }
      return std::make_unique<ExactStepper<2>>(std::move(model), step_ns);
    default:
      return std::make_unique<ExactStepper<3>>(std::move(model), step_ns);
  }
}

}  // namespace torsio::emulator
