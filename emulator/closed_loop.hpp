/// @file
/// The device's controller, unchanged, in closed loop with the plant, without protocol, states and
/// cable between them: for studies of many runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/controller.hpp"
#include "emulator/closed_loop_options.hpp"
#include "emulator/encoder.hpp"
#include "emulator/plant/plant.hpp"
#include "emulator/power_path.hpp"
#include "emulator/replay.hpp"
#include "emulator/rows.hpp"

namespace torsio::emulator {

/// Controller, plant, encoder and hand under one virtual clock. The device around the controller is
/// left out: arming and its soft start, the watchdog, faults. A copy goes its own way, but shares
/// what Plant says.
class ClosedLoop {
 public:
  /// Does the spin-up too, if there is one.
  /// @throws std::invalid_argument that names what is out of its range
  /// @throws std::runtime_error if the spin-up does not reach its speed
  explicit ClosedLoop(const ClosedLoopOptions& options);

  /// Goes on for so many ticks. Allocates nothing.
  /// @param rows of the ticks 0, every, 2 every ... of this call, as far as there is room
  void run(std::uint64_t ticks, std::span<LoopRow> rows, std::uint32_t every = 1);

  /// The two halves of a tick, to be called in turns: the controller senses and decides, then time
  /// passes until the next tick. The caller may look or decide in between.
  /// @param row of this moment, or null
  void sense(LoopRow* row);
  void act();

  /// From now on the actuators get this in place of the law's output. The controller knows of it
  /// and goes on sensing, without a scene.
  /// @throws std::invalid_argument unless the motor's torque is within 100 N m and the brake's 0 to
  ///         100
  void hold_command(const Command& command);
  /// Ends hold_command().
  void release_command() { held_.reset(); }

  /// Another scene plays from the next tick on. An effect with the same place and values goes on;
  /// any other starts anew. Copies keep theirs.
  /// @param options scene and curves; nothing else is looked at
  /// @throws std::invalid_argument that names what is out of its range; the old scene goes on
  void set_scene(const ClosedLoopOptions& options);

  /// A host streams this from the next tick on, on top of the scene. No deadline ends it.
  /// @param model within what the protocol allows
  void stream(const protocol::LocalModel& model);

  /// Another hand takes over; times of its profiles are plant time.
  void set_hand(Hand hand) { plant_.set_hand(std::move(hand)); }
  /// As Plant's.
  void set_hand_torque(double torque_nm) { plant_.set_hand_torque(torque_nm); }
  /// The encoder's noise goes on as in a new loop with this seed.
  void set_seed(std::uint64_t seed);

  /// Appends its state, for restore(). Not for a plant with electrics.
  void save(std::vector<std::uint8_t>& into) const;
  /// Goes on from where the loop was that saved this: one with the same options, scene and stream.
  /// @returns the bytes that follow
  std::span<const std::uint8_t> restore(std::span<const std::uint8_t> from);

  [[nodiscard]] const Plant& plant() const { return plant_; }
  [[nodiscard]] const core::ControllerState& controller() const { return controller_; }
  [[nodiscard]] std::int64_t control_period_ns() const { return period_ns_; }

 private:
  struct Memory {
    core::ControllerState controller;
    Plant::Memory plant;
    Encoder encoder;
    std::optional<Command> held;
    Command decided;
    std::size_t next_late;
  };

  void spin_up(const SpinUp& spin_up);
  /// Lets a period pass in which the actuators follow.
  void follow(const Command& command);
  void take(const Command& command);

  std::int64_t period_ns_;
  std::shared_ptr<const ControlSetup> setup_;
  std::vector<EffectReport> effects_;  // of its scene
  std::optional<core::LocalModel> local_;
  core::ControllerState controller_;
  std::optional<PowerPath> power_;  // of a plant with electrics
  Plant plant_;
  Encoder encoder_;
  std::optional<Command> held_;
  Command decided_;            // by the last sense()
  std::vector<Command> late_;  // commands on their way to the actuators, a ring
  std::size_t next_late_ = 0;
};

}  // namespace torsio::emulator
