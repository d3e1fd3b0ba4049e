#include "core/soft_sensor.hpp"

namespace torsio::core {
namespace {

/// @param place 0 is the middle; negative ones are for negative torques
ShaftPiece piece_at(const ShaftParams& shaft, int place) {
  if (place >= 0) return shaft.piece[static_cast<std::size_t>(place)];
  ShaftPiece piece = shaft.piece[static_cast<std::size_t>(-place)];
  piece.offset_nm = -piece.offset_nm;
  const float high_nm = -piece.low_nm;
  piece.low_nm = -piece.high_nm;
  piece.high_nm = high_nm;
  return piece;
}

int place_of(const ShaftParams& shaft, float torque_nm) {
  int place = 0;
  while (absolute(torque_nm) > shaft.piece[static_cast<std::size_t>(place)].high_nm) ++place;
  return torque_nm < 0.0F ? -place : place;
}

}  // namespace

/// Take the spring's present piece for a straight line without end. A tick then ends on that piece,
/// or beyond the border that the true curve crosses too. So the next piece's line is tried, which
/// begins at the same wind; all lines grow, so it ends.
float cross_knees(SoftSensorState& state, const ShaftParams& shaft, float delta_rad,
                  float capacity_nm, bool driven) {
  const SoftSensorState before = state;
  const int start = place_of(shaft, before.spring_torque_nm);
  const ShaftPiece from = piece_at(shaft, start);
  const bool springs = from.stiffness_nm_per_rad > 0.0F;
  const float wind_rad =
      springs ? (before.spring_torque_nm - from.offset_nm) / from.stiffness_nm_per_rad : 0.0F;
  const float slipped_rad = before.piece.stiffness_nm_per_rad > 0.0F
                                ? before.slipped_nm / before.piece.stiffness_nm_per_rad
                                : 0.0F;
  int place = start;
  // Where rounding says that it is beyond the border from either side, either will do.
  for (int steps = 0; steps <= 2 * kMostKnees; ++steps) {
    state.piece = piece_at(shaft, place);
    const ShaftPiece& piece = state.piece;
    state.spring_torque_nm = place == start
                                 ? before.spring_torque_nm
                                 : piece.offset_nm + piece.stiffness_nm_per_rad * wind_rad;
    state.slipped_nm = piece.stiffness_nm_per_rad * slipped_rad;
    (void)(driven ? sense_piece<true>(state, piece, delta_rad, capacity_nm)
                  : sense_piece<false>(state, piece, delta_rad, capacity_nm));
    if (state.spring_torque_nm < piece.low_nm) {
      --place;
    } else if (state.spring_torque_nm > piece.high_nm) {
      ++place;
    } else {
      break;
    }
  }
  return state.spring_torque_nm;
}

}  // namespace torsio::core
