#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include "emulator/first_crossing.hpp"
#include "emulator/plant_chain.hpp"

namespace torsio::emulator {

/// Terms of the Taylor series of z(t) over t/step in [0, 1].
template <int kShafts>
using Series = std::array<typename Chain<kShafts>::Vector, kPolynomialDegree + 1>;

template <int kShafts>
Series<kShafts> taylor_series(const Chain<kShafts>& chain, const typename Chain<kShafts>::Vector& z,
                              const Regime& regime, double step_s) {
  Series<kShafts> series;
  series[0] = z;
  for (std::size_t k = 1; k < series.size(); ++k) {
    series[k] = chain.rates(series[k - 1], regime);
    const double scale = step_s / static_cast<double>(k);
    for (double& term : series[k]) term *= scale;
  }
  return series;
}

/// What is watched for events, each a linear function of the state. The first two are the room that
/// friction has: the speed of a shaft that slips, or what is left of the friction that holds it.
enum class Watch : std::size_t { knob, brake, twist, travel };
constexpr std::size_t kWatches = 4;

/// One step length of a regime.
template <int kShafts>
struct Rung {
  using C = Chain<kShafts>;

  /// What one unit of a drive at the begin makes of what moves within the step; the knob's travel
  /// at its first speed is left out. And the bends: for each watch how far at most the value leaves
  /// the straight line from its begin to its end. Such bounds make it cheap to be sure of no event.
  struct Column {
    std::array<double, C::kMoving> change;
    std::array<double, kWatches> bend;
  };

  double step_s = 0.0;
  double motor_change = 0.0;  ///< exp(-step/tau_m) - 1
  double brake_change = 0.0;  ///< exp(-step/tau_b) - 1
  bool bends_known = false;
  std::array<Column, C::kDrives> columns{};
};

/// A ladder is an array of rungs whose step lengths halve from each to the next. Its last kFiner
/// rungs only serve to sample the others, 2^kFiner times a step.
constexpr std::size_t kFiner = 3;
constexpr std::size_t kSamples = 1u << kFiner;

/// Which shafts' ends move: what a still one would contribute is left out of the sums.
struct Moving {
  bool knob;
  bool brake;
};
constexpr Moving kAllMove{true, true};

/// Calls `use(i)` for i = 0, 1, ... kCount - 1 with i as a constant of the compiler's.
template <std::size_t kCount, class Use>
constexpr void unrolled(Use&& use) {
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
    (use(std::integral_constant<std::size_t, kIndex>{}), ...);
  }(std::make_index_sequence<kCount>{});
}

/// The state a step later: z + the integral of exp(M t) over the step times M z. The rates are
/// small where torques balance, so that slow motions keep their digits beside fast ones.
template <int kShafts, Moving kMoving = kAllMove>
typename Chain<kShafts>::Vector advanced(const Chain<kShafts>& chain, const Regime& regime,
                                         const Rung<kShafts>& rung,
                                         const typename Chain<kShafts>::Vector& z,
                                         const typename Chain<kShafts>::Drives& drive) {
  using C = Chain<kShafts>;
  constexpr bool kStill = kShafts == 2 && !kMoving.knob && !kMoving.brake;
  std::array<double, C::kMoving> change{};
  unrolled<C::kDrives>([&](auto j) {
    constexpr bool kOfKnob = j == C::kNet || j == C::kForcing || j == C::kMotorDrive;
    constexpr bool kOfBrake = kShafts > 1 && (j == C::kNetLast || j == C::kBrakeDrive);
    if constexpr (kStill || (kOfKnob && !kMoving.knob) || (kOfBrake && !kMoving.brake)) return;
    const auto& column = rung.columns[j].change;
    unrolled<C::kMoving>([&](auto i) {
      constexpr bool kRowOfKnob = i == C::kSpeed || i == C::kTravel;
      constexpr bool kRowOfBrake = kShafts > 1 && i == C::kLast;
      if constexpr ((kRowOfKnob && !kMoving.knob) || (kRowOfBrake && !kMoving.brake)) return;
      change[i] += column[i] * drive[j];
    });
  });
  typename C::Vector next = z;
  if constexpr (!kStill) {
    for (std::size_t i = 0; i < C::kMoving; ++i) next[i] += change[i];
  }
  next[C::kMotorGap] += rung.motor_change * drive[C::kMotorDrive];
  next[C::kForce] += rung.step_s * drive[C::kForcing];
  if constexpr (kMoving.knob) {
    next[C::kForce] -= chain.knob_stiffness(regime) * change[C::kTravel];
    next[C::kTravel] += rung.step_s * z[C::kSpeed];
  }
  if constexpr (kShafts > 1) next[C::kBrakeGap] += rung.brake_change * drive[C::kBrakeDrive];
  return next;
}

/// How far at most a watched value leaves the straight line within the step.
template <int kShafts>
double bend_of(Watch watch, const Rung<kShafts>& rung,
               const typename Chain<kShafts>::Drives& drive) {
  double bend = 0.0;
  unrolled<Chain<kShafts>::kDrives>([&](auto j) {
    bend += rung.columns[j].bend[static_cast<std::size_t>(watch)] * std::abs(drive[j]);
  });
  return bend;
}

/// What one unit of a drive makes of the whole state within a rung's step.
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
void build_ladder(const Chain<kShafts>& chain, const Regime& regime, double shortest_s,
                  std::span<Rung<kShafts>> rungs) {
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;
  const std::size_t last = rungs.size() - 1;
  for (std::size_t i = rungs.size(); i-- > 0;) {
    Rung<kShafts>& rung = rungs[i];
    rung = {};
    rung.step_s = std::ldexp(shortest_s, static_cast<int>(last - i));
    rung.motor_change = std::expm1(-chain.motor_rate * rung.step_s);
    rung.brake_change = std::expm1(-chain.brake_rate * rung.step_s);
    for (std::size_t drive = 0; drive < C::kDrives; ++drive) {
      Vector whole{};
      if (i == last) {
        const auto series = taylor_series(chain, chain.rates_of(drive), regime, shortest_s);
        for (std::size_t k = series.size(); k-- > 0;) {
          const double weight = shortest_s / static_cast<double>(k + 1);
          for (std::size_t row = 0; row < C::kMoving; ++row) whole[row] += weight * series[k][row];
        }
      } else {
        // What the first half made goes on by itself in the second one, where the drive, which
        // would still be there, makes the same again.
        const Rung<kShafts>& half = rungs[i + 1];
        const Vector first = response(chain, regime, half, drive);
        whole = advanced<kShafts>(chain, regime, half, first, chain.drives(first, regime));
        for (std::size_t row = 0; row < C::kMoving; ++row) whole[row] += first[row];
      }
      for (std::size_t row = 0; row < C::kMoving; ++row) {
        rung.columns[drive].change[row] = whole[row];
      }
    }
  }
}

/// Works out the bends of rung 0 of `rungs` from the finer rungs after it.
template <int kShafts>
void find_bends(const Chain<kShafts>& chain, const Regime& regime, std::span<Rung<kShafts>> rungs) {
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;
  // A bend is largest near a sample, not at one; of a sine of 2 rad a step, the fastest that a rung
  // is used for, 8 samples find all but 1 %, of a fast decay all but 1/8.
  constexpr double kMargin = 1.2;

  for (std::size_t drive = 0; drive < C::kDrives; ++drive) {
    const Vector of_sample = response(chain, regime, rungs[kFiner], drive);
    std::array<Vector, kSamples + 1> z{};
    for (std::size_t i = 0; i < kSamples; ++i) {
      z[i + 1] = advanced<kShafts>(chain, regime, rungs[kFiner], z[i], chain.drives(z[i], regime));
      for (std::size_t row = 0; row < C::kSize; ++row) z[i + 1][row] += of_sample[row];
    }
    auto& bend = rungs[0].columns[drive].bend;
    bend = {};
    const auto add_bend = [&](Watch watch, auto value) {
      double largest = 0.0;
      for (std::size_t i = 1; i < kSamples; ++i) {
        const double along = static_cast<double>(i) / static_cast<double>(kSamples);
        largest = std::max(largest, std::abs(value(z[i]) - along * value(z[kSamples])));
      }
      bend[static_cast<std::size_t>(watch)] += kMargin * largest;
    };
    if (regime.knob != Slip::held) {
      add_bend(Watch::knob, [](const Vector& at) { return at[C::kSpeed]; });
    } else {
      add_bend(Watch::knob, [&](const Vector& at) { return chain.knob_demand(at, regime); });
    }
    if constexpr (kShafts > 1) {
      if (regime.brake != Slip::held) {
        add_bend(Watch::brake, [](const Vector& at) { return at[C::kLast]; });
      } else {
        // The room is the capacity less the demand, so their bends add up.
        add_bend(Watch::brake, [&](const Vector& at) { return chain.brake_demand(at, regime); });
        add_bend(Watch::brake, [&](const Vector& at) { return chain.capacity(at); });
      }
      if (chain.model.shaft_spring.size() > 1) {
        add_bend(Watch::twist, [](const Vector& at) { return at[C::kTwist]; });
      }
    }
    if (!chain.model.cogging_nm.empty()) {
      add_bend(Watch::travel, [](const Vector& at) { return at[C::kTravel]; });
    }
  }
  rungs[0].bends_known = true;
}

}  // namespace torsio::emulator
