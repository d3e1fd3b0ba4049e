/// @file
/// A converted scene as the bytes that travel.
#pragma once

#include <vector>

#include "conversion/scene.hpp"
#include "protocol/codec.hpp"

namespace torsio::conversion {

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

EncodedScene encode(const ConvertedScene& scene);

}  // namespace torsio::conversion
