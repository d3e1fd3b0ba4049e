/// @file
/// Many closed loops that go on together, each by itself as it would alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "emulator/closed_loop.hpp"
#include "emulator/workers.hpp"

namespace torsio::emulator {

/// Inputs of a loop until the next step.
struct BatchAction {
  double hand_torque_nm = 0.0;    ///< of the hand on the knob; within 100 N m
  double motor_command_nm = 0.0;  ///< in place of the law's; within 100 N m
  double brake_command_nm = 0.0;  ///< in place of the law's; 0 to 100
};

struct BatchOptions {
  /// The different loops that there are; without a spin-up.
  std::vector<ClosedLoopOptions> kinds{};
  /// For each loop the index of its kind, and its seed in place of the kind's.
  std::vector<std::uint32_t> kind_of{};
  std::vector<std::uint64_t> seeds{};
  unsigned threads = 1;    ///< at least 1
  bool acts_hand = false;  ///< the actions' hand_torque_nm is the hand, which is a TorqueHand then
  bool acts_commands = false;  ///< the actions' commands go to the actuators; the law only senses
};

/// Thousands of closed loops. A loop depends on nothing but its kind, its seed and its actions. It
/// does the same to the bit as a ClosedLoop of its own, for any number of threads.
///
/// Threads take the loops in shares. Loops of one kind share the tables of their steps within a
/// share. So memory grows with the kinds, not with the loops.
class Batch {
 public:
  /// @throws std::invalid_argument that names what is out of its range
  explicit Batch(BatchOptions options);

  /// Lets `ticks` control periods pass under the present actions; then every state is of now.
  /// @param goes_on the next part of a step that is cut in parts: who failed in an earlier one does
  ///                not go on
  /// @throws std::runtime_error or std::invalid_argument that names the first loop which cannot go
  ///         on; the others have
  void step(std::uint64_t ticks, bool goes_on = false);

  /// Begins some loops anew.
  /// @param seeds as many as loops; one loop may not stand in the list twice
  /// @throws std::invalid_argument as the constructor does; nothing is changed then
  void reset(std::span<const std::uint32_t> loops, std::span<const std::uint64_t> seeds);

  /// All that the loops remember, with states and actions, for restore() by the same program.
  /// @throws std::invalid_argument of a plant with electrics
  [[nodiscard]] std::vector<std::uint8_t> save() const;
  /// Goes on from where the batch was that saved this, as if it had never been away.
  /// @throws std::invalid_argument if it is of other loops; nothing is changed then
  void restore(std::span<const std::uint8_t> from);

  [[nodiscard]] std::size_t size() const { return loops_.size(); }
  /// One a loop: what ClosedLoop::run would write as the row of this moment.
  [[nodiscard]] std::span<LoopRow> states() { return states_; }
  [[nodiscard]] std::span<BatchAction> actions() { return actions_; }

 private:
  struct Share {
    std::size_t begin;
    std::size_t end;
  };

  [[nodiscard]] Share share(unsigned number) const;
  [[nodiscard]] ClosedLoop made(std::size_t loop, std::uint64_t seed) const;
  void step_one(std::size_t loop, std::uint64_t ticks);

  BatchOptions options_;
  unsigned shares_;
  std::vector<ClosedLoop> begins_;     // one a share and kind, never stepped
  std::vector<std::size_t> begin_of_;  // each loop's
  std::vector<ClosedLoop> loops_;
  std::vector<LoopRow> states_;
  std::vector<BatchAction> actions_;
  std::vector<std::uint8_t> failed_;  // in this step; bytes, which threads may write side by side
  Workers workers_;
};

}  // namespace torsio::emulator
