#include "scene_player.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "protocol/reports.hpp"
#include "torsio/error.hpp"

namespace torsio {

/// Takes the reports that differ from the device's. Until the commit is acknowledged nobody knows
/// which of them the device has written down.
std::vector<protocol::ReportBytes> ScenePlayer::take_differing(
    const conversion::EncodedScene& scene) {
  std::vector<protocol::ReportBytes> reports;
  // Points before the effects that read them.
  for (std::size_t i = 0; i < scene.pieces.size(); ++i) {
    if (pieces_.at(i) == scene.pieces[i]) continue;
    pieces_.at(i).reset();
    reports.push_back(scene.pieces[i]);
  }
  for (std::size_t i = 0; i < scene.slots.size(); ++i) {
    const conversion::EncodedScene::Slot& slot = scene.slots[i];
    const bool points_stay =
        std::all_of(pieces_.begin() + slot.first_piece, pieces_.begin() + slot.end_piece,
                    [](const auto& piece) { return piece.has_value(); });
    if (points_stay && slots_.at(i) == slot.report) continue;
    slots_.at(i).reset();
    reports.push_back(slot.report);
  }
  return reports;
}

void ScenePlayer::play(const conversion::EncodedScene& scene) {
  const std::lock_guard lock(mutex_);
  std::vector<protocol::ReportBytes> reports = take_differing(scene);
  requests_.exchange(reports);

  const auto active = static_cast<std::uint16_t>((1U << scene.slots.size()) - 1U);
  const protocol::Commit commit{0, 0, active};
  // Without an answer nobody knows which of the two plays.
  std::vector<protocol::ReportBytes> before = std::exchange(playing_, {});
  try {
    playing_from_tick_ = requests_.request(commit).tick;
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
  return link_.tap(with_telemetry, std::move(begin));
}

void ScenePlayer::forget_locked() {
  slots_.fill(std::nullopt);
  pieces_.fill(std::nullopt);
}

}  // namespace torsio
