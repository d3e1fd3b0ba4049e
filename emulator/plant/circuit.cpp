#include "emulator/plant/circuit.hpp"

#include <algorithm>
#include <cmath>

#include "emulator/plant/portable_math.hpp"

namespace torsio::emulator {
namespace {

// Current of two bridges that are awake, the board's regulator and the divider. It empties the
// supply's capacitor after braking has charged it.
constexpr double kStandbyA = 5e-3;

/// When something that goes from a value to an end, of the other sign, with a time constant is
/// zero.
double zero_after_s(double value, double end, double time_constant_s) {
  return time_constant_s * log_of(1.0 - value / end);
}

/// Resistance of copper as a multiple of its value at 25 degrees; positive at any temperature.
double copper_share(double temperature_c) {
  return std::max(0.05, 1.0 + 3.93e-3 * (temperature_c - 25.0));
}

/// Rounded up, at least one.
std::int64_t in_ns(double time_s) {
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(1e9 * time_s)));
}

}  // namespace

Circuit::Circuit(const Electrics& electrics)
    : electrics_(electrics),
      winding_c_(electrics.ambient_c),
      rotor_c_(electrics.ambient_c),
      coil_c_(electrics.ambient_c),
      supply_v_(electrics.supply_v) {}

ElectricsState Circuit::state(const Plant& plant) const {
  return {.motor_current_a = current_a(plant),
          .coil_current_a = coil_current_a(plant),
          .supply_v = supply_v_,
          .winding_c = winding_c_,
          .rotor_c = rotor_c_,
          .coil_c = coil_c_};
}

double Circuit::current_a(const Plant& plant) const {
  return plant.state().motor_torque_nm / electrics_.torque_constant_nm_per_a;
}

double Circuit::coil_current_a(const Plant& plant) const {
  return coil_sign_ * coil_torque_nm(plant) / electrics_.coil_torque_constant_nm_per_a;
}

double Circuit::coil_torque_nm(const Plant& plant) const {
  return plant.params().brake_hysteresis ? coil_torque_nm_ : plant.state().brake_magnetic_nm;
}

double Circuit::ripple_a(const BridgeShares& shares, double offset_s) const {
  if (!shares.enabled) return 0.0;
  const double share = std::abs(shares.motor);
  // The current rises while the bridge drives and falls meanwhile; in the middle it is at its mean.
  const double rise_a = (1.0 - share) * supply_v_ / electrics_.winding_inductance_h * offset_s;
  return std::copysign(rise_a, shares.motor) * (share > 0.0 ? 1.0 : 0.0);
}

Circuit::Piece Circuit::next_piece(const Plant& plant, const BridgeShares& shares,
                                   std::int64_t most_ns) const {
  Piece piece{{}, most_ns, false, false};
  const PlantState& state = plant.state();
  const double winding_ohm = plant.params().electrics->winding_resistance_ohm;
  const double coil_ohm = plant.params().electrics->coil_resistance_ohm;
  const double constant = electrics_.torque_constant_nm_per_a;
  const double nm_per_v = constant / winding_ohm;
  const double torque_nm = state.motor_torque_nm;
  if (shares.enabled) {
    piece.drive.motor_target_nm = shares.motor * supply_v_ * nm_per_v;
  } else if (torque_nm == 0.0) {
    piece.drive.motor_connected = false;
  } else {
    piece.drive.motor_target_nm = -std::copysign(supply_v_, torque_nm) * nm_per_v;
    const double end_nm =
        piece.drive.motor_target_nm - constant * nm_per_v * state.knob_speed_rad_s();
    if (end_nm * torque_nm < 0.0) {
      const std::int64_t zero_ns =
          in_ns(zero_after_s(torque_nm, end_nm, electrics_.winding_inductance_h / winding_ohm));
      if (zero_ns <= piece.duration_ns) {
        piece.duration_ns = zero_ns;
        piece.motor_ends = true;
      }
    }
  }

  const double coil_nm_per_v = electrics_.coil_torque_constant_nm_per_a / coil_ohm;
  const double magnetic_nm = coil_torque_nm(plant);
  if (shares.enabled) {
    piece.drive.brake_target_nm = coil_sign_ * shares.brake * supply_v_ * coil_nm_per_v;
  } else if (magnetic_nm > 0.0) {
    piece.drive.brake_target_nm = -supply_v_ * coil_nm_per_v;
  }
  if (piece.drive.brake_target_nm < 0.0) {
    const std::int64_t zero_ns = in_ns(zero_after_s(magnetic_nm, piece.drive.brake_target_nm,
                                                    electrics_.coil_inductance_h / coil_ohm));
    if (zero_ns <= piece.duration_ns) {
      piece.motor_ends = piece.motor_ends && zero_ns == piece.duration_ns;
      piece.duration_ns = zero_ns;
      piece.coil_ends = true;
    }
  }
  return piece;
}

void Circuit::advance(Plant& plant, const BridgeShares& shares, std::int64_t duration_ns) {
  const double begin_a = current_a(plant);
  const double begin_coil_a = coil_current_a(plant);
  std::int64_t left_ns = duration_ns;
  while (left_ns > 0) {
    if (coil_torque_nm(plant) == 0.0 && shares.brake != 0.0) {
      coil_sign_ = std::copysign(1.0, shares.brake);
    }
    const Piece piece = next_piece(plant, shares, left_ns);
    if (plant.params().brake_hysteresis) {
      follow_coil(plant, piece);
    } else {
      plant.set_drive(piece.drive);
    }
    plant.advance(piece.duration_ns);
    if (piece.motor_ends || piece.coil_ends) {
      PlantState state = plant.state();
      if (piece.motor_ends) state.motor_torque_nm = 0.0;
      if (piece.coil_ends && !plant.params().brake_hysteresis) {
        state.brake_magnetic_nm = 0.0;
        state.brake_target_nm = 0.0;
      }
      // Where a current ends it is not exactly zero: time is in whole nanoseconds.
      state.brake_target_nm = std::max(state.brake_target_nm, 0.0);
      plant.set_state(state);
    }
    left_ns -= piece.duration_ns;
  }
  adjust_resistances(plant);
  const double end_a = current_a(plant);
  const double end_coil_a = coil_current_a(plant);
  const double duration_s = 1e-9 * static_cast<double>(duration_ns);
  warm_up(0.5 * (begin_a * begin_a + end_a * end_a),
          0.5 * (begin_coil_a * begin_coil_a + end_coil_a * end_coil_a), duration_s);
  const double mean_a = 0.5 * (begin_a + end_a);
  const double mean_coil_a = 0.5 * (begin_coil_a + end_coil_a);
  follow_supply(shares.enabled ? shares.motor * mean_a + shares.brake * mean_coil_a
                               : -std::abs(mean_a) - std::abs(mean_coil_a),
                duration_s);
}

void Circuit::follow_coil(Plant& plant, const Piece& piece) {
  const double time_constant_s =
      electrics_.coil_inductance_h / plant.params().electrics->coil_resistance_ohm;
  const double duration_s = 1e-9 * static_cast<double>(piece.duration_ns);
  coil_torque_nm_ +=
      (coil_torque_nm_ - piece.drive.brake_target_nm) * expm1_of(-duration_s / time_constant_s);
  if (piece.coil_ends) coil_torque_nm_ = 0.0;
  const double play_nm = plant.params().brake_hysteresis->half_width_nm;
  PlantState state = plant.state();
  const double coil_nm = coil_sign_ * coil_torque_nm_;
  const double iron_nm =
      std::clamp(iron_sign_ * state.brake_magnetic_nm, coil_nm - play_nm, coil_nm + play_nm);
  iron_sign_ = std::copysign(1.0, iron_nm);
  state.brake_magnetic_nm = std::abs(iron_nm);
  state.brake_target_nm = state.brake_magnetic_nm;
  Plant::Drive drive = piece.drive;
  drive.brake_target_nm = state.brake_magnetic_nm;
  plant.set_state(state);
  plant.set_drive(drive);
}

void Circuit::warm_up(double motor_square_a2, double coil_square_a2, double duration_s) {
  const Electrics& e = electrics_;
  const double winding_w = motor_square_a2 * e.winding_resistance_ohm * copper_share(winding_c_);
  const double coil_w = coil_square_a2 * e.coil_resistance_ohm * copper_share(coil_c_);
  const double to_rotor_w = (winding_c_ - rotor_c_) / e.winding_to_rotor_k_per_w;
  const double to_air_w = (rotor_c_ - e.ambient_c) / e.rotor_to_air_k_per_w;
  // Steps of microseconds beside time constants of minutes.
  winding_c_ += duration_s * (winding_w - to_rotor_w) / e.winding_heat_j_per_k;
  rotor_c_ += duration_s * (to_rotor_w - to_air_w) / e.rotor_heat_j_per_k;
  coil_c_ +=
      duration_s * (coil_w - (coil_c_ - e.ambient_c) / e.coil_to_air_k_per_w) / e.coil_heat_j_per_k;
}

void Circuit::adjust_resistances(Plant& plant) const {
  constexpr double kStep = 2e-3;
  const double winding_ohm = electrics_.winding_resistance_ohm * copper_share(winding_c_);
  const double coil_ohm = electrics_.coil_resistance_ohm * copper_share(coil_c_);
  const Electrics& used = *plant.params().electrics;
  if (std::abs(winding_ohm - used.winding_resistance_ohm) > kStep * used.winding_resistance_ohm ||
      std::abs(coil_ohm - used.coil_resistance_ohm) > kStep * used.coil_resistance_ohm) {
    plant.set_resistances(winding_ohm, coil_ohm);
  }
}

void Circuit::follow_supply(double drawn_a, double duration_s) {
  const double resistance = electrics_.supply_resistance_ohm;
  if (resistance == 0.0) return;
  // The supply gives from its capacitor first. It takes nothing back, so braking charges the
  // capacitor.
  const double lone_v =
      supply_v_ - (drawn_a + kStandbyA) * duration_s / electrics_.supply_capacitance_f;
  if (lone_v >= electrics_.supply_v) {
    supply_v_ = lone_v;
    return;
  }
  const double end_v = electrics_.supply_v - resistance * drawn_a;
  const double change = expm1_of(-duration_s / (resistance * electrics_.supply_capacitance_f));
  supply_v_ += (supply_v_ - end_v) * change;
}

}  // namespace torsio::emulator
