/// @file
/// The scene that is being written, beside the one that plays.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/scene.hpp"
#include "protocol/status.hpp"

namespace torsio::device {

/// Two scenes: the control loop plays one while the main loop writes the other. A commit hands the
/// written one over. When the loop has it, `taken()` copies it, so the next commit may change a
/// single effect.
class SceneBuilder {
 public:
  void put(std::uint8_t slot, const core::Effect& effect);
  void put_points(std::uint16_t first_point, std::span<const float> torque_nm);

  /// Forgets every effect.
  void clear();

  /// Data that a commit hands over.
  struct Commit {
    const core::Scene* scene = nullptr;
    std::uint16_t fresh = 0;  // slots that begin anew
  };

  /// Finishes the written scene with the slots of `active` playing.
  /// @returns empty_slot if one of them was never written; nothing has changed then
  protocol::Status commit(std::uint16_t active, Commit& commit);

  /// The control loop plays the committed scene now, if there was one, and has let go of the other.
  void taken();

 private:
  core::Scene& draft() { return scenes_[draft_]; }

  std::array<core::Scene, 2> scenes_;
  std::uint8_t draft_ = 0;
  bool committed_ = false;     // and not taken yet
  std::uint16_t written_ = 0;  // since the last commit
  std::uint16_t active_ = 0;
};

}  // namespace torsio::device
