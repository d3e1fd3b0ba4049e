// A number that is not finite may come in anywhere. It never reaches an actuator and never stays.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "core/controller.hpp"

using namespace torsio;

namespace {

const std::vector<float> kNotFinite{std::numeric_limits<float>::quiet_NaN(),
                                    std::numeric_limits<float>::infinity(),
                                    -std::numeric_limits<float>::infinity()};

constexpr std::array<core::ShaftKnee, core::kMostKnees> kStraight{};

core::ControllerParams params(core::Law law) {
  core::ControllerParams params;
  params.motion = core::make_motion_params(core::make_resolution(8192, 1'000'000), 32, false, 100);
  params.brake = core::make_brake_params(0.06F, 1e-3F, 3.3e-3F, 0.0F);
  params.shaft = core::make_shaft_params(2.873F, kStraight, 0.0F, 1e-3F, 0.0F);
  params.partition = {law, 0.5F, 0.085F, 0.110F};
  return params;
}

core::Scene one(const core::Effect& effect) {
  core::Scene scene;
  scene.effect[0] = effect;
  scene.active = 1;
  return scene;
}

/// Plays the scene for 50 ticks of motion; every output must be finite and within its limit.
/// Afterwards, with a good scene, everything must be as if nothing had happened.
void check_contained(const core::Scene& scene, const core::LocalModel* local, float gain,
                     core::ForceSource* extra = nullptr) {
  core::Plan plan{{&scene, local, gain, extra}};
  plan.impacts = core::has_impacts(scene);
  for (const core::Law law :
       {core::Law::paper, core::Law::compensated, core::Law::parallel, core::Law::motor_only}) {
    const core::ControllerParams p = params(law);
    core::ControllerState state;
    core::ControllerState clean;
    std::uint32_t count = 0;
    for (int tick = 0; tick < 50; ++tick) {
      count += static_cast<std::uint32_t>(tick % 7);
      const auto out = core::control(state, p, plan, count);
      CHECK(core::is_finite(out.motor_command_nm));
      CHECK(core::is_finite(out.brake_command_nm));
      CHECK(core::is_finite(out.spring_torque_nm));
      CHECK(core::is_finite(out.desired_torque_nm));
      CHECK(core::absolute(out.motor_command_nm) <= 0.085F);
      CHECK(out.brake_command_nm >= 0.0F);
      CHECK(out.brake_command_nm <= 0.110F);
      // The device stops at the first of these.
      if (out.numeric_error) CHECK(out.motor_command_nm == 0.0F);
      (void)core::control(clean, p, {}, count);
    }
    state.brake = clean.brake;  // a finite scene may have used the brake
    state.sensor = clean.sensor;
    const core::Scene good = one(core::Constant{0.03F, {}});
    state.scene = {};
    const core::Plan plain = core::plan_of(p, state.bound, {&good});
    for (int tick = 0; tick < 20; ++tick) {
      const auto got = core::control(state, p, plain, ++count);
      CHECK(core::is_finite(got.motor_command_nm));
      CHECK_FALSE(got.numeric_error);
      CHECK(got.desired_torque_nm == 0.03F);
    }
  }
}

struct BadForce final : core::ForceSource {
  explicit BadForce(float value) : value_nm(value) {}
  float torque_nm(const core::Motion&, const core::Resolution&, std::uint64_t) override {
    return value_nm;
  }
  float value_nm;
};

}  // namespace

TEST_CASE("a scene that is not finite gives no torque, raises the flag and leaves no trace") {
  for (const float bad : kNotFinite) {
    CAPTURE(bad);
    const std::vector<core::Effect> effects{
        core::Wall{{}, 1.0F, bad, 0.0F},
        core::Wall{{-8000, 0}, -1.0F, 1.0F, bad},
        core::Spring{{}, bad, 0.0F, 1.0F},
        core::Spring{{}, 1.0F, bad, 1.0F},
        core::Spring{{}, 1.0F, 0.0F, bad},
        core::Damper{bad, 1.0F},
        core::Damper{1.0F, bad},
        core::Friction{bad, 0.1F},
        core::Friction{1.0F, bad},
        core::Inertia{bad, 1.0F},
        core::Inertia{1.0F, bad},
        core::Constant{bad, {}},
        core::Constant{0.1F, {.attack_ticks = 100, .attack_level = bad}},
        core::Constant{0.1F, {.attack_ticks = 100, .attack_rise_per_tick = bad}},
        core::Constant{0.1F, {.duration_ticks = 100, .fade_ticks = 100, .fade_level = bad}},
        core::Ramp{bad, 0.0F, {}},
        core::Ramp{0.0F, bad, {}},
        core::Periodic{core::Waveform::sine, bad, 0.0F, 1U << 28, 0, {}},
        core::Periodic{core::Waveform::sine, 0.1F, bad, 0, 0, {}},
        core::Detents{{}, bad, core::DetentProfile::sine, 4.0F},
        core::Detents{{{}, 1ULL << 60, 0}, 0.1F, core::DetentProfile::click, bad},
        core::Texture{1ULL << 51, 100, bad, core::Grain::noise, 0},
        // The knob comes in.
        core::Impact{.surface = {10, 0}, .strength_nm_s_per_rad = bad, .sine_ticks = 100},
        core::Impact{.surface = {10, 0}, .pulse_nm_s_per_rad = bad, .pulse_ticks = 100},
    };
    for (const core::Effect& effect : effects) check_contained(one(effect), nullptr, 1.0F);
  }
}

TEST_CASE("a local model or a gain that is not finite gives no torque and leaves no trace") {
  const core::Scene good = one(core::Constant{0.03F, {}});
  for (const float bad : kNotFinite) {
    CAPTURE(bad);
    const std::vector<core::LocalModel> models{
        {bad, {}, 0.0F, 0.0F}, {0.0F, {}, bad, 0.0F}, {0.0F, {}, 0.0F, bad}};
    for (const core::LocalModel& model : models) check_contained(good, &model, 1.0F);
    check_contained(good, nullptr, bad);
  }
}

TEST_CASE("a force from outside that is not finite gives no torque and leaves no trace") {
  for (const float bad : kNotFinite) {
    CAPTURE(bad);
    BadForce force(bad);
    check_contained(one(core::Constant{0.03F, {}}), nullptr, 1.0F, &force);
  }
}
