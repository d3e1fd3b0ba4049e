/// @file
/// The equations of the plant with the parts in use put together.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "emulator/plant/hand.hpp"
#include "emulator/plant/params.hpp"
#include "emulator/plant/profile.hpp"
#include "emulator/plant/state.hpp"

namespace torsio::emulator {

enum class HandKind : std::uint8_t { none, torque, impedance, prescribed };

/// A straight piece of a spring's characteristic: torque = stiffness (twist - rest).
struct SpringPiece {
  double begin_rad;
  double end_rad;
  double stiffness_nm_per_rad;
  double rest_rad;
};

/// A straight piece of the motor's cogging, as seen from the knob's present angle.
struct CoggingPiece {
  int index;         ///< of the piece in the table
  double begin_rad;  ///< distance from here back to the piece's begin, <= 0
  double end_rad;    ///< distance from here on to the piece's end, >= 0
  double torque_nm;  ///< on the knob, here
  double slope_nm_per_rad;
};

/// The equations of the plant: parts put together, hand included. One to three shafts in a row with
/// springs between them, friction on the first and the last one. Every stepper works from this.
struct PlantModel {
  int shafts = 1;
  std::array<double, 3> inertia_kg_m2{};         ///< the knob's includes the hand's
  std::array<double, 3> viscous_nm_s_per_rad{};  ///< the knob's includes the hand's damping
  std::array<double, 2> damping_nm_s_per_rad{};  ///< of the springs
  std::vector<SpringPiece> shaft_spring;         ///< 1 or 3 pieces, in the order of twist
  double belt_stiffness_nm_per_rad = 0.0;
  double knob_coulomb_nm = 0.0;
  double brake_drag_nm = 0.0;
  double motor_time_constant_s = 0.0;
  /// Loss of the motor's settled torque by the speed: k^2 / R of its winding.
  double back_emf_nm_s_per_rad = 0.0;
  double brake_time_constant_s = 0.0;
  HandKind hand = HandKind::none;
  double hand_stiffness_nm_per_rad = 0.0;
  double hand_damping_nm_s_per_rad = 0.0;
  std::vector<double> cogging_nm;  ///< table over one period; empty without the part
  double cogging_period_rad = 0.0;

  [[nodiscard]] int last_shaft() const { return shafts - 1; }
  [[nodiscard]] bool has_spring() const { return shafts > 1; }
  [[nodiscard]] bool knob_is_driven() const { return hand == HandKind::prescribed; }
};

/// @throws std::invalid_argument as validate() of params and hand does
/// @param connected false: the motor's winding has no circuit; only a plant with electrics knows
/// that
[[nodiscard]] PlantModel make_model(const PlantParams& params, const Hand& hand,
                                    bool connected = true);

/// Inputs that hold during one step: the motor's command, and the straight piece of the hand's
/// profile, which the step does not leave.
struct HeldInputs {
  double motor_command_nm;
  ProfileSegment hand;
};

/// The hand's torque on the knob while the knob moves by x from where it is:
/// force + slope t - stiffness x, less the hand's damping, which PlantModel counts as viscous.
struct HandForce {
  double force_nm;
  double slope_nm_per_s;
};
[[nodiscard]] inline HandForce hand_force(const PlantModel& model, const PlantState& state,
                                          const HeldInputs& inputs) {
  if (model.hand == HandKind::torque) {
    return {inputs.hand.value(state.time_ns), inputs.hand.slope_per_s};
  }
  if (model.hand != HandKind::impedance) return {0.0, 0.0};
  const double stretch_rad = inputs.hand.value(state.time_ns) - state.knob_angle_rad();
  return {model.hand_stiffness_nm_per_rad * stretch_rad +
              model.hand_damping_nm_s_per_rad * inputs.hand.slope_per_s,
          model.hand_stiffness_nm_per_rad * inputs.hand.slope_per_s};
}

/// Index of the piece of the shaft spring that a twist lies on; at a border, the inner one.
[[nodiscard]] int spring_piece_at(const PlantModel& model, double twist_rad);

/// Torque of the shaft spring at a twist, without damping, that turns the knob back when positive.
[[nodiscard]] double spring_torque_nm(const PlantModel& model, double twist_rad);

/// The piece of the cogging that an angle lies on; at a border, the one that begins there.
/// All zero without the part.
[[nodiscard]] CoggingPiece cogging_at(const PlantModel& model, const Angle& angle);

/// The piece `steps` (+1 or -1) beyond `piece`, seen from the border that they share.
[[nodiscard]] CoggingPiece neighbour(const PlantModel& model, const CoggingPiece& piece, int steps);

/// Torque that drives shaft 0 or the last shaft apart from the Coulomb friction there: what
/// friction has to hold when the shaft is at rest.
[[nodiscard]] double friction_demand_nm(const PlantModel& model, const PlantState& state,
                                        const HeldInputs& inputs, int shaft);

[[nodiscard]] Truth truth(const PlantModel& model, const PlantState& state,
                          const HeldInputs& inputs);

}  // namespace torsio::emulator
