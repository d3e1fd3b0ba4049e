#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "emulator/first_crossing.hpp"
#include "emulator/plant_chain.hpp"

namespace torsio::emulator {

template <std::size_t kSize>
using SquareMatrix = std::array<std::array<double, kSize>, kSize>;  // [row][column]

/// exp(2 A) - 1 from x = exp(A) - 1. Keeping the 1 apart saves the digits of slow motions, which
/// repeated squaring would lose where other parts of the matrix are fast.
template <std::size_t kSize>
SquareMatrix<kSize> doubled(const SquareMatrix<kSize>& x) {
  SquareMatrix<kSize> result{};
  for (std::size_t i = 0; i < kSize; ++i) {
    for (std::size_t k = 0; k < kSize; ++k) {
      if (x[i][k] == 0.0) continue;  // most rows are of constants, which do not change
      for (std::size_t j = 0; j < kSize; ++j) result[i][j] += x[i][k] * x[k][j];
    }
    for (std::size_t j = 0; j < kSize; ++j) result[i][j] += 2.0 * x[i][j];
  }
  return result;
}

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

  /// exp(M step) - 1, the rows that move, and the bends: for each watch a row d such that within
  /// the step the watched value never leaves the straight line from its begin to its end by more
  /// than d |z|. Such bounds make it cheap to be sure of no event.
  struct Column {
    std::array<double, C::kMoving> change;
    std::array<double, kWatches> bend;
  };

  double step_s = 0.0;
  double motor_change = 0.0;  ///< exp(-step/tau_m) - 1
  double brake_change = 0.0;  ///< exp(-step/tau_b) - 1
  bool bends_known = false;
  std::array<Column, C::kSize> columns{};
};

/// A ladder is an array of rungs whose step lengths halve from each to the next. Its last kFiner
/// rungs only serve to sample the others, 2^kFiner times a step.
constexpr std::size_t kFiner = 3;
constexpr std::size_t kSamples = 1u << kFiner;

/// Makes the rungs of one regime, without their bends.
/// @param shortest_s length of the last rung; short enough for the Taylor series
/// @param scratch room for as many matrices as there are rungs
template <int kShafts>
void build_ladder(const Chain<kShafts>& chain, const Regime& regime, double shortest_s,
                  std::span<Rung<kShafts>> rungs,
                  std::span<SquareMatrix<Chain<kShafts>::kSize>> scratch) {
  using C = Chain<kShafts>;
  const std::size_t last = rungs.size() - 1;
  for (std::size_t column = 0; column < C::kSize; ++column) {
    typename C::Vector unit{};
    unit[column] = 1.0;
    const auto series = taylor_series(chain, unit, regime, shortest_s);
    for (std::size_t row = 0; row < C::kSize; ++row) {
      double sum = 0.0;
      for (std::size_t k = series.size() - 1; k > 0; --k) sum += series[k][row];
      scratch[last][row][column] = sum;
    }
  }
  for (std::size_t i = last; i > 0; --i) scratch[i - 1] = doubled(scratch[i]);

  for (std::size_t i = 0; i <= last; ++i) {
    Rung<kShafts>& rung = rungs[i];
    rung.step_s = std::ldexp(shortest_s, static_cast<int>(last - i));
    rung.bends_known = false;
    rung.motor_change = scratch[i][C::kMotorGap][C::kMotorGap];
    if constexpr (kShafts > 1) rung.brake_change = scratch[i][C::kBrakeGap][C::kBrakeGap];
    for (std::size_t column = 0; column < C::kSize; ++column) {
      for (std::size_t row = 0; row < C::kMoving; ++row) {
        rung.columns[column].change[row] = scratch[i][row][column];
      }
    }
  }
}

/// row exp(M step), for a row over the state.
template <int kShafts>
typename Chain<kShafts>::Vector carried(const Chain<kShafts>& chain, const Regime& regime,
                                        const Rung<kShafts>& rung,
                                        const typename Chain<kShafts>::Vector& row) {
  using C = Chain<kShafts>;
  auto result = row;
  const double back = chain.knob_stiffness(regime) * row[C::kForce];
  for (std::size_t j = 0; j < C::kSize; ++j) {
    const auto& change = rung.columns[j].change;
    for (std::size_t k = 0; k < C::kMoving; ++k) result[j] += row[k] * change[k];
    result[j] -= back * change[C::kTravel];
  }
  result[C::kSlope] += row[C::kForce] * rung.step_s;
  result[C::kMotorGap] += row[C::kMotorGap] * rung.motor_change;
  if constexpr (kShafts > 1) result[C::kBrakeGap] += row[C::kBrakeGap] * rung.brake_change;
  return result;
}

/// |y|, where y is z with the force on the knob replaced by the net torque there, and the capacity
/// of a brake that slips by the net torque on its shaft. It tells as much as z does, but torques
/// that balance each other have left it, and how much a curve bends depends on the net torques
/// only.
template <int kShafts>
typename Chain<kShafts>::Vector sizes(const Chain<kShafts>& chain, const Regime& regime,
                                      const typename Chain<kShafts>::Vector& z) {
  using C = Chain<kShafts>;
  typename C::Vector size;
  for (std::size_t j = 0; j < C::kSize; ++j) size[j] = std::abs(z[j]);
  size[C::kForce] = std::abs(chain.knob_net(z, regime));
  if constexpr (kShafts > 1) {
    if (regime.brake != Slip::held) size[C::kCapacity] = std::abs(chain.brake_net(z, regime));
  }
  return size;
}

/// A row over z, written as a row over the y of sizes().
template <int kShafts>
typename Chain<kShafts>::Vector over_net_torques(const Chain<kShafts>& chain, const Regime& regime,
                                                 const typename Chain<kShafts>::Vector& row) {
  using C = Chain<kShafts>;
  auto result = row;
  for (std::size_t j = 0; j < C::kSize; ++j) {
    typename C::Vector unit{};
    unit[j] = 1.0;
    // The force, and below the capacity, that keep the net torques at 0.
    if (j != C::kForce) result[j] -= row[C::kForce] * chain.knob_net(unit, regime);
    if constexpr (kShafts > 1) {
      if (regime.brake == Slip::held) continue;
      const double sign = sign_of(regime.brake);
      if (j == C::kCapacity) {
        result[j] = -sign * row[j];
      } else {
        result[j] += row[C::kCapacity] * sign * chain.brake_net(unit, regime);
      }
    }
  }
  return result;
}

/// Works out the bends of rung 0 of `rungs` from the finer rungs after it.
template <int kShafts>
void find_bends(const Chain<kShafts>& chain, const Regime& regime, std::span<Rung<kShafts>> rungs) {
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;
  // A bend is largest near a sample, not at one; of a sine of 2 rad a step, the fastest that a rung
  // is used for, 8 samples find all but 1 %, of a fast decay all but 1/8.
  constexpr double kMargin = 1.2;

  const auto add_bend = [&](Watch watch, auto value) {
    std::array<Vector, kSamples + 1> rows{};
    for (std::size_t j = 0; j < C::kSize; ++j) {
      Vector unit{};
      unit[j] = 1.0;
      rows[0][j] = value(unit);
    }
    for (std::size_t i = 0; i < kSamples; ++i) {
      rows[i + 1] = carried(chain, regime, rungs[kFiner], rows[i]);
    }
    for (Vector& row : rows) row = over_net_torques(chain, regime, row);
    for (std::size_t j = 0; j < C::kSize; ++j) {
      double largest = 0.0;
      for (std::size_t i = 1; i < kSamples; ++i) {
        const double along = static_cast<double>(i) / static_cast<double>(kSamples);
        const double line = rows[0][j] + along * (rows[kSamples][j] - rows[0][j]);
        largest = std::max(largest, std::abs(rows[i][j] - line));
      }
      rungs[0].columns[j].bend[static_cast<std::size_t>(watch)] += kMargin * largest;
    }
  };

  for (auto& column : rungs[0].columns) column.bend = {};
  if (regime.knob != Slip::held) {
    add_bend(Watch::knob, [](const Vector& z) { return z[C::kSpeed]; });
  } else {
    add_bend(Watch::knob, [&](const Vector& z) { return chain.knob_demand(z, regime); });
  }
  if constexpr (kShafts > 1) {
    if (regime.brake != Slip::held) {
      add_bend(Watch::brake, [](const Vector& z) { return z[C::kLast]; });
    } else {
      // The room is the capacity less the demand, so their bends add up.
      add_bend(Watch::brake, [&](const Vector& z) { return chain.brake_demand(z, regime); });
      add_bend(Watch::brake, [&](const Vector& z) { return chain.capacity(z); });
    }
    if (chain.model.shaft_spring.size() > 1) {
      add_bend(Watch::twist, [](const Vector& z) { return z[C::kTwist]; });
    }
  }
  if (!chain.model.cogging_nm.empty()) {
    add_bend(Watch::travel, [](const Vector& z) { return z[C::kTravel]; });
  }
  rungs[0].bends_known = true;
}

}  // namespace torsio::emulator
