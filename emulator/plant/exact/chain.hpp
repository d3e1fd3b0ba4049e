/// @file
/// The plant as a linear system between two friction events, for one to three shafts.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "emulator/plant/model.hpp"

namespace torsio::emulator {

/// Friction on a shaft: it holds the shaft, or works against its motion in one direction.
enum class Slip : int { backward = -1, held = 0, forward = 1 };

constexpr double sign_of(Slip slip) { return static_cast<double>(static_cast<int>(slip)); }

constexpr Slip direction_of(double value) { return value > 0.0 ? Slip::forward : Slip::backward; }

/// The laws that hold between two events: the plant is linear while they stay.
struct Regime {
  Slip knob = Slip::held;  ///< a knob on a prescribed path counts as held
  Slip brake = Slip::held;
  int spring_piece = 0;  ///< of PlantModel::shaft_spring
  CoggingPiece cogging{};
};

/// The plant as one linear system z' = M z per regime, for 1, 2 or 3 shafts in a row. The drives
/// are in the state too. So inputs that are constant, straight lines or exponentials over time need
/// only the exponential of M.
template <int kShafts>
struct Chain {
  static constexpr std::size_t kSprings = kShafts - 1;
  // Moving parts:
  static constexpr std::size_t kSpeed = 0;  ///< of each shaft, rad/s
  static constexpr std::size_t kLast = kSpeed + kShafts - 1;
  static constexpr std::size_t kTwist =
      kLast + 1;  ///< of each spring, rad; the first from its rest
  static constexpr std::size_t kTravel =
      kTwist + kSprings;  ///< of the knob since the begin of the step, rad
  static constexpr std::size_t kMoving = kTravel + 1;
  // Driving torques, first those that vary ...
  static constexpr std::size_t kMotorGap = kMoving;     ///< motor torque less its command, N m
  static constexpr std::size_t kForce = kMotorGap + 1;  ///< command, hand, cogging on the knob, N m
  static constexpr std::size_t kBrakeGap = kForce + 1;  ///< capacity less its target, N m
  static constexpr std::size_t kVarying = kShafts > 1 ? kBrakeGap + 1 : kForce + 1;
  // ... and then what is constant:
  static constexpr std::size_t kSlope = kVarying;         ///< of the hand's force, N m/s
  static constexpr std::size_t kCoulomb = kSlope + 1;     ///< friction of the knob, N m
  static constexpr std::size_t kCapacity = kCoulomb + 1;  ///< target and drag of the brake, N m
  static constexpr std::size_t kSize = kShafts > 1 ? kCapacity + 1 : kCoulomb + 1;

  using Vector = std::array<double, kSize>;

  // Drives: what every change of the state comes from. At rest, in balance and with lags that have
  // died away all of them are 0, however large the torques that hold each other.
  static constexpr std::size_t kNet = 0;  ///< torque on each shaft, N m
  static constexpr std::size_t kNetLast = kNet + kShafts - 1;
  static constexpr std::size_t kTwisting = kNetLast + 1;         ///< of each spring, rad/s
  static constexpr std::size_t kForcing = kTwisting + kSprings;  ///< rate of kForce, N m/s
  static constexpr std::size_t kMotorDrive = kForcing + 1;       ///< kMotorGap and back EMF, N m
  static constexpr std::size_t kBrakeDrive = kMotorDrive + 1;    ///< kBrakeGap, N m
  static constexpr std::size_t kDrives = kShafts > 1 ? kBrakeDrive + 1 : kMotorDrive + 1;

  using Drives = std::array<double, kDrives>;

  explicit Chain(const PlantModel& model_in)
      : model(model_in),
        motor_rate(model.motor_time_constant_s > 0.0 ? 1.0 / model.motor_time_constant_s : 0.0),
        brake_rate(model.brake_time_constant_s > 0.0 ? 1.0 / model.brake_time_constant_s : 0.0),
        back_emf(model.back_emf_nm_s_per_rad),
        hand_stiffness(model.hand_stiffness_nm_per_rad) {
    for (std::size_t i = 0; i < kShafts; ++i) {
      mobility[i] = 1.0 / model.inertia_kg_m2[i];
      viscous[i] = model.viscous_nm_s_per_rad[i];
    }
    for (std::size_t i = 0; i < kSprings; ++i) damping[i] = model.damping_nm_s_per_rad[i];
    for (std::size_t i = 0; i < model.shaft_spring.size(); ++i) {
      shaft_stiffness[i] = model.shaft_spring[i].stiffness_nm_per_rad;
    }
  }

  const PlantModel& model;
  double motor_rate;  ///< 1/s; 0 when there is no lag, as the gap is 0 then
  double brake_rate;
  double back_emf;                         ///< N m s/rad; 0 without electrics
  std::array<double, kShafts> mobility{};  ///< 1 / inertia
  // Copies of the model's, which are at hand where most of the time is spent:
  std::array<double, kShafts> viscous{};    ///< N m s/rad
  std::array<double, kSprings> damping{};   ///< N m s/rad
  std::array<double, 3> shaft_stiffness{};  ///< of each piece, N m/rad
  double hand_stiffness;                    ///< N m/rad

  [[nodiscard]] double stiffness(std::size_t spring, const Regime& regime) const {
    if (spring > 0) return model.belt_stiffness_nm_per_rad;
    return shaft_stiffness[static_cast<std::size_t>(regime.spring_piece)];
  }

  /// Torque that a spring, its damping included, passes on to the shaft after it.
  [[nodiscard]] double link(const Vector& z, std::size_t spring, const Regime& regime) const {
    return stiffness(spring, regime) * z[kTwist + spring] +
           damping[spring] * (z[kSpeed + spring] - z[kSpeed + spring + 1]);
  }

  /// All torque on the knob but its Coulomb friction.
  [[nodiscard]] double knob_demand(const Vector& z, const Regime& regime) const {
    double torque = z[kForce] + z[kMotorGap] - viscous[0] * z[kSpeed];
    if constexpr (kShafts > 1) torque -= link(z, 0, regime);
    return torque;
  }

  /// All torque on the last shaft but the brake's.
  [[nodiscard]] double brake_demand(const Vector& z, const Regime& regime) const
    requires(kShafts > 1)
  {
    return link(z, kSprings - 1, regime) - viscous[kShafts - 1] * z[kLast];
  }

  [[nodiscard]] double capacity(const Vector& z) const
    requires(kShafts > 1)
  {
    return z[kCapacity] + z[kBrakeGap];
  }

  /// Torque that accelerates the knob, or that friction takes up while it holds the knob, ...
  [[nodiscard]] double knob_net(const Vector& z, const Regime& regime) const {
    return knob_demand(z, regime) - sign_of(regime.knob) * z[kCoulomb];
  }

  /// ... and the same of the last shaft.
  [[nodiscard]] double brake_net(const Vector& z, const Regime& regime) const
    requires(kShafts > 1)
  {
    return brake_demand(z, regime) - sign_of(regime.brake) * capacity(z);
  }

  [[nodiscard]] Drives drives(const Vector& z, const Regime& regime) const {
    Drives drive{};
    if (regime.knob != Slip::held) drive[kNet] = knob_net(z, regime);
    for (std::size_t i = 0; i < kSprings; ++i) {
      drive[kTwisting + i] = z[kSpeed + i] - z[kSpeed + i + 1];
    }
    if constexpr (kShafts > 2) {
      drive[kNet + 1] = link(z, 0, regime) - link(z, 1, regime) - viscous[1] * z[kSpeed + 1];
    }
    if constexpr (kShafts > 1) {
      if (regime.brake != Slip::held) drive[kNetLast] = brake_net(z, regime);
      drive[kBrakeDrive] = z[kBrakeGap];
    }
    drive[kForcing] = z[kSlope] - knob_stiffness(regime) * z[kSpeed];
    drive[kMotorDrive] = z[kMotorGap] + back_emf * z[kSpeed];
    return drive;
  }

  /// The rates of the state that one unit of a drive makes; the knob's travel is not counted.
  [[nodiscard]] Vector rates_of(std::size_t drive) const {
    Vector rate{};
    if (drive <= kNetLast) rate[kSpeed + drive] = mobility[drive];
    if (drive >= kTwisting && drive < kForcing) rate[kTwist + drive - kTwisting] = 1.0;
    if (drive == kForcing) rate[kForce] = 1.0;
    if (drive == kMotorDrive) rate[kMotorGap] = -motor_rate;
    if constexpr (kShafts > 1) {
      if (drive == kBrakeDrive) rate[kBrakeGap] = -brake_rate;
    }
    return rate;
  }

  /// M z.
  [[nodiscard]] Vector rates(const Vector& z, const Regime& regime) const {
    const Drives drive = drives(z, regime);
    Vector rate{};
    for (std::size_t i = 0; i < kShafts; ++i) rate[kSpeed + i] = drive[kNet + i] * mobility[i];
    for (std::size_t i = 0; i < kSprings; ++i) rate[kTwist + i] = drive[kTwisting + i];
    rate[kTravel] = z[kSpeed];
    rate[kMotorGap] = -motor_rate * drive[kMotorDrive];
    rate[kForce] = drive[kForcing];
    if constexpr (kShafts > 1) rate[kBrakeGap] = -brake_rate * drive[kBrakeDrive];
    return rate;
  }

  /// Stiffness of everything that ties the knob to the ground.
  [[nodiscard]] double knob_stiffness(const Regime& regime) const {
    return hand_stiffness - regime.cogging.slope_nm_per_rad;
  }

  /// An upper bound, of the right size, of how fast anything oscillates, rad/s, ...
  [[nodiscard]] double fastest_oscillation() const {
    double steepest = model.hand_stiffness_nm_per_rad;
    for (std::size_t i = 0; i < model.cogging_nm.size(); ++i) {
      const double rise = model.cogging_nm[(i + 1) % model.cogging_nm.size()] - model.cogging_nm[i];
      const double width = model.cogging_period_rad / static_cast<double>(model.cogging_nm.size());
      steepest = std::max(steepest, model.hand_stiffness_nm_per_rad + std::abs(rise) / width);
    }
    double sum = (steepest + motor_rate * back_emf) * mobility[0];
    for (std::size_t i = 0; i < kSprings; ++i) {
      double stiffest = model.belt_stiffness_nm_per_rad;
      if (i == 0) {
        stiffest = 0.0;
        for (const SpringPiece& piece : model.shaft_spring) {
          stiffest = std::max(stiffest, piece.stiffness_nm_per_rad);
        }
      }
      sum += stiffest * (mobility[i] + mobility[i + 1]);
    }
    return std::sqrt(sum);
  }

  /// ... or decays, 1/s.
  [[nodiscard]] double fastest_decay() const {
    double sum = motor_rate + brake_rate;
    for (std::size_t i = 0; i < kShafts; ++i) {
      sum += model.viscous_nm_s_per_rad[i] * mobility[i];
    }
    for (std::size_t i = 0; i < kSprings; ++i) {
      sum += model.damping_nm_s_per_rad[i] * (mobility[i] + mobility[i + 1]);
    }
    return sum;
  }
};

}  // namespace torsio::emulator
