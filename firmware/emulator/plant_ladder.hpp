#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

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
      for (std::size_t j = 0; j < kSize; ++j) result[i][j] += x[i][k] * x[k][j];
    }
    for (std::size_t j = 0; j < kSize; ++j) result[i][j] += 2.0 * x[i][j];
  }
  return result;
}

/// Terms k = 0 to kPolynomialDegree of the Taylor series of z(t) over t/step in [0, 1].
template <int kShafts>
using Series = std::array<typename Chain<kShafts>::Vector, 13>;

template <int kShafts>
Series<kShafts> taylor_series(const Chain<kShafts>& chain, const typename Chain<kShafts>::Vector& z,
                              const Regime& regime, double step_s) {
  Series<kShafts> series;
  series[0] = z;
  for (std::size_t k = 1; k < series.size(); ++k) {
    series[k] = chain.rates(series[k - 1], regime);
    for (double& term : series[k]) term *= step_s / static_cast<double>(k);
  }
  return series;
}

/// What is watched for events, each a linear function of the state.
enum class Watch : std::size_t { knob, brake, twist, travel };
constexpr std::size_t kWatches = 4;

/// One step length of a regime.
template <int kShafts>
struct Rung {
  using Vector = typename Chain<kShafts>::Vector;

  double step_s = 0.0;
  /// exp(M step) - 1, the rows that move: [column][row].
  std::array<std::array<double, Chain<kShafts>::kMoving>, Chain<kShafts>::kSize> change{};
  double motor_change = 0.0;  ///< exp(-step/tau_m) - 1
  double brake_change = 0.0;  ///< exp(-step/tau_b) - 1
  /// For each watch a row d: within the step the watched value never leaves the straight line from
  /// its begin to its end by more than d |z|. Such bounds make it cheap to be sure of no event.
  std::array<Vector, kWatches> bend{};
};

/// The rungs of one regime: rungs[i] is a step of rungs[0].step_s / 2^i.
/// @param finest_s length of the last rung; short enough for the Taylor series of degree 12
/// @param scratch room for rungs.size() + 4 matrices
template <int kShafts>
void build_ladder(const Chain<kShafts>& chain, const Regime& regime, double finest_s,
                  std::span<Rung<kShafts>> rungs,
                  std::span<SquareMatrix<Chain<kShafts>::kSize>> scratch) {
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;
  constexpr std::size_t kFiner = 4;  // samples are 2^kFiner to a step
  constexpr std::size_t kSamples = 1u << kFiner;
  // The bend is largest near a sample, not at one; for a parabola 16 samples find it within 0.4 %.
  constexpr double kMargin = 1.1;

  const double sample_s = finest_s / static_cast<double>(kSamples);
  const std::size_t last = rungs.size() + kFiner - 1;
  for (std::size_t column = 0; column < C::kSize; ++column) {
    Vector unit{};
    unit[column] = 1.0;
    const auto series = taylor_series(chain, unit, regime, sample_s);
    for (std::size_t row = 0; row < C::kSize; ++row) {
      double sum = 0.0;
      for (std::size_t k = series.size() - 1; k > 0; --k) sum += series[k][row];
      scratch[last][row][column] = sum;
    }
  }
  for (std::size_t i = last; i > 0; --i) scratch[i - 1] = doubled(scratch[i]);

  // The watched values as rows over the state.
  std::array<Vector, kWatches + 1> watched{};
  for (std::size_t column = 0; column < C::kSize; ++column) {
    Vector unit{};
    unit[column] = 1.0;
    watched[0][column] =
        regime.knob == Slip::held ? chain.knob_demand(unit, regime) : unit[C::kSpeed];
    if constexpr (kShafts > 1) {
      watched[1][column] =
          regime.brake == Slip::held ? chain.brake_demand(unit, regime) : unit[C::kLast];
      watched[2][column] = unit[C::kTwist];
      watched[kWatches][column] = regime.brake == Slip::held ? chain.capacity(unit) : 0.0;
    }
    watched[3][column] = unit[C::kTravel];
  }

  for (std::size_t rung = 0; rung < rungs.size(); ++rung) {
    Rung<kShafts>& r = rungs[rung];
    r.step_s = finest_s * std::ldexp(1.0, static_cast<int>(rungs.size() - 1 - rung));
    for (std::size_t column = 0; column < C::kSize; ++column) {
      for (std::size_t row = 0; row < C::kMoving; ++row) {
        r.change[column][row] = scratch[rung][row][column];
      }
    }
    r.motor_change = std::expm1(-chain.motor_rate * r.step_s);
    r.brake_change = std::expm1(-chain.brake_rate * r.step_s);

    const auto& sample = scratch[rung + kFiner];
    r.bend = {};
    for (std::size_t watch = 0; watch < watched.size(); ++watch) {
      // Row times exp(M t) at the samples.
      std::array<Vector, kSamples + 1> rows;
      rows[0] = watched[watch];
      for (std::size_t i = 0; i < kSamples; ++i) {
        rows[i + 1] = rows[i];
        for (std::size_t k = 0; k < C::kSize; ++k) {
          for (std::size_t j = 0; j < C::kSize; ++j) rows[i + 1][j] += rows[i][k] * sample[k][j];
        }
      }
      // The room that a held brake has is its capacity less the demand, so their bends add up.
      Vector& bend = r.bend[watch == kWatches ? static_cast<std::size_t>(Watch::brake) : watch];
      for (std::size_t j = 0; j < C::kSize; ++j) {
        double largest = 0.0;
        for (std::size_t i = 1; i < kSamples; ++i) {
          const double along = static_cast<double>(i) / static_cast<double>(kSamples);
          const double line = rows[0][j] + along * (rows[kSamples][j] - rows[0][j]);
          largest = std::max(largest, std::abs(rows[i][j] - line));
        }
        bend[j] += kMargin * largest;
      }
    }
  }
}

}  // namespace torsio::emulator
