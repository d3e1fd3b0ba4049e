#include "emulator/plant/hand.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace torsio::emulator {
namespace {

// Far beyond any hand and any knob, and far within what the plant can compute.
constexpr double kMostTorqueNm = 100.0;
constexpr double kMostAngleRad = 1e9;
constexpr double kMostSpeedRadS = 1e5;
constexpr double kMostInertiaKgM2 = 10.0;
constexpr double kMostStiffnessNmPerRad = 1e6;
constexpr double kMostDampingNmSPerRad = 1e3;

[[noreturn]] void refuse(const std::string& what, double value, double low, double high,
                         const char* unit) {
  std::ostringstream text;
  text << "hand: " << what << " is " << value << ", allowed are " << low << " to " << high << " "
       << unit;
  throw std::invalid_argument(text.str());
}

void require_amount(double value, const char* field, double most, const char* unit) {
  // False for NaN.
  if (!(value >= 0.0 && value <= most)) refuse(field, value, 0.0, most, unit);
}

void require_within(const Profile& profile, const char* field, double most, const char* unit) {
  for (const ProfileKnot& knot : profile.knots()) {
    if (!(std::abs(knot.value) <= most)) refuse(field, knot.value, -most, most, unit);
  }
}

void require_path(const Profile& path, const char* field) {
  require_within(path, field, kMostAngleRad, "rad");
  for (const ProfileKnot& knot : path.knots()) {
    const double speed_rad_s = path.slope_per_s(knot.time_ns);
    if (!(std::abs(speed_rad_s) <= kMostSpeedRadS)) {
      refuse(std::string("the speed along ") + field, speed_rad_s, -kMostSpeedRadS, kMostSpeedRadS,
             "rad/s");
    }
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
  void operator()(const TorqueHand& hand) const {
    require_within(hand.torque_nm, "torque_nm", kMostTorqueNm, "N m");
  }
  void operator()(const ImpedanceHand& hand) const {
    require_amount(hand.inertia_kg_m2, "inertia_kg_m2", kMostInertiaKgM2, "kg m^2");
    require_amount(hand.stiffness_nm_per_rad, "stiffness_nm_per_rad", kMostStiffnessNmPerRad,
                   "N m/rad");
    require_amount(hand.damping_nm_s_per_rad, "damping_nm_s_per_rad", kMostDampingNmSPerRad,
                   "N m s/rad");
    require_continuous(hand.intended_angle_rad, "intended_angle_rad");
    require_path(hand.intended_angle_rad, "intended_angle_rad");
  }
  void operator()(const PrescribedMotion& hand) const {
    require_continuous(hand.angle_rad, "angle_rad");
    require_path(hand.angle_rad, "angle_rad");
  }
};

}  // namespace

Hand take_hold(const torsio::Hand& hand, std::int64_t start_ns) {
  return std::visit(Holder{start_ns}, hand);
}

void validate(const Hand& hand) { std::visit(Validator{}, hand); }

}  // namespace torsio::emulator
