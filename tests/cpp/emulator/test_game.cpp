// A released knob with the strongest conditions that a game gets, against simulated physics.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <vector>

#include "emulator/emulated_device.hpp"

namespace {

namespace emulator = torsio::emulator;
namespace protocol = torsio::protocol;
using emulator::EmulatedDevice;

constexpr std::uint8_t kSpring = 8, kDamper = 9, kInertia = 10, kFriction = 11;
constexpr double kCountRad = 2 * std::numbers::pi / 8192;

void start_condition(EmulatedDevice& device, std::uint8_t type) {
  const std::vector<std::uint8_t> create{0x21, type, 0, 0};
  const std::vector<std::uint8_t> effect{0x11, 1,    type, 0xFF, 0xFF, 0, 0, 0, 0,
                                         0xFF, 0x7F, 0,    2,    0,    0, 0, 0, 0};
  const std::vector<std::uint8_t> condition{0x13, 1,    0,    0,    0,    0xFF, 0x7F, 0xFF,
                                            0x7F, 0xFF, 0x7F, 0xFF, 0x7F, 0,    0};
  const std::vector<std::uint8_t> start{0x1A, 1, 1, 1};
  REQUIRE(device.game_set_feature(create));
  REQUIRE(device.game_get_feature(0x22).at(1) == 1);
  CHECK(device.game_write(effect));
  CHECK(device.game_write(condition));
  CHECK(device.game_write(start));
}

/// Turns the knob by 0.4 rad, lets go with a push, and looks at the last half second of one and a
/// half.
/// @returns its motion from end to end, rad
double rest_rad(std::int64_t period_ns, std::uint8_t type, const protocol::ActuatorConfig& told) {
  emulator::EmulatedDeviceOptions options;
  options.control_period_ns = period_ns;
  options.given.actuator = told;
  options.given.control = protocol::ControlConfig{.law = protocol::Law::motor_only};
  options.given.game = protocol::GameConfig{.range_deg = 100,
                                            .spring_gain = 1000,
                                            .speed_full_rad_s = 0.1F,
                                            .acceleration_full_rad_s2 = 1};
  options.log_truth = true;
  using Knots = std::vector<emulator::ProfileKnot>;
  options.hand = emulator::PrescribedMotion{
      emulator::Profile(Knots{{0, 0.0}, {100'000'000, 0.4}, {150'000'000, 0.4}})};
  EmulatedDevice device(options);
  start_condition(device, type);
  device.advance(150'000'000);
  device.set_hand(emulator::TorqueHand{
      emulator::Profile(Knots{{150'000'000, 0.2}, {160'000'000, 0.2}, {160'000'000, 0.0}})});
  device.advance(1'000'000'000);
  (void)device.take_truth();
  device.advance(500'000'000);
  const auto truth = device.take_truth();
  const auto [low, high] = std::ranges::minmax(truth, {}, &torsio::TruthSample::angle_rad);
  return high.angle_rad - low.angle_rad;
}

}  // namespace

TEST_CASE("a released knob comes to rest at the strongest conditions that a game gets") {
  for (const std::int64_t period_ns : {1'000'000, 100'000}) {
    for (const std::uint8_t type : {kSpring, kDamper, kInertia, kFriction}) {
      CAPTURE(period_ns);
      CAPTURE(type);
      CHECK(rest_rad(period_ns, type, {}) < kCountRad);
    }
  }
}

TEST_CASE("without the limit a released knob oscillates") {
  // A device that was told of inertia and friction which are not there sets its limit too high.
  protocol::ActuatorConfig told;
  told.knob_inertia_kg_m2 = 1e-2F;
  told.knob_coulomb_nm = 0.1F;
  for (const std::int64_t period_ns : {1'000'000, 100'000}) {
    for (const std::uint8_t type : {kSpring, kDamper}) {
      CAPTURE(period_ns);
      CAPTURE(type);
      CHECK(rest_rad(period_ns, type, told) > 5 * kCountRad);
    }
  }
}
