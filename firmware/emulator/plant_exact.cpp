// The exact stepper. Between events the plant is linear, z' = M z, and exp(M t) takes it as far as
// one likes in one go; events are where friction lets go or catches, where the shaft spring passes
// its knee, and where the cogging goes on to its next straight piece.
//
// Each regime has a ladder of step lengths h, h/2, h/4, ... with their exponentials. A step first
// tries the longest rung. It is taken if a bound makes certain that no event lies within; otherwise
// the next shorter one is tried. Below the last rung the solution is its Taylor series, and the
// first root of each watched quantity is isolated and refined on that polynomial.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "emulator/first_crossing.hpp"
#include "emulator/plant_chain.hpp"
#include "emulator/plant_ladder.hpp"
#include "emulator/plant_stepper.hpp"

namespace torsio::emulator {
namespace {

constexpr double kEpsilon = 0x1p-52;

// Nominal cost of a step apart from what it does, of trying a rung, and of going along a Taylor
// series to an event, for 1, 2 and 3 shafts. Fitted to runs with few and with many events on one
// core of a server of 2023, where they predict the time of a run to 15 %.
constexpr std::array kStepCostNs{18.0, 26.0, 28.0};
constexpr std::array kRungCostNs{9.0, 22.0, 35.0};
constexpr std::array kCreepCostNs{250.0, 370.0, 500.0};
constexpr double kCoggingCostNs = 50.0;  // a step with the part

enum class Event { none, knob, brake, twist_low, twist_high, travel_low, travel_high };

template <int kShafts>
class ExactStepper final : public Stepper {
 public:
  ExactStepper(PlantModel model, std::int64_t step_ns);

  void step(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) override;

 private:
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;
  static constexpr std::size_t kFrictions = kShafts > 1 ? 2 : 1;

  struct Outcome {
    double elapsed_s;
    Event event;
  };

  void load(const PlantState& state, const HeldInputs& inputs);
  void store(PlantState& state, const HeldInputs& inputs, std::int64_t duration_ns) const;

  /// The ladder of the present regime, made when it is met for the first time.
  [[nodiscard]] std::span<Rung<kShafts>> ladder();

  /// What is left until friction lets go or catches: of its torque, or of the speed.
  [[nodiscard]] double knob_room(const Vector& z) const {
    if (regime_.knob != Slip::held) return sign_of(regime_.knob) * z[C::kSpeed];
    return z[C::kCoulomb] - std::abs(chain_.knob_demand(z, regime_));
  }
  [[nodiscard]] double brake_room(const Vector& z) const
    requires(kShafts > 1)
  {
    if (regime_.brake != Slip::held) return sign_of(regime_.brake) * z[C::kLast];
    return chain_.capacity(z) - std::abs(chain_.brake_demand(z, regime_));
  }
  [[nodiscard]] const SpringPiece& spring_piece() const {
    return model_.shaft_spring[static_cast<std::size_t>(regime_.spring_piece)];
  }

  /// Takes the first of `rungs` if that certainly holds no event; if it does not, reach_ tells what
  /// part of its step may lie before one.
  [[nodiscard]] bool climb(std::span<Rung<kShafts>> rungs);
  template <Moving kMoving>
  [[nodiscard]] bool climb_with(const Rung<kShafts>& rung);
  /// Certain that no piece of the spring or the cogging is left on the way to `next`?
  [[nodiscard]] bool stays_on_pieces(const Rung<kShafts>& rung, const Vector& next,
                                     const typename C::Drives& drive) const;

  /// Goes along the Taylor series for `step_s`, or up to the first event.
  [[nodiscard]] Outcome creep(double step_s);

  /// Changes the regime as the event has it.
  void take(Event event);
  [[nodiscard]] Slip knob_at_rest() const;
  [[nodiscard]] Slip brake_at_rest() const;

  PlantModel model_;
  Chain<kShafts> chain_;
  bool pieces_;  // something is linear in pieces only
  std::size_t rungs_ = 1;
  double finest_s_;
  std::vector<Rung<kShafts>> ladders_;  // of all regimes, one after the other

  // Of the step under way:
  Vector z_{};
  Regime regime_;
  // The ends of the cogging's piece:
  double travel_low_ = -std::numeric_limits<double>::infinity();
  double travel_high_ = std::numeric_limits<double>::infinity();
  double reach_ = 1.0;
  int stalled_ = 0;  // events in a row without any time between them
};

template <int kShafts>
ExactStepper<kShafts>::ExactStepper(PlantModel model, std::int64_t step_ns)
    : model_(std::move(model)),
      chain_(model_),
      pieces_(model_.shaft_spring.size() > 1 || !model_.cogging_nm.empty()),
      finest_s_(1e-9 * static_cast<double>(step_ns)) {
  // On the longest rung the sampled bounds must resolve every oscillation; on the last one the
  // Taylor series must reach double precision: 0.25^13 / 13! is 2e-18.
  constexpr double kResolved = 2.0;
  constexpr double kConverged = 0.25;
  constexpr int kMostHalvings = 40;
  const double oscillation = chain_.fastest_oscillation();
  const double fastest = oscillation + chain_.fastest_decay();
  int halvings = 0;
  while (finest_s_ * fastest > kConverged) {
    if (finest_s_ * oscillation <= kResolved) ++rungs_;
    finest_s_ *= 0.5;
    if (++halvings > kMostHalvings) {
      throw std::invalid_argument(
          "plant: its fastest motion is more than 1e11 times faster than integration.step_ns; "
          "shorten the step, or set a time constant that does not matter to 0");
    }
  }
  const std::size_t pieces = std::max<std::size_t>(1, model_.cogging_nm.size());
  const std::size_t regimes = pieces * std::max<std::size_t>(1, model_.shaft_spring.size()) * 9;
  ladders_.resize(regimes * (rungs_ + kFiner));
}

template <int kShafts>
std::span<Rung<kShafts>> ExactStepper<kShafts>::ladder() {
  const int springs = static_cast<int>(std::max<std::size_t>(1, model_.shaft_spring.size()));
  const int regime = ((regime_.cogging.index * springs + regime_.spring_piece) * 3 +
                      static_cast<int>(regime_.knob) + 1) *
                         3 +
                     static_cast<int>(regime_.brake) + 1;
  const std::size_t length = rungs_ + kFiner;
  const std::span rungs{&ladders_[static_cast<std::size_t>(regime) * length], length};
  if (rungs[0].step_s == 0.0) {
    build_ladder<kShafts>(chain_, regime_, finest_s_ / kSamples, rungs);
  }
  return rungs;
}

template <int kShafts>
void ExactStepper<kShafts>::load(const PlantState& state, const HeldInputs& inputs) {
  z_ = {};
  regime_ = {};
  stalled_ = 0;
  if (!model_.cogging_nm.empty()) {
    regime_.cogging = cogging_at(model_, state.knob_angle);
    travel_low_ = regime_.cogging.begin_rad;
    travel_high_ = regime_.cogging.end_rad;
  }
  const HandForce hand = hand_force(model_, state, inputs);
  z_[C::kForce] = inputs.motor_command_nm + hand.force_nm + regime_.cogging.torque_nm;
  z_[C::kSlope] = hand.slope_nm_per_s;
  z_[C::kCoulomb] = model_.knob_coulomb_nm;
  if (chain_.motor_rate > 0.0) {
    z_[C::kMotorGap] = state.motor_torque_nm - inputs.motor_command_nm;
  }
  for (std::size_t i = 0; i < kShafts; ++i) z_[C::kSpeed + i] = state.speed_rad_s[i];
  if constexpr (kShafts > 1) {
    regime_.spring_piece = spring_piece_at(model_, state.twist_rad[0]);
    for (std::size_t i = 0; i < C::kSprings; ++i) z_[C::kTwist + i] = state.twist_rad[i];
    z_[C::kTwist] -= spring_piece().rest_rad;
    z_[C::kCapacity] = state.brake_target_nm + model_.brake_drag_nm;
    if (chain_.brake_rate > 0.0) {
      z_[C::kBrakeGap] = state.brake_capacity_nm - state.brake_target_nm;
    }
    const double speed = z_[C::kLast];
    regime_.brake = speed == 0.0 ? brake_at_rest() : direction_of(speed);
  }
  if (model_.knob_is_driven()) return;
  const double speed = z_[C::kSpeed];
  regime_.knob = speed == 0.0 ? knob_at_rest() : direction_of(speed);
}

template <int kShafts>
void ExactStepper<kShafts>::store(PlantState& state, const HeldInputs& inputs,
                                  std::int64_t duration_ns) const {
  state.time_ns += duration_ns;
  state.knob_angle.add(z_[C::kTravel]);
  state.motor_torque_nm = inputs.motor_command_nm + settled(z_[C::kMotorGap]);
  for (std::size_t i = 0; i < 3; ++i) {
    state.speed_rad_s[i] = z_[C::kSpeed + std::min<std::size_t>(i, kShafts - 1)];
  }
  if constexpr (kShafts > 1) {
    for (std::size_t i = 0; i < C::kSprings; ++i) state.twist_rad[i] = z_[C::kTwist + i];
    state.twist_rad[0] += spring_piece().rest_rad;
    state.brake_capacity_nm = state.brake_target_nm + settled(z_[C::kBrakeGap]);
  }
}

template <int kShafts>
Slip ExactStepper<kShafts>::knob_at_rest() const {
  const double demand = chain_.knob_demand(z_, regime_);
  if (std::abs(demand) <= z_[C::kCoulomb]) return Slip::held;
  return direction_of(demand);
}

template <int kShafts>
Slip ExactStepper<kShafts>::brake_at_rest() const {
  if constexpr (kShafts > 1) {
    const double demand = chain_.brake_demand(z_, regime_);
    if (std::abs(demand) <= chain_.capacity(z_)) return Slip::held;
    return direction_of(demand);
  }
  return Slip::held;
}

template <int kShafts>
bool ExactStepper<kShafts>::climb(std::span<Rung<kShafts>> rungs) {
  if (!rungs[0].bends_known) find_bends<kShafts>(chain_, regime_, rungs);
  if constexpr (kShafts == 2) {
    const bool knob = regime_.knob != Slip::held || model_.knob_is_driven();
    if (regime_.brake == Slip::held) {
      return knob ? climb_with<Moving{true, false}>(rungs[0])
                  : climb_with<Moving{false, false}>(rungs[0]);
    }
    if (!knob) return climb_with<Moving{false, true}>(rungs[0]);
  }
  return climb_with<kAllMove>(rungs[0]);
}

// Nearly all of the emulator's time is spent here.
template <int kShafts>
template <Moving kMoving>
[[gnu::flatten]] bool ExactStepper<kShafts>::climb_with(const Rung<kShafts>& rung) {
  const auto drive = chain_.drives(z_, regime_);
  const Vector next = advanced<kShafts, kMoving>(chain_, regime_, rung, z_, drive);
  reach_ = 1.0;
  bool certain = true;
  // Between its ends a curve is nowhere lower than the lower end less the bend.
  const auto look = [&](double begin, double end, double bend) {
    if (std::min(begin, end) >= bend) return;
    certain = false;
    if (end < 0.0) reach_ = std::min(reach_, begin / (begin - end));
  };
  if (!model_.knob_is_driven()) {
    look(knob_room(z_), knob_room(next), bend_of<kShafts>(Watch::knob, rung, drive));
  }
  if constexpr (kShafts > 1) {
    look(brake_room(z_), brake_room(next), bend_of<kShafts>(Watch::brake, rung, drive));
  }
  if (!certain || (pieces_ && !stays_on_pieces(rung, next, drive))) return false;
  z_ = next;
  return true;
}

template <int kShafts>
bool ExactStepper<kShafts>::stays_on_pieces(const Rung<kShafts>& rung, const Vector& next,
                                            const typename C::Drives& drive) const {
  const double twist_bend = bend_of<kShafts>(Watch::twist, rung, drive);
  const double travel_bend = bend_of<kShafts>(Watch::travel, rung, drive);
  for (const Vector* z : {&std::as_const(z_), &next}) {
    if constexpr (kShafts > 1) {
      const SpringPiece& piece = spring_piece();
      const double twist = (*z)[C::kTwist] + piece.rest_rad;
      if (twist - piece.begin_rad < twist_bend || piece.end_rad - twist < twist_bend) return false;
    }
    const double travel = (*z)[C::kTravel];
    if (travel - travel_low_ < travel_bend || travel_high_ - travel < travel_bend) return false;
  }
  return true;
}

template <int kShafts>
typename ExactStepper<kShafts>::Outcome ExactStepper<kShafts>::creep(double step_s) {
  const auto series = taylor_series(chain_, z_, regime_, step_s);
  Event event = Event::none;
  double until = 1.0;
  // room = side (value) + constant, with value a linear function of the state.
  const auto look = [&](Event which, double side, auto value, double constant, double tolerance) {
    Polynomial room_over_time;
    for (std::size_t k = 0; k < series.size(); ++k) room_over_time[k] = side * value(series[k]);
    room_over_time[0] += constant;
    const auto crossing = first_crossing(room_over_time, tolerance);
    if (crossing && (event == Event::none || *crossing < until)) {
      until = *crossing;
      event = which;
    }
  };

  constexpr int kMostStalled = 16;
  if (stalled_ < kMostStalled) {
    // Rounding of the torques that are summed up, which no event may be made of.
    double torque = std::abs(z_[C::kForce]) + std::abs(z_[C::kMotorGap]) + z_[C::kCoulomb];
    for (std::size_t i = 0; i < C::kSprings; ++i) {
      torque += std::abs(chain_.stiffness(i, regime_) * z_[C::kTwist + i]) +
                model_.damping_nm_s_per_rad[i] *
                    (std::abs(z_[C::kSpeed + i]) + std::abs(z_[C::kSpeed + i + 1]));
    }
    const auto speed_rounding = [&](std::size_t shaft) {
      return 4.0 * kEpsilon *
             (torque * step_s / model_.inertia_kg_m2[shaft] + std::abs(z_[C::kSpeed + shaft]));
    };
    if (!model_.knob_is_driven()) {
      if (regime_.knob != Slip::held) {
        look(
            Event::knob, sign_of(regime_.knob), [](const Vector& z) { return z[C::kSpeed]; }, 0.0,
            speed_rounding(0));
      } else {
        for (const double side : {-1.0, 1.0}) {
          look(
              Event::knob, 1.0,
              [&](const Vector& z) {
                return z[C::kCoulomb] + side * chain_.knob_demand(z, regime_);
              },
              0.0, 4.0 * kEpsilon * torque);
        }
      }
    }
    if constexpr (kShafts > 1) {
      torque += z_[C::kCapacity] + std::abs(z_[C::kBrakeGap]);
      if (regime_.brake != Slip::held) {
        look(
            Event::brake, sign_of(regime_.brake), [](const Vector& z) { return z[C::kLast]; }, 0.0,
            speed_rounding(kShafts - 1));
      } else {
        for (const double side : {-1.0, 1.0}) {
          look(
              Event::brake, 1.0,
              [&](const Vector& z) {
                return chain_.capacity(z) + side * chain_.brake_demand(z, regime_);
              },
              0.0, 4.0 * kEpsilon * torque);
        }
      }
      if (pieces_) {
        const SpringPiece& piece = spring_piece();
        const auto twist = [](const Vector& z) { return z[C::kTwist]; };
        const double tolerance = 4.0 * kEpsilon * (std::abs(z_[C::kTwist]) + piece.rest_rad);
        if (std::isfinite(piece.begin_rad)) {
          look(Event::twist_low, 1.0, twist, piece.rest_rad - piece.begin_rad, tolerance);
        }
        if (std::isfinite(piece.end_rad)) {
          look(Event::twist_high, -1.0, twist, piece.end_rad - piece.rest_rad, tolerance);
        }
      }
    }
    if (!model_.cogging_nm.empty()) {
      const auto travel = [](const Vector& z) { return z[C::kTravel]; };
      const double tolerance =
          4.0 * kEpsilon * (std::abs(z_[C::kTravel]) + travel_high_ - travel_low_);
      look(Event::travel_low, 1.0, travel, -travel_low_, tolerance);
      look(Event::travel_high, -1.0, travel, travel_high_, tolerance);
    }
  } else {
    // Rounding makes laws contradict each other here: each sends the shaft to the other one. The
    // contradiction is gone a moment later.
    stalled_ = 0;
    step_s *= 1e-6;
    until = 1e-6;
  }

  if (until == 1.0) {
    for (std::size_t k = 1; k < series.size(); ++k) {
      for (std::size_t i = 0; i < C::kSize; ++i) z_[i] += series[k][i];
    }
  } else {
    double power = 1.0;
    for (std::size_t k = 1; k < series.size(); ++k) {
      power *= until;
      for (std::size_t i = 0; i < C::kSize; ++i) z_[i] += power * series[k][i];
    }
  }
  return {event == Event::none ? step_s : until * step_s, event};
}

template <int kShafts>
void ExactStepper<kShafts>::take(Event event) {
  switch (event) {
    case Event::none:
      break;
    case Event::knob:
      if (regime_.knob == Slip::held) {
        regime_.knob = direction_of(chain_.knob_demand(z_, regime_));
      } else {
        z_[C::kSpeed] = 0.0;
        regime_.knob = knob_at_rest();
      }
      break;
    case Event::brake:
      if constexpr (kShafts > 1) {
        if (regime_.brake == Slip::held) {
          regime_.brake = direction_of(chain_.brake_demand(z_, regime_));
        } else {
          z_[C::kLast] = 0.0;
          regime_.brake = brake_at_rest();
        }
      }
      break;
    case Event::twist_low:
    case Event::twist_high: {
      const auto rest = [&] { return spring_piece().rest_rad; };
      const double twist = z_[C::kTwist] + rest();
      regime_.spring_piece += event == Event::twist_high ? 1 : -1;
      z_[C::kTwist] = twist - rest();
      break;
    }
    case Event::travel_low:
    case Event::travel_high: {
      const int steps = event == Event::travel_high ? 1 : -1;
      const double border = steps > 0 ? travel_high_ : travel_low_;
      regime_.cogging = neighbour(model_, regime_.cogging, steps);
      travel_low_ = border + regime_.cogging.begin_rad;
      travel_high_ = border + regime_.cogging.end_rad;
      break;
    }
  }
}

template <int kShafts>
void ExactStepper<kShafts>::step(PlantState& state, const HeldInputs& inputs,
                                 std::int64_t duration_ns) {
  load(state, inputs);
  nominal_cost_ns_ += kStepCostNs[kShafts - 1] + (model_.cogging_nm.empty() ? 0.0 : kCoggingCostNs);
  double remaining_s = 1e-9 * static_cast<double>(duration_ns);
  std::size_t rung = 0;
  while (remaining_s > 0.0) {
    const auto rungs = ladder();
    int tries = 1;
    while (rung < rungs_) {
      if (rungs[rung].step_s <= remaining_s) {
        if (climb(rungs.subspan(rung))) break;
        ++tries;
        // What is as long as the way to the event is not worth a try.
        const double reach_s = reach_ * rungs[rung].step_s;
        while (rung + 1 < rungs_ && rungs[rung + 1].step_s > reach_s) ++rung;
      }
      ++rung;
    }
    nominal_cost_ns_ += kRungCostNs[kShafts - 1] * tries;
    if (rung < rungs_) {
      remaining_s -= rungs[rung].step_s;
      if (rung > 0) --rung;
      continue;
    }
    nominal_cost_ns_ += kCreepCostNs[kShafts - 1];
    const Outcome outcome = creep(std::min(finest_s_, remaining_s));
    remaining_s -= outcome.elapsed_s;
    rung = rungs_ - 1;
    if (outcome.event != Event::none) {
      stalled_ = outcome.elapsed_s > 1e-6 * finest_s_ ? 0 : stalled_ + 1;
      take(outcome.event);
      rung = rungs_;  // close to an event the bounds are of no use
    }
  }
  store(state, inputs, duration_ns);
}

}  // namespace

std::unique_ptr<Stepper> make_exact_stepper(PlantModel model, std::int64_t step_ns) {
  switch (model.shafts) {
    case 1:
      return std::make_unique<ExactStepper<1>>(std::move(model), step_ns);
    case 2:
      return std::make_unique<ExactStepper<2>>(std::move(model), step_ns);
    default:
      return std::make_unique<ExactStepper<3>>(std::move(model), step_ns);
  }
}

}  // namespace torsio::emulator
