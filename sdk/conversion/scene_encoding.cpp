#include "conversion/scene_encoding.hpp"

#include <algorithm>
#include <type_traits>
#include <variant>

namespace torsio::conversion {
namespace {

constexpr std::size_t kPiece = protocol::curve_points_per_report;

EncodedScene::Slot encode_effect(const protocol::EffectReport& effect) {
  return std::visit(
      []<class Report>(const Report& report) {
        EncodedScene::Slot slot{protocol::encode(report)};
        if constexpr (std::is_same_v<Report, protocol::Curve>) {
          const std::size_t end = std::size_t{report.first_point} + report.points;
          slot.first_piece = report.first_point / kPiece;
          slot.end_piece = (end + kPiece - 1) / kPiece;
        }
        return slot;
      },
      effect);
}

}  // namespace

EncodedScene encode(const ConvertedScene& scene) {
  EncodedScene encoded;
  for (const protocol::EffectReport& effect : scene.effects) {
    encoded.slots.push_back(encode_effect(effect));
  }
  const std::vector<float>& pool = scene.curve_torque_nm;
  for (std::size_t first = 0; first < pool.size(); first += kPiece) {
    protocol::CurvePoints piece;
    const std::size_t count = std::min(pool.size() - first, kPiece);
    piece.first_point = static_cast<std::uint16_t>(first);
    piece.points = static_cast<std::uint8_t>(count);
    std::copy_n(pool.begin() + static_cast<std::ptrdiff_t>(first), count, piece.torque_nm.begin());
    encoded.pieces.push_back(protocol::encode(piece));
  }
  return encoded;
}

}  // namespace torsio::conversion
