/// @file
/// The electrics of a plant: what bridges, windings and supply make of shares of the supply.
#pragma once

#include <cstdint>

#include "emulator/plant/plant.hpp"

namespace torsio::emulator {

/// State of the bridges until the PWM changes.
struct BridgeShares {
  double motor = 0.0;  ///< of the supply's voltage on the winding, -1 to 1; positive turns forward
  double brake = 0.0;  ///< the same on the brake's coil
  bool enabled = false;
};

/// A bridge that is on gives its winding a share of the supply's voltage, the mean over a PWM
/// period. A sensor sees the current's ripple; the torque does not have it. A bridge that is off
/// lets the current run back into the supply through its diodes, until it ends.
///
/// Between two changes the voltages are constant and the plant's steps are exact, back EMF
/// included. Resistances follow the temperatures in steps of a fifth of a percent. The moment at
/// which a current ends is computed with the speed of the begin; within microseconds the speed
/// changes by too little to matter. The supply's voltage is followed from change to change.
///
/// With hysteresis of the brake its torque follows the coil's current with a play, either way; the
/// torque has no sign. It is then held from change to change, at what the current at the end of the
/// piece makes of it.
class Circuit {
 public:
  explicit Circuit(const Electrics& electrics);

  /// Lets time pass for a plant that has these electrics.
  /// @param duration_ns > 0, short beside the time constants of winding and supply
  void advance(Plant& plant, const BridgeShares& shares, std::int64_t duration_ns);

  [[nodiscard]] double supply_v() const { return supply_v_; }
  /// The supply gives another voltage from now on, without load; its capacitor follows.
  void set_supply(double supply_v) { electrics_.supply_v = supply_v; }
  [[nodiscard]] ElectricsState state(const Plant& plant) const;
  /// The motor's current; positive turns forward.
  [[nodiscard]] double current_a(const Plant& plant) const;
  /// The current of the brake's coil, with its sign.
  [[nodiscard]] double coil_current_a(const Plant& plant) const;
  /// Ripple in the motor's current, so long after the middle of the driven time.
  [[nodiscard]] double ripple_a(const BridgeShares& shares, double offset_s) const;

 private:
  struct Piece {
    Plant::Drive drive;
    std::int64_t duration_ns;
    bool motor_ends;
    bool coil_ends;
  };
  [[nodiscard]] Piece next_piece(const Plant& plant, const BridgeShares& shares,
                                 std::int64_t most_ns) const;
  /// The torque that the coil's current makes in a brake without hysteresis, >= 0.
  [[nodiscard]] double coil_torque_nm(const Plant& plant) const;
  /// A piece of the coil's current where hysteresis lies between it and the brake's torque.
  void follow_coil(Plant& plant, const Piece& piece);
  void follow_supply(double drawn_a, double duration_s);
  void warm_up(double motor_square_a2, double coil_square_a2, double duration_s);
  /// Copper that has become warmer resists more.
  void adjust_resistances(Plant& plant) const;

  Electrics electrics_;  // as they are at 25 degrees
  double winding_c_;
  double rotor_c_;
  double coil_c_;
  double supply_v_;
  double coil_sign_ = 1.0;       // of the coil's current
  double iron_sign_ = 1.0;       // the last direction, for a brake with hysteresis
  double coil_torque_nm_ = 0.0;  // see coil_torque_nm(); of a plant with hysteresis
};

}  // namespace torsio::emulator
