#include "emulator/plant/hand.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace torsio::emulator {
namespace {

void require_not_negative(double value, const char* field) {
  if (!std::isfinite(value) || value < 0.0) {
    throw std::invalid_argument(std::string("hand: ") + field + " must be finite and >= 0, is " +
                                std::to_string(value));
  }
}

void require_continuous(const Profile& path, const char* field) {
  if (!path.is_continuous()) {
    throw std::invalid_argument(std::string("hand: ") + field +
                                " must be continuous: a hand cannot jump");
  }
}

/// Profiles of the user's in the plant's time.
struct Holder {
  std::int64_t start_ns;

  Hand operator()(const torsio::NoHand&) const { return NoHand{}; }
  Hand operator()(const torsio::TorqueHand& hand) const {
    return TorqueHand{Profile(hand.torque_nm, start_ns)};
  }
  Hand operator()(const torsio::ImpedanceHand& hand) const {
    return ImpedanceHand{hand.inertia_kg_m2, hand.stiffness_nm_per_rad, hand.damping_nm_s_per_rad,
                         Profile(hand.intended_angle_rad, start_ns)};
  }
  Hand operator()(const torsio::PrescribedMotion& hand) const {
    return PrescribedMotion{Profile(hand.angle_rad, start_ns)};
  }
};

struct Validator {
  void operator()(const NoHand&) const {}
  void operator()(const TorqueHand&) const {}
  void operator()(const ImpedanceHand& hand) const {
    require_not_negative(hand.inertia_kg_m2, "inertia_kg_m2");
    require_not_negative(hand.stiffness_nm_per_rad, "stiffness_nm_per_rad");
    require_not_negative(hand.damping_nm_s_per_rad, "damping_nm_s_per_rad");
    require_continuous(hand.intended_angle_rad, "intended_angle_rad");
  }
  void operator()(const PrescribedMotion& hand) const {
    require_continuous(hand.angle_rad, "angle_rad");
  }
};

}  // namespace

Hand take_hold(const torsio::Hand& hand, std::int64_t start_ns) {
  return std::visit(Holder{start_ns}, hand);
}

void validate(const Hand& hand) { std::visit(Validator{}, hand); }

}  // namespace torsio::emulator
