/// @file
/// Exact steps of halving lengths, computed once, with bounds on what happens inside them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>

#include "emulator/plant/exact/chain.hpp"
#include "emulator/plant/exact/taylor.hpp"
#include "emulator/plant/portable_math.hpp"

namespace torsio::emulator {

/// Two numbers that a processor multiplies and adds at once where it can; GCC and Clang know it.
using Pair = double __attribute__((vector_size(2 * sizeof(double))));

inline Pair magnitude(Pair pair) {
  using Bits = std::int64_t __attribute__((vector_size(sizeof(Pair))));
  constexpr std::int64_t kAllButSign = std::numeric_limits<std::int64_t>::max();
  return std::bit_cast<Pair>(std::bit_cast<Bits>(pair) & Bits{kAllButSign, kAllButSign});
}

/// Quantities watched for events, each a linear function of the state. Two are the room of friction
/// on knob and brake: the speed of a shaft that slips, or the friction left on one that is held.
/// The others are linear in pieces: the shaft's twist and the knob's travel.
constexpr int kKnob = 0;
constexpr int kBrake = 1;
constexpr int kTwisted = 0;
constexpr int kTravelled = 1;

/// One step length of a regime.
template <int kShafts>
struct Rung {
  using C = Chain<kShafts>;

  /// Effect of one unit of a drive at the begin on the moving states within the step, without the
  /// knob's travel at its first speed. And the bends: for each watch how far at most the value
  /// leaves the straight line from its begin to its end. Such bounds make it cheap to be sure of no
  /// event.
  struct Column {
    std::array<Pair, C::kMoving / 2> change;
    Pair friction_bend;
    Pair piece_bend;
  };

  double step_s = 0.0;
  double motor_change = 0.0;  ///< exp(-step/tau_m) - 1
  double brake_change = 0.0;  ///< exp(-step/tau_b) - 1
  bool bends_known = false;
  /// With back EMF: what one unit of each drive makes of the motor's gap.
  typename C::Drives motor_changes{};
  std::array<Column, C::kDrives> columns{};
};

/// A ladder is an array of rungs whose step lengths halve from each to the next. Its last kFiner
/// rungs only serve to sample the others, 2^kFiner times a step.
constexpr std::size_t kFiner = 3;
constexpr std::size_t kSamples = 1u << kFiner;

/// The cells of a whole step, each as long as the last rung that is not only sampled.
struct Cells {
  std::size_t rungs = 1;
  std::int64_t count = 1;
  double length_s = 0.0;
};

/// @throws std::invalid_argument if the plant moves too fast for any such step
template <int kShafts>
Cells cells_of_step(const Chain<kShafts>& chain, std::int64_t step_ns) {
  // On the longest rung the sampled bounds must resolve every oscillation; within the last one the
  // Taylor series must converge. With n = kPolynomialDegree and x = rate times step, it leaves out
  // less than x^(n+1) / (n+1)! of a torque that decays at that rate, the first term of an
  // alternating series; of the speed that the torque makes, which begins with x, 1 / x times as
  // much, and of the angle, which begins with x^2 / 2, 2 / x^2 times: 2e-12, 3e-12 and 7e-12 for x
  // = 0.7.
  constexpr double kResolved = 2.0;
  constexpr double kConverged = 0.7;
  static_assert(kPolynomialDegree >= 12);
  constexpr int kMostHalvings = 40;
  const double oscillation = chain.fastest_oscillation();
  const double fastest = oscillation + chain.fastest_decay();
  Cells cells{.length_s = 1e-9 * static_cast<double>(step_ns)};
  int halvings = 0;
  while (cells.length_s * fastest > kConverged) {
    if (cells.length_s * oscillation <= kResolved) ++cells.rungs;
    cells.length_s *= 0.5;
    cells.count *= 2;
    if (++halvings > kMostHalvings) {
      throw std::invalid_argument(
          "plant: its fastest motion is more than 1e11 times faster than step_ns; "
          "shorten the step, or set small time constants to 0");
    }
  }
  return cells;
}

/// Moving ends of shafts: a still one is left out of the sums.
struct Moving {
  bool knob;
  bool brake;
};
constexpr Moving kAllMove{true, true};

/// Does a drive act on anything that is not still?
template <int kShafts, Moving kMoving>
constexpr bool acts(std::size_t drive) {
  using C = Chain<kShafts>;
  if (kShafts != 2) return true;
  const bool of_knob = drive == C::kNet || drive == C::kForcing || drive == C::kMotorDrive;
  const bool of_brake = drive == C::kNetLast || drive == C::kBrakeDrive;
  if (!kMoving.knob && !kMoving.brake) return false;
  return !(of_knob && !kMoving.knob) && !(of_brake && !kMoving.brake);
}

/// The state a step later: z + the integral of exp(M t) over the step times M z. The rates are
/// small where torques balance, so that slow motions keep their digits beside fast ones.
template <int kShafts, Moving kMoving = kAllMove>
typename Chain<kShafts>::Vector advanced(const Chain<kShafts>& chain, const Regime& regime,
                                         const Rung<kShafts>& rung,
                                         const typename Chain<kShafts>::Vector& z,
                                         const typename Chain<kShafts>::Drives& drive) {
  using C = Chain<kShafts>;
  constexpr std::size_t kPairs = C::kMoving / 2;
  static_assert(C::kMoving % 2 == 0);
  std::array<Pair, kPairs> change{};
  unrolled<C::kDrives>([&](auto j) {
    if constexpr (acts<kShafts, kMoving>(j)) {
      const Pair both{drive[j], drive[j]};
      unrolled<kPairs>([&](auto i) { change[i] += rung.columns[j].change[i] * both; });
    }
  });
  typename C::Vector next;
  unrolled<C::kSize>([&](auto i) { next[i] = z[i]; });
  if constexpr (kMoving.knob || kMoving.brake) {
    unrolled<C::kMoving>([&](auto i) { next[i] += change[i / 2][i % 2]; });
  }
  if (chain.back_emf == 0.0) [[likely]] {
    next[C::kMotorGap] += rung.motor_change * drive[C::kMotorDrive];
  } else {
    unrolled<C::kDrives>([&](auto j) { next[C::kMotorGap] += rung.motor_changes[j] * drive[j]; });
  }
  next[C::kForce] += rung.step_s * drive[C::kForcing];
  if constexpr (kMoving.knob) {
    next[C::kForce] -= chain.knob_stiffness(regime) * change[C::kTravel / 2][C::kTravel % 2];
    next[C::kTravel] += rung.step_s * z[C::kSpeed];
  }
  if constexpr (kShafts > 1) next[C::kBrakeGap] += rung.brake_change * drive[C::kBrakeDrive];
  return next;
}

/// Can a drive bend a watched curve? A torque that friction takes up grows along a straight line.
template <int kShafts, Moving kMoving>
constexpr bool bends(std::size_t drive) {
  using C = Chain<kShafts>;
  if (kShafts != 2) return true;
  if (!kMoving.knob && (drive == C::kNet || drive == C::kForcing)) return false;
  if (!kMoving.brake && drive == C::kNetLast) return false;
  return kMoving.knob || kMoving.brake || drive != C::kTwisting;
}

/// How far at most two watched values leave the straight line within the step.
template <int kShafts, Moving kMoving = kAllMove>
Pair bends_of(Pair Rung<kShafts>::Column::* watched, const Rung<kShafts>& rung,
              const typename Chain<kShafts>::Drives& drive) {
  Pair bend{};
  unrolled<Chain<kShafts>::kDrives>([&](auto j) {
    if constexpr (bends<kShafts, kMoving>(j)) {
      bend += rung.columns[j].*watched * magnitude(Pair{drive[j], drive[j]});
    }
  });
  return bend;
}

/// Effect of one unit of a drive on the whole state within a rung's step.
template <int kShafts>
typename Chain<kShafts>::Vector response(const Chain<kShafts>& chain, const Regime& regime,
                                         const Rung<kShafts>& rung, std::size_t drive) {
  typename Chain<kShafts>::Drives unit{};
  unit[drive] = 1.0;
  return advanced<kShafts>(chain, regime, rung, {}, unit);
}

/// Makes the rungs of one regime, without their bends.
/// @param shortest_s length of the last rung; short enough for the Taylor series
template <int kShafts>
[[gnu::noinline]] void build_ladder(const Chain<kShafts>& chain, const Regime& regime,
                                    double shortest_s, std::span<Rung<kShafts>> rungs) {
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;
  const std::size_t last = rungs.size() - 1;
  for (std::size_t i = rungs.size(); i-- > 0;) {
    Rung<kShafts>& rung = rungs[i];
    rung = {};
    rung.step_s = std::ldexp(shortest_s, static_cast<int>(last - i));
    rung.motor_change = expm1_of(-chain.motor_rate * rung.step_s);
    rung.brake_change = expm1_of(-chain.brake_rate * rung.step_s);
    for (std::size_t drive = 0; drive < C::kDrives; ++drive) {
      Vector whole{};
      if (i == last) {
        const auto series = taylor_series(chain, chain.rates_of(drive), regime, shortest_s);
        for (std::size_t k = series.size(); k-- > 0;) {
          const double weight = shortest_s / static_cast<double>(k + 1);
          for (std::size_t row = 0; row < C::kMoving; ++row) whole[row] += weight * series[k][row];
          whole[C::kMotorGap] += weight * series[k][C::kMotorGap];
        }
      } else {
        // The first half's effect goes on by itself in the second half. There the drive makes the
        // same again.
        const Rung<kShafts>& half = rungs[i + 1];
        const Vector first = response(chain, regime, half, drive);
        whole = advanced<kShafts>(chain, regime, half, first, chain.drives(first, regime));
        for (std::size_t row = 0; row < C::kMoving; ++row) whole[row] += first[row];
        whole[C::kMotorGap] += first[C::kMotorGap];
      }
      rung.motor_changes[drive] = whole[C::kMotorGap];
      for (std::size_t row = 0; row < C::kMoving; ++row) {
        rung.columns[drive].change[row / 2][row % 2] = whole[row];
      }
    }
  }
}

/// Works out the bends of rung 0 of `rungs` from the finer rungs after it.
template <int kShafts>
[[gnu::noinline]] void find_bends(const Chain<kShafts>& chain, const Regime& regime,
                                  std::span<Rung<kShafts>> rungs) {
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;
  // A bend is largest near a sample, not at one. A rung's fastest sine has 2 rad a step: there 8
  // samples find all but 1 %. In a fast decay they find all but 1/8.
  constexpr double kMargin = 1.2;

  for (std::size_t drive = 0; drive < C::kDrives; ++drive) {
    const Vector of_sample = response(chain, regime, rungs[kFiner], drive);
    std::array<Vector, kSamples + 1> z{};
    for (std::size_t i = 0; i < kSamples; ++i) {
      z[i + 1] = advanced<kShafts>(chain, regime, rungs[kFiner], z[i], chain.drives(z[i], regime));
      for (std::size_t row = 0; row < C::kSize; ++row) z[i + 1][row] += of_sample[row];
    }
    Pair& friction = rungs[0].columns[drive].friction_bend;
    Pair& piece = rungs[0].columns[drive].piece_bend;
    const auto add_bend = [&](Pair& bend, int watch, auto value) {
      double largest = 0.0;
      for (std::size_t i = 1; i < kSamples; ++i) {
        const double along = static_cast<double>(i) / static_cast<double>(kSamples);
        largest = std::max(largest, std::abs(value(z[i]) - along * value(z[kSamples])));
      }
      bend[watch] += kMargin * largest;
    };
    if (regime.knob != Slip::held) {
      add_bend(friction, kKnob, [](const Vector& at) { return at[C::kSpeed]; });
    } else {
      add_bend(friction, kKnob, [&](const Vector& at) { return chain.knob_demand(at, regime); });
    }
    if constexpr (kShafts > 1) {
      if (regime.brake != Slip::held) {
        add_bend(friction, kBrake, [](const Vector& at) { return at[C::kLast]; });
      } else {
        // The room is the capacity less the demand, so their bends add up.
        add_bend(friction, kBrake,
                 [&](const Vector& at) { return chain.brake_demand(at, regime); });
        add_bend(friction, kBrake, [&](const Vector& at) { return chain.capacity(at); });
      }
      if (chain.model.shaft_spring.size() > 1) {
        add_bend(piece, kTwisted, [](const Vector& at) { return at[C::kTwist]; });
      }
    }
    if (!chain.model.cogging_nm.empty()) {
      add_bend(piece, kTravelled, [](const Vector& at) { return at[C::kTravel]; });
    }
  }
  rungs[0].bends_known = true;
}

}  // namespace torsio::emulator
