#include "emulator/plant/params.hpp"

#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

#include "emulator/plant/ranges.hpp"

namespace torsio::emulator {
namespace {

void validate_parts(const PlantParams& params) {
  if (!params.spring_and_brake &&
      (params.shaft_hardening || params.brake_hysteresis || params.belt)) {
    throw std::invalid_argument(
        "plant: shaft_hardening, brake_hysteresis and belt need spring_and_brake");
  }
  if (params.shaft_hardening && params.shaft_stiffness_nm_per_rad == 0.0) {
    throw std::invalid_argument(
        "plant: shaft_stiffness_nm_per_rad is 0, so shaft_hardening has nothing to harden");
  }
  if (params.belt && params.belt->pulley_inertia_kg_m2 >= params.brake_inertia_kg_m2) {
    throw std::invalid_argument(
        "plant: belt.pulley_inertia_kg_m2 must be less than brake_inertia_kg_m2, which it is a "
        "share "
        "of");
  }
  if (params.cogging) {
    const std::size_t points = params.cogging->torque_nm.size();
    if (points < 2 || points > 64) {
      throw std::invalid_argument(
          "plant: the length of cogging.torque_nm must be from 2 to 64, is " +
          std::to_string(points));
    }
  }
}

}  // namespace

void require_within(double value, double low, double high, const std::string& name,
                    std::string_view unit) {
  // The comparisons are false for NaN.
  if (value >= low && value <= high && std::isfinite(value)) return;
  std::ostringstream text;
  text << name << " is " << value << ", allowed are " << low << " to " << high;
  if (!unit.empty()) text << " " << unit;
  throw std::invalid_argument(text.str());
}

Cogging sine_cogging(int periods_per_rev, double amplitude_nm, int points) {
  Cogging cogging{periods_per_rev, {}};
  for (int i = 0; i < points; ++i) {
    cogging.torque_nm.push_back(amplitude_nm * std::sin(2.0 * std::numbers::pi * i / points));
  }
  return cogging;
}

void validate(const PlantParams& params) {
  require_ranges(params, "plant: ");
  validate_parts(params);
}

}  // namespace torsio::emulator
