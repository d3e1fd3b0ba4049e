/// @file
/// From the scene that the user wrote to the reports that travel.
#pragma once

#include <vector>

#include "protocol/codec.hpp"
#include "protocol/reports.hpp"
#include "torsio/scene.hpp"

namespace torsio {

/// A scene as reports, with sequence numbers of 0.
struct EncodedScene {
  struct Slot {
    protocol::ReportBytes report;
    // The pieces of the pool of curve points that this effect reads: [first, end).
    std::size_t first_piece = 0;
    std::size_t end_piece = 0;
  };
  std::vector<Slot> slots;                    // one per effect, in order
  std::vector<protocol::ReportBytes> pieces;  // of the pool, from its beginning
};

/// @throws InvalidArgument that names the effect, the field, its value and its range
EncodedScene encode_scene(const Scene& scene, const protocol::Identity& device);

/// @throws InvalidArgument as above
protocol::ReportBytes encode_local_model(const LocalModel& model);

}  // namespace torsio
