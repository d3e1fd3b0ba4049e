// How strong conditions may be: the formulas of docs/reference/games.md, with the default actuator.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "device/game/game_rig.hpp"

using namespace torsio;
using namespace torsio::test;

namespace {

// ActuatorConfig, ControlConfig
constexpr double kInertiaKgM2 = 6e-5, kCoulombNm = 6e-3, kViscous = 2.6e-5, kMotorLagS = 44e-6;
constexpr double kBandwidthHz = 100;

double delay_s(double period_s) { return 1.5 * period_s + kMotorLagS; }

/// A knob with the strongest of a kind of condition, and one more as strong: the game's or the
/// player's own.
struct Strongest : GameRig {
  Strongest(std::uint32_t period_ns, int type, bool own = false) : GameRig(period_ns) {
    configure([type, own](protocol::GameConfig& config) {
      if (own && type == kDamper) config.own_damper_percent = 100;
      if (own && type == kInertia) config.own_inertia_percent = 100;
      config.range_deg = 10;
      config.spring_gain = 1000;
      config.speed_full_rad_s = 0.1F;
      config.acceleration_full_rad_s2 = 1;
    });
    play_condition(type, {});
    if (!own) play_condition(type, {});
    tick(2);
  }
  double torque_nm() const { return static_cast<double>(outputs.motor_command_nm); }
};

}  // namespace

TEST_CASE("all springs together are as stiff as the loop's delay and the encoder allow") {
  for (const double period_s : {1e-3, 1e-4, 5e-5}) {
    Strongest rig(static_cast<std::uint32_t>(std::lround(period_s * 1e9)), kSpring);
    rig.tick(static_cast<int>(std::lround(0.06 / period_s)));  // a spring comes up gently
    rig.turn(1, 3);
    // k tau = b + 4 f sqrt(k J) / (pi T), solved for sqrt(k).
    const double half =
        2 * kCoulombNm * std::sqrt(kInertiaKgM2) / (std::numbers::pi * GameRig::kFullNm);
    const double root = half + std::sqrt(half * half + kViscous * delay_s(period_s));
    const double stable = std::pow(root / delay_s(period_s), 2);
    const double most = std::min(stable, 2 * kCoulombNm / kCountRad);
    CHECK(rig.torque_nm() == about(-most * 3 * kCountRad));
  }
}

TEST_CASE("all dampers together are half as strong as their filter's delay allows") {
  for (const auto& [period_s, own] : {std::pair{1e-3, false}, {1e-4, false}, {1e-3, true}}) {
    Strongest rig(static_cast<std::uint32_t>(std::lround(period_s * 1e9)), kDamper, own);
    rig.turn(1, static_cast<int>(0.1 / period_s));
    const double theta = 2 / (2 * std::numbers::pi * kBandwidthHz) + delay_s(period_s);
    const double speed = kCountRad / period_s;
    const double torque = 0.5 * std::numbers::pi * kInertiaKgM2 / (2 * theta) * speed;
    CHECK(rig.torque_nm() == about(-std::min<double>(torque, GameRig::kFullNm), 0.01));
  }
}

TEST_CASE("all inertias together are half the knob's own") {
  for (const bool own : {false, true}) {
    Strongest rig(1'000'000, kInertia, own);
    double count = 0;
    double mean = 0;
    for (int i = 0; i < 400; ++i) {
      count += 0.25 * i;
      rig.inputs.encoder_count = static_cast<std::uint32_t>(std::lround(count));
      rig.tick();
      if (i >= 200) mean += rig.torque_nm() / 200;
    }
    const double acceleration = 0.25 * kCountRad / 1e-6;
    CHECK(mean == about(-0.5 * kInertiaKgM2 * acceleration, 0.02));
  }
}

TEST_CASE("friction's bristle is as stiff as a spring of its torque may be") {
  struct Case {
    double period_s;
    int frictions, coefficient;
    bool own;
    int gain = 32'767;
  };
  // At 20 kHz the encoder's counts allow less than the loop's delay does.
  for (const Case& c : {Case{1e-3, 1, 32'767, false},
                        {1e-3, 1, 20'000, false},
                        {1e-3, 2, 32'767, false},
                        {1e-3, 2, 32'767, true},
                        {1e-3, 1, 32'767, false, 20'000},
                        {5e-5, 1, 32'767, false},
                        {5e-5, 1, 20'000, false}}) {
    CAPTURE(c.period_s);
    CAPTURE(c.coefficient);
    GameRig rig(static_cast<std::uint32_t>(std::lround(c.period_s * 1e9)));
    if (c.own) rig.configure([](protocol::GameConfig& g) { g.own_friction_percent = 100; });
    GameRig::ConditionOptions options;
    options.positive = options.negative = c.coefficient;
    for (int i = c.own ? 1 : 0; i < c.frictions; ++i) {
      rig.set_effect(rig.play_condition(kFriction, options), {.gain = c.gain});
    }
    rig.tick(60);  // the player's own comes up gently
    rig.turn(1, 2);
    const double torque = c.frictions * static_cast<double>(GameRig::kFullNm) * c.coefficient /
                          32767 * c.gain / 32767;
    const double stable =
        kInertiaKgM2 *
        std::pow(4 * kCoulombNm / (std::numbers::pi * torque * delay_s(c.period_s)), 2);
    const double most = std::min(stable, 2 * kCoulombNm / kCountRad);
    CHECK(rig.outputs.motor_command_nm == about(-most * 2 * kCountRad));
  }
}

TEST_CASE(
    "an effect that a configuration prepares anew after its start blends as any change does") {
  GameRig rig;
  const auto with_most = [](float torque_max_nm) {
    protocol::GameConfig config;
    config.torque_max_nm = torque_max_nm;
    config.blend_s = 0.02F;
    return config;
  };
  REQUIRE(rig.set(with_most(0.08F)).ok());
  for (int block = 0; block < 4; ++block) rig.play_constant(2000);
  rig.device->service();  // the starts are on their way, and nothing is armed yet
  REQUIRE(rig.device->set_feature(protocol::encode(with_most(0.04F))).ok());
  // The starts come in one tick, newly prepared effects two ticks later.
  const std::vector<float> nm = rig.torques(60);
  const double first_nm = 4 * 0.08 * 2000 / 32767;
  CHECK(static_cast<double>(nm.back()) == about(first_nm / 2));
  for (std::size_t i = 1; i < nm.size(); ++i) {
    CAPTURE(i);
    CHECK(std::abs(nm[i] - nm[i - 1]) < 1.1 * first_nm / 20);  // a change takes 20 ticks
  }
}
