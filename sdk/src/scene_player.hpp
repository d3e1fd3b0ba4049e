/// @file
/// Keeps the device's scene in step with the user's, with the fewest reports.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "conversion/scene_encoding.hpp"
#include "link.hpp"
#include "protocol/codec.hpp"
#include "protocol/effects.hpp"
#include "requests.hpp"

namespace torsio {

/// Remembers the device's scene and sends the differences. May be used from any thread.
class ScenePlayer {
 public:
  ScenePlayer(Link& link, Requests& requests) : link_(link), requests_(requests) {}

  /// Writes what differs, waits until the device has accepted all of it, and commits.
  /// @throws Refused, and as Requests::exchange() does; what plays goes on then
  void play(const conversion::EncodedScene& scene);

  /// The device may have lost what was written: the next play() writes everything.
  void forget();
  /// The same, and no scene plays any more.
  void forget_playing();

  /// See Knob::tap().
  [[nodiscard]] std::shared_ptr<ReportTap> tap(bool with_telemetry);

 private:
  static constexpr std::size_t kPieces =
      (protocol::curve_pool_points + protocol::curve_points_per_report - 1) /
      protocol::curve_points_per_report;

  std::vector<protocol::ReportBytes> take_differing(const conversion::EncodedScene& scene);
  void forget_locked();

  Link& link_;
  Requests& requests_;
  // Recursive: what interrupts a play() that waits, as the handler of a signal does, may stop().
  std::recursive_mutex mutex_;
  std::array<std::optional<protocol::ReportBytes>, protocol::max_effects> slots_;
  std::array<std::optional<protocol::ReportBytes>, kPieces> pieces_;
  std::vector<protocol::ReportBytes> playing_;  // all of the scene, and its commit
  std::uint64_t playing_from_tick_ = 0;
};

}  // namespace torsio
