/// @file
/// The laws that hold now, and what an event makes of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "emulator/plant/exact/chain.hpp"
#include "emulator/plant/exact/taylor.hpp"
#include "emulator/plant/model.hpp"

namespace torsio::emulator {

/// A plant with its present regime.
/// @tparam kPlain no prescribed path, and nothing that is linear in pieces only
template <int kShafts, bool kPlain>
class SwitchedPlant {
 public:
  using C = Chain<kShafts>;
  using Vector = typename C::Vector;

  explicit SwitchedPlant(PlantModel plant)
      : model(std::move(plant)),
        chain(model),
        driven_(model.knob_is_driven()),
        pieces_(model.shaft_spring.size() > 1 || !model.cogging_nm.empty()) {}
  SwitchedPlant(const SwitchedPlant&) = delete;  // `chain` knows `model`
  SwitchedPlant& operator=(const SwitchedPlant&) = delete;

  PlantModel model;
  C chain;
  Regime regime;
  // The ends of the cogging's piece:
  double travel_low = -std::numeric_limits<double>::infinity();
  double travel_high = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool driven() const { return !kPlain && driven_; }  ///< on a prescribed path
  [[nodiscard]] bool pieces() const { return !kPlain && pieces_; }  ///< linear in pieces only
  [[nodiscard]] const SpringPiece& spring_piece() const {
    return model.shaft_spring[static_cast<std::size_t>(regime.spring_piece)];
  }

  [[nodiscard]] std::size_t regimes() const {
    return 9 * springs() * std::max<std::size_t>(1, model.cogging_nm.size());
  }
  /// @returns which of the regimes holds
  [[nodiscard]] std::size_t regime_index() const {
    const int slips = 3 * static_cast<int>(regime.knob) + static_cast<int>(regime.brake) + 4;
    if (!pieces()) return static_cast<std::size_t>(slips);
    const int piece = regime.cogging.index * static_cast<int>(springs()) + regime.spring_piece;
    return static_cast<std::size_t>(slips + 9 * piece);
  }

  /// Rest until friction lets go or catches: of its torque, or of the speed.
  [[nodiscard]] double knob_room(const Vector& z) const {
    if (regime.knob != Slip::held) return sign_of(regime.knob) * z[C::kSpeed];
    return z[C::kCoulomb] - std::abs(chain.knob_demand(z, regime));
  }
  [[nodiscard]] double brake_room(const Vector& z) const
    requires(kShafts > 1)
  {
    if (regime.brake != Slip::held) return sign_of(regime.brake) * z[C::kLast];
    return chain.capacity(z) - std::abs(chain.brake_demand(z, regime));
  }

  [[nodiscard]] Slip knob_at_rest(const Vector& z) const {
    const double demand = chain.knob_demand(z, regime);
    if (std::abs(demand) <= z[C::kCoulomb]) return Slip::held;
    return direction_of(demand);
  }
  [[nodiscard]] Slip brake_at_rest(const Vector& z) const
    requires(kShafts > 1)
  {
    const double demand = chain.brake_demand(z, regime);
    if (std::abs(demand) <= chain.capacity(z)) return Slip::held;
    return direction_of(demand);
  }

  /// Changes the regime as the event has it.
  void take(Event event, Vector& z) {
    switch (event) {
      case Event::none:
        break;
      case Event::knob:
        return turn_knob(z);
      case Event::brake:
        if constexpr (kShafts > 1) turn_brake(z);
        break;
      case Event::twist_low:
        return pass_knee(-1, z);
      case Event::twist_high:
        return pass_knee(1, z);
      case Event::travel_low:
        return pass_cogging(-1);
      case Event::travel_high:
        return pass_cogging(1);
    }
  }

 private:
  [[nodiscard]] std::size_t springs() const {
    return std::max<std::size_t>(1, model.shaft_spring.size());
  }

  /// Friction lets go of the knob or catches it, and likewise the brake.
  void turn_knob(Vector& z) {
    if (regime.knob == Slip::held) {
      regime.knob = direction_of(chain.knob_demand(z, regime));
    } else {
      z[C::kSpeed] = 0.0;
      regime.knob = knob_at_rest(z);
    }
  }
  void turn_brake(Vector& z)
    requires(kShafts > 1)
  {
    if (regime.brake == Slip::held) {
      regime.brake = direction_of(chain.brake_demand(z, regime));
    } else {
      z[C::kLast] = 0.0;
      regime.brake = brake_at_rest(z);
    }
  }
  void pass_knee(int pieces, Vector& z) {
    const double twist = z[C::kTwist] + spring_piece().rest_rad;
    regime.spring_piece += pieces;
    z[C::kTwist] = twist - spring_piece().rest_rad;
  }
  void pass_cogging(int pieces) {
    const double border = pieces > 0 ? travel_high : travel_low;
    regime.cogging = neighbour(model, regime.cogging, pieces);
    travel_low = border + regime.cogging.begin_rad;
    travel_high = border + regime.cogging.end_rad;
  }

  bool driven_;
  bool pieces_;
};

}  // namespace torsio::emulator
