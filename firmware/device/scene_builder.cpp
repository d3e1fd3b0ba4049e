#include "device/scene_builder.hpp"

#include <algorithm>
#include <variant>

namespace torsio::device {

void SceneBuilder::put(std::uint8_t slot, const core::Effect& effect) {
  draft().effect[slot] = effect;
  written_ = static_cast<std::uint16_t>(written_ | (1U << slot));
}

void SceneBuilder::put_points(std::uint16_t first_point, std::span<const float> torque_nm) {
  std::copy(torque_nm.begin(), torque_nm.end(), draft().curve_torque_nm.begin() + first_point);
}

void SceneBuilder::clear() {
  draft().effect.fill(core::Effect{});
  draft().active = 0;
  written_ = 0;
  active_ = 0;
}

protocol::Status SceneBuilder::commit(std::uint16_t active, Commit& commit) {
  core::Scene& scene = draft();
  for (std::uint8_t slot = 0; slot < core::kMaxEffects; ++slot) {
    const bool plays = (active >> slot & 1U) != 0;
    if (plays && std::holds_alternative<std::monostate>(scene.effect[slot])) {
      return protocol::Status::empty_slot;
    }
  }
  scene.active = 0;
  for (std::uint8_t slot = 0; slot < core::kMaxEffects; ++slot) {
    if ((active >> slot & 1U) != 0) scene.order[scene.active++] = slot;
  }
  commit = {&scene, static_cast<std::uint16_t>(active & (written_ | ~active_))};
  written_ = 0;
  active_ = active;
  committed_ = true;
  return protocol::Status::ok;
}

void SceneBuilder::taken() {
  if (!committed_) return;
  committed_ = false;
  const core::Scene& playing = draft();
  draft_ = static_cast<std::uint8_t>(1 - draft_);
  draft() = playing;
}

}  // namespace torsio::device
