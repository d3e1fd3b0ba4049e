#include "emulator/plant/hand.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "emulator/plant/ranges.hpp"

namespace torsio::emulator {
namespace {

void require_path(const Profile& path, const char* field) {
  if (!path.is_continuous()) {
    throw std::invalid_argument(std::string("hand: ") + field +
                                " must be continuous: a hand cannot jump");
  }
  for (const ProfileKnot& knot : path.knots()) {
    require_within(path.slope_per_s(knot.time_ns), -kMostSpeedRadS, kMostSpeedRadS,
                   std::string("hand: the speed along ") + field, "rad/s");
  }
}

/// Profiles of the user's in the plant's time.
struct Holder {
  std::int64_t start_ns;

  Hand operator()(const torsio::NoHand&) const { return NoHand{}; }
  Hand operator()(const torsio::TorqueHand& hand) const {
    return TorqueHand{Profile(hand.torque_nm, start_ns, "torque_nm")};
  }
  Hand operator()(const torsio::ImpedanceHand& hand) const {
    return ImpedanceHand{hand.inertia_kg_m2, hand.stiffness_nm_per_rad, hand.damping_nm_s_per_rad,
                         Profile(hand.intended_angle_rad, start_ns, "intended_angle_rad")};
  }
  Hand operator()(const torsio::PrescribedMotion& hand) const {
    return PrescribedMotion{Profile(hand.angle_rad, start_ns, "angle_rad")};
  }
  Hand operator()(const torsio::FeedbackHand& hand) const {
    require_as(&torsio::FeedbackHand::period_s, hand.period_s, "hand: ");
    return FeedbackHand{hand.torque_nm, std::llround(1e9 * hand.period_s), start_ns};
  }
};

struct Validator {
  void operator()(const NoHand&) const {}
  void operator()(const TorqueHand& hand) const {
    require_as(&torsio::TorqueHand::torque_nm, hand.torque_nm, "hand: ");
  }
  void operator()(const ImpedanceHand& hand) const {
    using Listed = torsio::ImpedanceHand;
    require_as(&Listed::inertia_kg_m2, hand.inertia_kg_m2, "hand: ");
    require_as(&Listed::stiffness_nm_per_rad, hand.stiffness_nm_per_rad, "hand: ");
    require_as(&Listed::damping_nm_s_per_rad, hand.damping_nm_s_per_rad, "hand: ");
    require_as(&Listed::intended_angle_rad, hand.intended_angle_rad, "hand: ");
    require_path(hand.intended_angle_rad, "intended_angle_rad");
  }
  void operator()(const PrescribedMotion& hand) const {
    require_as(&torsio::PrescribedMotion::angle_rad, hand.angle_rad, "hand: ");
    require_path(hand.angle_rad, "angle_rad");
  }
  void operator()(const FeedbackHand& hand) const {
    if (!hand.torque_nm) throw std::invalid_argument("hand: torque_nm must be a function");
    if (hand.period_ns <= 0) throw std::invalid_argument("hand: period_ns must be > 0");
  }
};

}  // namespace

Hand take_hold(const torsio::Hand& hand, std::int64_t start_ns) {
  return std::visit(Holder{start_ns}, hand);
}

void validate(const Hand& hand) { std::visit(Validator{}, hand); }

}  // namespace torsio::emulator
