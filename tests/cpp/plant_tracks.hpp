/// @file
/// Plants with every part, and what a stepper makes of them, to compare one with another.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "emulator/plant/plant.hpp"

namespace torsio::emulator::test {

/// Knob angle and spring torque once a millisecond, under commands that change every 10 ms.
struct Track {
  std::vector<double> angle_rad;
  std::vector<double> spring_nm;
};

inline Track track(const PlantParams& params, const Hand& hand, std::int64_t step_ns,
                   double motor_nm = 0.085, double brake_nm = 0.05,
                   const MakeStepper& make = make_exact_stepper) {
  Plant plant(params, hand, step_ns, make);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Track result;
  for (int ms = 0; ms < 400; ++ms) {
    if (ms % 10 == 0) {
      const double torque = motor_nm * uniform(random);
      plant.set_command({torque, brake_nm * std::abs(uniform(random))});
    }
    plant.advance(1'000'000);
    result.angle_rad.push_back(plant.state().knob_angle_rad());
    result.spring_nm.push_back(plant.truth().spring_torque_nm);
  }
  return result;
}

inline double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
}

inline double relative_error(const std::vector<double>& values,
                             const std::vector<double>& reference) {
  double error = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    error = std::max(error, std::abs(values[i] - reference[i]));
  }
  return error / largest(reference);
}

inline double relative_error(const Track& a, const Track& reference) {
  return std::max(relative_error(a.angle_rad, reference.angle_rad),
                  relative_error(a.spring_nm, reference.spring_nm));
}

struct Variant {
  const char* name;
  PlantParams params;
  Hand hand;
};

/// One plant for every part, and some with all of them.
inline std::vector<Variant> variants() {
  std::vector<Variant> result;
  const Hand hand = ImpedanceHand{1e-4, 1.0, 5e-3, Profile({{0, 0.0}, {200'000'000, 0.4}})};
  result.push_back({"plain", {}, NoHand{}});
  result.push_back({"torque hand", {}, TorqueHand{Profile({{0, 0.0}, {333'333'333, 0.06}})}});
  result.push_back({"impedance hand", {}, hand});
  result.push_back({"prescribed",
                    {},
                    PrescribedMotion{Profile(
                        {{0, 0.0}, {100'000'000, 0.3}, {150'500'000, 0.3}, {300'000'000, -0.2}})}});
  PlantParams params;
  params.spring_and_brake = false;
  result.push_back({"rigid", params, hand});
  params = {};
  params.shaft_hardening = ShaftHardening{0.008, 2.5};
  result.push_back({"hardening", params, hand});
  params = {};
  params.belt = Belt{};
  result.push_back({"belt", params, hand});
  params = {};
  params.cogging = sine_cogging(12, 3e-3, 8);
  result.push_back({"cogging", params, hand});
  params.belt = Belt{};
  params.shaft_hardening = ShaftHardening{0.008, 0.5};
  params.brake_hysteresis = BrakeHysteresis{};
  result.push_back({"all parts", params, hand});
  return result;
}

}  // namespace torsio::emulator::test
