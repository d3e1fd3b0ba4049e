#include "scene_player.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

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
  for (std::size_t i = 0; i < scene.pieces.size(); ++i) {
    if (piece_differs.at(i)) pieces_.at(i).reset();
  }
  for (std::size_t i = 0; i < scene.slots.size(); ++i) {
    if (slot_differs.at(i)) slots_.at(i).reset();
  }
  for (const protocol::Acknowledgement& answer : session_.exchange(reports)) {
    session_.throw_if_refused(answer);
  }

  const auto active = static_cast<std::uint16_t>((1U << scene.slots.size()) - 1U);
  const protocol::Commit commit{0, 0, active};
  // Without an answer nobody knows which of the two plays.
  std::vector<protocol::ReportBytes> before = std::exchange(playing_, {});
  try {
    playing_from_tick_ = session_.request(commit).tick;
  } catch (const Refused&) {
    playing_ = std::move(before);
    forget_locked();  // the device has lost something: the next scene is written whole
    throw;
  }
  for (std::size_t i = 0; i < scene.pieces.size(); ++i) pieces_.at(i) = scene.pieces[i];
  for (std::size_t i = 0; i < scene.slots.size(); ++i) slots_.at(i) = scene.slots[i].report;
  playing_ = scene.pieces;
  for (const conversion::EncodedScene::Slot& slot : scene.slots) playing_.push_back(slot.report);
  playing_.push_back(protocol::encode(commit));
}

void ScenePlayer::forget() {
  const std::lock_guard lock(mutex_);
  forget_locked();
}

void ScenePlayer::forget_playing() {
  const std::lock_guard lock(mutex_);
  forget_locked();
  playing_.clear();
}

std::shared_ptr<ReportTap> ScenePlayer::tap(bool with_telemetry) {
  const std::lock_guard lock(mutex_);  // a scene is in it, or is still to travel
  std::vector<LoggedReport> begin;
  // The device takes one in a tick.
  std::uint64_t ticks_before = playing_.size();
  for (const protocol::ReportBytes& report : playing_) {
    begin.push_back(
        {playing_from_tick_ - std::min(playing_from_tick_, ticks_before), true, report});
    --ticks_before;
  }
  return session_.tap(with_telemetry, std::move(begin));
}

void ScenePlayer::forget_locked() {
  slots_.fill(std::nullopt);
  pieces_.fill(std::nullopt);
}

}  // namespace torsio
