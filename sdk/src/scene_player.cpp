#include "scene_player.hpp"

#include <algorithm>
#include <cstdint>

#include "protocol/reports.hpp"
#include "torsio/error.hpp"

namespace torsio {

void ScenePlayer::play(const conversion::EncodedScene& scene) {
  const std::lock_guard lock(mutex_);
  std::vector<protocol::ReportBytes> reports;
  std::array<bool, kPieces> piece_differs{};
  std::array<bool, protocol::max_effects> slot_differs{};

  // Points before the effects that read them.
  for (std::size_t i = 0; i < scene.pieces.size(); ++i) {
    piece_differs.at(i) = pieces_.at(i) != scene.pieces[i];
    if (piece_differs.at(i)) reports.push_back(scene.pieces[i]);
  }
  for (std::size_t i = 0; i < scene.slots.size(); ++i) {
    const conversion::EncodedScene::Slot& slot = scene.slots[i];
    slot_differs.at(i) =
        slots_.at(i) != slot.report ||
        std::any_of(piece_differs.begin() + slot.first_piece,
                    piece_differs.begin() + slot.end_piece, [](bool differs) { return differs; });
    if (slot_differs.at(i)) reports.push_back(slot.report);
  }

  // Until the commit is acknowledged nobody knows what of this the device has written down.
  for (std::size_t i = 0; i < kPieces; ++i) {
    if (piece_differs.at(i)) pieces_.at(i).reset();
  }
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slot_differs.at(i)) slots_.at(i).reset();
  }
  for (const protocol::Acknowledgement& answer : session_.exchange(reports)) {
    session_.throw_if_refused(answer);
  }

  const auto active = static_cast<std::uint16_t>((1U << scene.slots.size()) - 1U);
  try {
    session_.request(protocol::Commit{0, 0, active});
  } catch (const Refused&) {
    forget_locked();  // the device has lost something: the next scene is written whole
    throw;
  }
  for (std::size_t i = 0; i < scene.pieces.size(); ++i) pieces_.at(i) = scene.pieces[i];
  for (std::size_t i = 0; i < scene.slots.size(); ++i) slots_.at(i) = scene.slots[i].report;
}

void ScenePlayer::forget() {
  const std::lock_guard lock(mutex_);
  forget_locked();
}

void ScenePlayer::forget_locked() {
  slots_.fill(std::nullopt);
  pieces_.fill(std::nullopt);
}

}  // namespace torsio
