/// @file
/// The plant's state as a Taylor series over one step, and the search for friction events in it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "emulator/plant/exact/chain.hpp"
#include "emulator/plant/exact/first_crossing.hpp"

namespace torsio::emulator {

/// Calls `use(i)` for i = 0, 1, ... kCount - 1 with i as a constant of the compiler's.
template <std::size_t kCount, class Use>
[[gnu::always_inline]] constexpr void unrolled(Use&& use) {
  [&]<std::size_t... kIndex>(std::index_sequence<kIndex...>) __attribute__((always_inline)) {
    (use(std::integral_constant<std::size_t, kIndex>{}), ...);
  }(std::make_index_sequence<kCount>{});
}

constexpr std::array<double, kPolynomialDegree + 1> kReciprocal = [] {
  std::array<double, kPolynomialDegree + 1> result{};
  for (std::size_t k = 1; k < result.size(); ++k) result[k] = 1.0 / static_cast<double>(k);
  return result;
}();

/// Terms of the Taylor series of z(t) over t/step in [0, 1].
template <int kShafts>
using Series = std::array<typename Chain<kShafts>::Vector, kPolynomialDegree + 1>;

template <int kShafts>
Series<kShafts> taylor_series(const Chain<kShafts>& chain, const typename Chain<kShafts>::Vector& z,
                              const Regime& regime, double step_s) {
  using C = Chain<kShafts>;
  // In locals, which the compiler knows the series not to overwrite.
  std::array<double, kShafts> mobility = chain.mobility;
  if (regime.knob == Slip::held) mobility[0] = 0.0;
  if (kShafts > 1 && regime.brake == Slip::held) mobility[kShafts - 1] = 0.0;
  const std::array<double, kShafts> viscous = chain.viscous;
  const std::array<double, C::kSprings> damping = chain.damping;
  std::array<double, C::kSprings> stiffness{};
  for (std::size_t i = 0; i < C::kSprings; ++i) stiffness[i] = chain.stiffness(i, regime);
  const double knob_side = sign_of(regime.knob);
  const double brake_side = sign_of(regime.brake);
  const double ground = chain.knob_stiffness(regime);
  const double motor_rate = chain.motor_rate;
  const double back_emf = chain.back_emf;
  const double brake_rate = chain.brake_rate;

  Series<kShafts> series;
  series[0] = z;
  for (std::size_t k = 1; k < series.size(); ++k) {
    const auto& at = series[k - 1];
    auto& term = series[k];
    const double scale = step_s * kReciprocal[k];
    std::array<double, kShafts> torque{};
    torque[0] = at[C::kForce] + at[C::kMotorGap] - knob_side * at[C::kCoulomb];
    if constexpr (kShafts > 1) {
      torque[kShafts - 1] = -brake_side * (at[C::kCapacity] + at[C::kBrakeGap]);
      term[C::kBrakeGap] = -scale * brake_rate * at[C::kBrakeGap];
    }
    for (std::size_t i = 0; i < C::kSprings; ++i) {
      const double twisting = at[C::kSpeed + i] - at[C::kSpeed + i + 1];
      const double link = stiffness[i] * at[C::kTwist + i] + damping[i] * twisting;
      torque[i] -= link;
      torque[i + 1] += link;
      term[C::kTwist + i] = scale * twisting;
    }
    for (std::size_t i = 0; i < kShafts; ++i) {
      const double net = torque[i] - viscous[i] * at[C::kSpeed + i];
      term[C::kSpeed + i] = scale * mobility[i] * net;
    }
    term[C::kTravel] = scale * at[C::kSpeed];
    term[C::kMotorGap] = -scale * motor_rate * (at[C::kMotorGap] + back_emf * at[C::kSpeed]);
    term[C::kForce] = scale * (at[C::kSlope] - ground * at[C::kSpeed]);
    std::fill(term.begin() + C::kVarying, term.end(), 0.0);
  }
  return series;
}

/// The state at s in [0, 1].
template <int kShafts>
typename Chain<kShafts>::Vector value_at(const Series<kShafts>& series, double s) {
  using C = Chain<kShafts>;
  std::array<double, C::kVarying> change{};
  for (std::size_t k = series.size(); k-- > 1;) {
    unrolled<C::kVarying>([&](auto i) { change[i] = (change[i] + series[k][i]) * s; });
  }
  typename C::Vector z = series[0];
  for (std::size_t i = 0; i < C::kVarying; ++i) z[i] += change[i];
  return z;
}

constexpr double kEpsilon = 0x1p-52;

enum class Event { none, knob, brake, twist_low, twist_high, travel_low, travel_high };

/// Looks for the first event along a series. Each watched quantity is linear in the state.
template <int kShafts>
class EventSearch {
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;

 public:
  EventSearch(const C& chain, const Regime& regime, const Series<kShafts>& series)
      : chain_(chain), regime_(regime), series_(series) {}

  [[nodiscard]] Event event() const { return event_; }
  /// Where it is; 1 without one.
  [[nodiscard]] double until() const { return until_; }

  /// Finds friction that catches a shaft or lets go of it.
  [[gnu::always_inline]] void look_at_friction(bool driven, double step_s) {
    const Vector& z = series_[0];
    // Rounding of the torques that are summed up, which no event may be made of.
    double torque = std::abs(z[C::kForce]) + std::abs(z[C::kMotorGap]) + z[C::kCoulomb];
    for (std::size_t i = 0; i < C::kSprings; ++i) {
      torque += std::abs(chain_.stiffness(i, regime_) * z[C::kTwist + i]) +
                chain_.damping[i] * (std::abs(z[C::kSpeed + i]) + std::abs(z[C::kSpeed + i + 1]));
    }
    const auto speed_rounding = [&](std::size_t shaft) {
      return 4.0 * kEpsilon *
             (torque * step_s * chain_.mobility[shaft] + std::abs(z[C::kSpeed + shaft]));
    };
    if (regime_.knob != Slip::held) {
      look_slipping(Event::knob, regime_.knob, C::kSpeed, speed_rounding(0));
    } else if (!driven) {
      look_held(
          Event::knob, [](const Vector& at) { return at[C::kCoulomb]; },
          [&](const Vector& at) { return chain_.knob_demand(at, regime_); },
          4.0 * kEpsilon * torque);
    }
    if constexpr (kShafts > 1) {
      torque += z[C::kCapacity] + std::abs(z[C::kBrakeGap]);
      if (regime_.brake != Slip::held) {
        look_slipping(Event::brake, regime_.brake, C::kLast, speed_rounding(kShafts - 1));
      } else {
        look_held(
            Event::brake, [&](const Vector& at) { return chain_.capacity(at); },
            [&](const Vector& at) { return chain_.brake_demand(at, regime_); },
            4.0 * kEpsilon * torque);
      }
    }
  }

  /// Finds the end of the spring's piece, and of the cogging's, from `low` to `high`.
  [[gnu::always_inline]] void look_at_pieces(double low, double high) {
    const Vector& z = series_[0];
    const auto& springs = chain_.model.shaft_spring;
    if (kShafts > 1 && springs.size() > 1) {
      const SpringPiece& piece = springs[static_cast<std::size_t>(regime_.spring_piece)];
      const double tolerance = 4.0 * kEpsilon * (std::abs(z[C::kTwist]) + std::abs(piece.rest_rad));
      for (const auto& [which, side, border_rad] :
           {std::tuple{Event::twist_low, -1.0, piece.begin_rad},
            std::tuple{Event::twist_high, 1.0, piece.end_rad}}) {
        if (!std::isfinite(border_rad)) continue;
        look_border(which, side, C::kTwist, border_rad - piece.rest_rad, tolerance);
      }
    }
    if (chain_.model.cogging_nm.empty()) return;
    const double tolerance = 4.0 * kEpsilon * (std::abs(z[C::kTravel]) + high - low);
    look_border(Event::travel_low, -1.0, C::kTravel, low, tolerance);
    look_border(Event::travel_high, 1.0, C::kTravel, high, tolerance);
  }

 private:
  /// Does a shaft stop that turns in `direction`?
  void look_slipping(Event which, Slip direction, std::size_t speed, double tolerance) {
    const double side = sign_of(direction);
    look(which, along([&](const Vector& z) { return side * z[speed]; }), tolerance);
  }

  /// Does a demand become larger than the capacity, in either direction?
  template <class Capacity, class Demand>
  void look_held(Event which, Capacity&& capacity_of, Demand&& demand_of, double tolerance) {
    const Polynomial capacity = along(capacity_of);
    const Polynomial demand = along(demand_of);
    // Mostly there is more left than could be used up.
    double change = 0.0;
    for (std::size_t k = 1; k < demand.size(); ++k) {
      change += std::abs(capacity[k]) + std::abs(demand[k]);
    }
    if (capacity[0] - std::abs(demand[0]) > change + tolerance) return;
    for (const double side : {-1.0, 1.0}) {
      Polynomial room;
      for (std::size_t k = 0; k < room.size(); ++k) room[k] = capacity[k] + side * demand[k];
      look(which, room, tolerance);
    }
  }

  /// Does a component pass a border in the direction of `side`?
  void look_border(Event which, double side, std::size_t row, double border, double tolerance) {
    Polynomial room = along([&](const Vector& z) { return -side * z[row]; });
    room[0] += side * border;
    look(which, room, tolerance);
  }

  template <class Value>
  Polynomial along(Value&& value) const {
    Polynomial result;
    for (std::size_t k = 0; k < series_.size(); ++k) result[k] = value(series_[k]);
    return result;
  }

  void look(Event which, const Polynomial& room, double tolerance) {
    const auto crossing = first_crossing(room, tolerance);
    if (crossing && (event_ == Event::none || *crossing < until_)) {
      until_ = *crossing;
      event_ = which;
    }
  }

  const C& chain_;
  const Regime& regime_;
  const Series<kShafts>& series_;
  Event event_ = Event::none;
  double until_ = 1.0;
};

}  // namespace torsio::emulator
