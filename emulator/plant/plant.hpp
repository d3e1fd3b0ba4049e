/// @file
/// The plant: the mechanics that the emulated device moves.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "emulator/plant/exact/stepper.hpp"
#include "emulator/plant/hand.hpp"
#include "emulator/plant/params.hpp"
#include "emulator/plant/require.hpp"
#include "emulator/plant/state.hpp"
#include "emulator/plant/stepper.hpp"

namespace torsio::emulator {

/// Motor, knob, shaft spring, brake and hand under a virtual clock. Commands are held until they
/// are changed. Time is in whole nanoseconds. However calls of advance() cut the time, the state is
/// the same to the bit. A copy continues on its own, but shares the tables of its steps. So two
/// threads must not advance both at once.
class Plant {
 public:
  /// At rest at time 0, angle 0, except that a PrescribedMotion puts the knob on its path.
  /// @param step_ns steps end on multiples of this since time 0, > 0. It sets the cost of exact
  ///        steps, not their accuracy, and is best the control period.
  /// @throws std::invalid_argument that names the field which is out of its range
  explicit Plant(const PlantParams& params = {}, Hand hand = NoHand{},
                 std::int64_t step_ns = kStepNs, MakeStepper make_stepper = make_exact_stepper);

  static constexpr std::int64_t kStepNs = 1'000'000;

  /// Sets what is held from now on. Values beyond the actuators' limits are clipped to them.
  /// @throws std::invalid_argument if a value is not finite
  void set_command(const Command& command) {
    require(std::isfinite(command.motor_command_nm), "plant: motor_command_nm must be finite");
    require(std::isfinite(command.brake_command_nm), "plant: brake_command_nm must be finite");
    command_ = command;
    inputs_.motor_command_nm =
        std::clamp(command.motor_command_nm, -params_.motor_limit_nm, params_.motor_limit_nm);
    coil_target_nm_ = std::clamp(command.brake_command_nm, 0.0, params_.brake_limit_nm);
    state_.brake_target_nm = coil_target_nm_;
    if (plays()) follow_coil();
    between_ = false;  // the next step starts from here
  }

  /// Orders of the bridges of a plant with electrics from now on.
  struct Drive {
    double motor_target_nm = 0.0;  ///< at which the motor's would settle at rest
    bool motor_connected = true;   ///< false: the winding has no circuit, and no current
    double brake_target_nm = 0.0;  ///< where the brake's goes; below 0 it must not arrive
  };
  /// In place of set_command().
  void set_drive(const Drive& drive);

  /// Other resistances of the windings, of a plant with electrics, as they warm up.
  void set_resistances(double winding_ohm, double coil_ohm);

  /// Another hand takes over now; motion goes on from where it is.
  /// @throws std::invalid_argument as the constructor does; the old hand then stays
  void set_hand(Hand hand);

  /// Changes the torque of a hand that already is a TorqueHand, as a new one would.
  /// @throws std::invalid_argument if there is another hand, or beyond 100 N m
  void set_hand_torque(double torque_nm);

  /// Puts the plant into another state, its time included; the parts that the plant lacks are
  /// ignored.
  /// @throws std::invalid_argument if a value is not finite, or time or a capacity negative
  void set_state(const PlantState& state);

  /// Lets time pass.
  /// @param duration_ns >= 0
  /// @throws std::invalid_argument if it is negative or runs past the end of 64-bit time
  /// @throws the exception of a FeedbackHand's function, at the time when it was called. Time can
  /// go on from there, without a torque of the hand until the next call
  void advance(std::int64_t duration_ns);

  /// Its state, without its parts and its hand; not all of a plant with electrics.
  struct Memory {
    Command command;
    HeldInputs inputs;
    PlantState state;
    PlantState anchor;
    bool between;
    std::int64_t grid_ns;
    double coil_target_nm;
    std::int64_t coil_arrives_ns;
  };
  [[nodiscard]] Memory memory() const {
    return {command_, inputs_,  state_,          anchor_,
            between_, grid_ns_, coil_target_nm_, coil_arrives_ns_};
  }
  /// @param memory of a plant that was made in the same way and has the hand that it was made with
  void set_memory(const Memory& memory) {
    command_ = memory.command;
    inputs_ = memory.inputs;
    state_ = memory.state;
    anchor_ = memory.anchor;
    between_ = memory.between;
    grid_ns_ = memory.grid_ns;
    coil_target_nm_ = memory.coil_target_nm;
    coil_arrives_ns_ = memory.coil_arrives_ns;
  }

  [[nodiscard]] const PlantState& state() const { return state_; }
  [[nodiscard]] Truth truth() const { return emulator::truth(model_, state_, inputs_); }
  [[nodiscard]] const Command& command() const { return command_; }
  [[nodiscard]] const PlantParams& params() const { return params_; }

 private:
  void attach(Hand hand);
  void make_steppers(const Hand& hand);
  void refresh_hand_segment();
  void ask_hand(const FeedbackHand& hand);
  /// Goes on from where the plant is, whatever the grid: after every change of an input.
  void start_from_here();
  /// Whether the brake's torque follows its current with a play. With electrics the circuit has it.
  [[nodiscard]] bool plays() const { return params_.brake_hysteresis && !params_.electrics; }
  /// Where the brake's torque goes, and when its current will be at the end of the play.
  void follow_coil();
  /// By what share of its way to go the brake's current changes; <= 0.
  [[nodiscard]] double coil_share(std::int64_t duration_ns) const;
  void step_to(std::int64_t time_ns);
  /// A state with its rigid connections.
  void make_consistent();

  PlantParams params_;
  std::int64_t step_ns_;
  MakeStepper make_stepper_;
  Hand hand_ = NoHand{};
  PlantModel model_;
  std::shared_ptr<Stepper> stepper_;
  std::shared_ptr<Stepper> disconnected_;  // of a plant with electrics
  bool connected_ = true;
  Command command_;
  HeldInputs inputs_{};
  PlantState state_;              // now
  PlantState anchor_;             // where the step under way began, if between_ is set
  bool between_ = false;          // now is neither a grid time nor a change of inputs
  std::int64_t grid_ns_ = 0;      // the next grid time
  double coil_step_share_ = 0.0;  // of `step_ns_`: its exponential costs as much as the step
  double coil_target_nm_ = 0.0;
  std::int64_t coil_arrives_ns_ = Profile::kForeverNs;  // at the end of the play
};

}  // namespace torsio::emulator
