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

void validate(const Hand& hand) { std::visit(Validator{}, hand); }

}  // namespace torsio::emulator
