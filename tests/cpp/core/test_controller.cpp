#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>

#include "core/controller.hpp"

namespace core = torsio::core;
using doctest::Approx;

namespace {

constexpr std::array<core::ShaftKnee, core::kMostKnees> kStraight{};

core::ControllerParams reference_actuator() {
  core::ControllerParams params;
  params.motion = core::make_motion_params(core::make_resolution(8192, 1'000'000), 32, false, 100);
  params.brake = core::make_brake_params(0.06F, 1e-3F, 3.3e-3F, 0.0F);
  params.shaft = core::make_shaft_params(2.873F, kStraight, 0.0F, 1e-3F, 0.0F);
  params.partition = {core::Law::paper, 0.5F, 0.085F, 0.110F};
  return params;
}

std::unique_ptr<core::Scene> wall_at_zero(float stiffness) {
  auto scene = std::make_unique<core::Scene>();
  scene->effect[0] = core::Wall{core::make_origin(0, 8192), -1.0F, stiffness, 0.0F};
  scene->active = 1;
  return scene;
}

}  // namespace

TEST_CASE("a tick follows the equations of the law in their order") {
  // The same recursion in double precision, written from the equations.
  const core::ControllerParams params = reference_actuator();
  const auto scene = wall_at_zero(1.432F);
  core::ControllerState state;
  const core::Plan plan = core::plan_of(params, state.bound, {scene.get()});
  CHECK(plan.pipeline == core::Pipeline::plain);
  double brake = 0.0, command = 0.0, spring = 0.0;
  const double per_count = 2.0 * M_PI / 8192.0;
  int count = 0;
  for (int i = 0; i < 600; ++i) {
    const int delta = i == 0    ? 0
                      : i < 250 ? (i % 4 == 0 ? 1 : 0)
                      : i < 500 ? -(i % 4 == 0 ? 1 : 0)
                                : 0;
    count += delta;
    const auto out = core::control(state, params, plan, static_cast<std::uint32_t>(count));

    brake = command + (brake - command) * std::exp(-1e-3 / 0.06);
    const double capacity = std::max(brake, 3.3e-3);
    spring = std::clamp(spring - 2.873 * delta * per_count, -capacity, capacity);
    const double desired = count > 0 ? -1.432 * count * per_count : 0.0;
    double motor = 0.0;
    command = 0.0;
    if (desired != 0.0) {
      const bool helps = desired * spring >= 0.0;
      motor = std::clamp(helps ? desired - spring : desired, -0.085, 0.085);
      command = helps ? std::min(0.5 * std::abs(desired), 0.110) : 0.0;
    }
    CHECK(out.desired_torque_nm == Approx(desired).scale(0).epsilon(1e-5).scale(0.05));
    CHECK(out.spring_torque_nm == Approx(spring).scale(0).epsilon(1e-4).scale(0.05));
    CHECK(out.motor_command_nm == Approx(motor).scale(0).epsilon(1e-4).scale(0.05));
    CHECK(out.brake_command_nm == Approx(command).scale(0).epsilon(1e-4).scale(0.05));
    CHECK(out.brake_capacity_nm == Approx(brake).scale(0).epsilon(1e-4).scale(0.05));
  }
}

TEST_CASE("the motor cancels what the brake's current holds, and drag where the scene asks") {
  core::ControllerParams params = reference_actuator();
  params.partition.law = core::Law::calibrated;
  params.brake = core::make_brake_params(1e9F, 1e-3F, 0.0F, 0.2F);  // what it holds stays
  params.assist = {0.01F, 1.0F, 1e-3F, 1.0F};
  core::Scene scene;
  scene.active = 1;
  // By hand; all in N m, the knob at rest.
  const struct {
    float asked, spring, coil, drag;
    double motor;
  } ticks[] = {{0.0F, 0.03F, 0.05F, 0.0F, -0.03},  {0.0F, -0.03F, 0.02F, 0.0F, 0.02},
               {0.0F, 0.03F, 0.0F, 0.0F, 0.0},     {0.0F, 0.2F, 0.11F, 0.0F, -0.085},
               {0.01F, 0.03F, 0.02F, 0.0F, -0.01}, {0.01F, 0.03F, 0.02F, 0.004F, -0.014},
               {-0.01F, 0.03F, 0.0F, 0.01F, -0.02}};
  for (const auto& tick : ticks) {
    CAPTURE(tick.motor);
    scene.effect[0] = core::Constant{tick.asked, {}};
    core::ControllerState state;
    state.sensor.spring_torque_nm = tick.spring;
    state.brake.coil_nm = state.brake.capacity_nm = tick.coil;
    state.brake_command_nm = tick.coil;
    state.bound.drag_nm = tick.drag;
    state.bound.new_scene = false;
    const core::Plan plan = core::plan_of(params, state.bound, {&scene});
    const auto out = core::control(state, params, plan, 0U);
    CHECK(out.motor_command_nm == Approx(tick.motor).scale(0.01).epsilon(1e-5));
  }
}

TEST_CASE("drag is cancelled no more in another scene, nor once time has taken the torque away") {
  core::ControllerParams params = reference_actuator();
  params.partition.law = core::Law::calibrated;
  params.assist.drag_most_nm = 1.0F;
  core::Scene scene;
  scene.effect[0] = core::Constant{0.01F, {}};
  scene.active = 1;
  core::ControllerState state;
  const auto tick = [&](const core::Play& play) {
    state.bound.drag_nm = 0.5F;
    (void)core::control(state, params, core::plan_of(params, state.bound, play), 0U);
    return state.bound.drag_nm;
  };
  CHECK(tick({&scene}) == 0.0F);  // a new one
  core::Play fades{&scene};
  for (const float gain : {0.5F, 0.25F}) {
    fades.gain = gain;
    (void)tick(fades);
  }
  CHECK(tick(fades) == 0.5F);  // no time passes in it
  fades.gain = 0.125F;
  CHECK(tick(fades) == Approx(0.00125));
}

TEST_CASE("where the scene has inertia no drag is cancelled, and a law in doubt gives less of it") {
  core::ControllerParams params = reference_actuator();
  params.partition.law = core::Law::calibrated;
  params.assist.drag_nm_per_rad = params.assist.drag_most_nm = 1.0F;
  params.bound.slope_nm_per_count = 1.0F;
  core::Scene scene;
  scene.effect[0] = core::Inertia{1e-4F, 1.0F};
  scene.active = 1;
  float whole_nm = 0.0F;
  for (const float trust : {1.0F, 0.25F}) {
    core::ControllerState state;
    state.bound.trust = trust;
    core::ControllerOutputs out;
    for (std::uint32_t i = 0; i < 4; ++i) {
      const core::Plan plan = core::plan_of(params, state.bound, {&scene});
      CHECK(plan.pipeline == core::Pipeline::full);
      out = core::control(state, params, plan, i);
    }
    CHECK(state.bound.drag_nm == 0.0F);
    if (trust == 1.0F) whole_nm = out.desired_torque_nm;
    CHECK(whole_nm != 0.0F);
    CHECK(out.desired_torque_nm == Approx(trust * whole_nm));
  }
}

TEST_CASE("one count switches no more than half the motor by virtual inertia") {
  core::ControllerParams params = reference_actuator();
  params.partition.law = core::Law::calibrated;
  params.bound.slope_nm_per_count = 1.0F;
  const double pole = std::exp(-2.0 * M_PI * 100.0 * 1e-3);
  const double one_count = std::pow((1.0 - pole) / 1e-3, 2) * 2.0 * M_PI / 8192;  // rad/s^2
  for (const double inertia_kg_m2 : {1e-6, 1.0}) {
    core::Scene scene;
    scene.active = 2;
    scene.effect[0] = core::Inertia{static_cast<float>(0.25 * inertia_kg_m2), 1000.0F};
    scene.effect[1] = core::Inertia{static_cast<float>(0.75 * inertia_kg_m2), 1000.0F};
    core::ControllerState state;
    core::ControllerOutputs out;
    for (const std::uint32_t count : {0U, 0U, 1U}) {
      const core::Plan plan = core::plan_of(params, state.bound, {&scene});
      out = core::control(state, params, plan, count);
    }
    const double most_nm = 0.5 * static_cast<double>(params.partition.motor_torque_max_nm);
    const double asked_nm = std::min(inertia_kg_m2 * one_count, most_nm);
    CHECK(static_cast<double>(out.desired_torque_nm) == Approx(-asked_nm).epsilon(1e-4));
  }
}

TEST_CASE("dampers together give the bound's share of what is stable") {
  core::ControllerParams params = reference_actuator();
  params.bound = core::make_bound_params({}, 0.12F, params.motion.resolution, 0.1F, 1e-4F, 6e-3F);
  const auto asked_nm_s_per_rad = [&](core::Law law, float each_nm_s_per_rad, float share) {
    params.partition.law = law;
    core::Scene scene;
    scene.effect[0] = scene.effect[1] = core::Damper{each_nm_s_per_rad, 1000.0F};
    scene.order[1] = 1;
    scene.active = 2;
    core::ControllerState state;
    state.bound.share = share;
    core::ControllerOutputs out;
    core::Plan plan;
    for (std::uint32_t count = 0; count < 200; ++count) {
      plan = core::plan_of(params, state.bound, {&scene});
      out = core::control(state, params, plan, count);
    }
    const float nm = plan.bounds ? core::asked_torque(state, plan) : out.desired_torque_nm;
    return -nm / out.motion.speed_rad_s;
  };
  CHECK(asked_nm_s_per_rad(core::Law::motor_only, 1.0F, 1.0F) == Approx(2.0));
  CHECK(asked_nm_s_per_rad(core::Law::calibrated, 1.0F, 1.0F) == Approx(0.12));
  CHECK(asked_nm_s_per_rad(core::Law::calibrated, 0.025F, 1.0F) == Approx(0.05));
  CHECK(asked_nm_s_per_rad(core::Law::calibrated, 0.025F, 0.25F) == Approx(0.03));
}

// No hand feels what is left out of a knob that was flung, and a wrong guess may drive it.
TEST_CASE("a knob that spins loses the trust until it rests, and a flywheel after long") {
  core::ControllerParams params = reference_actuator();  // 1 kHz: a look in 256 ms
  params.partition.law = core::Law::calibrated;
  params.bound = core::make_bound_params({}, 0.02F, params.motion.resolution, 0.1F, 1e-4F, 6e-3F);
  double count = 0.0;
  const auto turn = [&](core::ControllerState& state, const core::Effect& effect, double rad_s) {
    core::Scene scene;
    scene.active = 1;
    scene.effect[0] = effect;
    for (int i = 0; i < 1024; ++i) {
      count += 1e-3 * rad_s * 8192 / (2.0 * M_PI);
      const core::Plan plan = core::plan_of(params, state.bound, {&scene});
      (void)core::control(state, params, plan,
                          static_cast<std::uint32_t>(static_cast<std::int32_t>(count)));
    }
    return state.bound.trust;
  };
  for (const double way : {1.0, -1.0}) {
    core::ControllerState state;
    const core::Constant push{0.01F * static_cast<float>(way), {}};
    const core::Constant brake{-0.01F * static_cast<float>(way), {}};
    core::ControllerState braked;
    CHECK(turn(braked, brake, way * 30.0) == 1.0F);
    // What was lost comes back under a hand that turns on.
    braked.bound.trust = 0.1F;
    CHECK(turn(braked, brake, way * 1.0) == Approx(0.1 + 4.0 / 16));
    CHECK(turn(state, push, way * 19.0) == 1.0F);
    CHECK(turn(state, push, way * 21.0) < 0.5F);
    // Beyond four turns it is slow at a quarter of the speed.
    CHECK(turn(state, push, way * 6.0) < 0.05F);
    const float least = turn(state, push, way * 4.0);
    CHECK(turn(state, push, way * 4.0) == least);
    CHECK(turn(state, push, way * 2.0) == least);  // slow is no rest
    const float later = turn(state, push, 0.0);
    CHECK(later > least);
    CHECK(turn(state, push, 0.0) == Approx(later + 4.0F / 16));
    for (int n = 0; n < 4; ++n) (void)turn(state, push, 0.0);
    CHECK(state.bound.trust == 1.0F);
    CHECK_FALSE(state.bound.spun);
    core::ControllerState flywheel;
    for (int n = 0; n < 19; ++n) {
      CHECK(turn(flywheel, core::Inertia{1e-4F, 1.0F}, way * 100.0) == 1.0F);
    }
    CHECK(turn(flywheel, core::Inertia{1e-4F, 1.0F}, way * 100.0) < 1.0F);
  }
}

TEST_CASE("help along in free air stays within the motor's torque") {
  core::ControllerParams params = reference_actuator();
  params.partition = {core::Law::calibrated, 0.5F, 4e-3F, 0.110F};
  params.assist = {0.01F, 1.0F};
  const core::Scene scene;
  core::ControllerState state;
  const core::Plan plan = core::plan_of(params, state.bound, {&scene});
  for (std::uint32_t i = 0; i < 50; ++i) {
    const auto out = core::control(state, params, plan, 10 * i);
    CHECK(out.motor_command_nm <= 4e-3F);
    if (i == 49) CHECK(out.motor_command_nm == 4e-3F);
  }
}

// The brake's side swings against the knob that comes to rest, with all that the spring can give;
// the motor takes up half of the knob's friction of it, and less where the brake is not trusted.
TEST_CASE("the motor follows the inertia behind the brake no further than half the friction") {
  core::ControllerParams params = reference_actuator();
  params.brake = core::make_brake_params(0.0F, 1e-3F, 2e-3F, 2e-3F);
  params.shaft = core::make_shaft_params(2.873F, std::array<core::ShaftKnee, core::kMostKnees>{},
                                         4e-5F, 1e-3F, 6e-3F);
  params.partition.law = core::Law::calibrated;
  params.partition.beta = 0.0F;  // no current: the brake holds its drag
  params.bound.slope_nm_per_count = params.assist.drag_nm_per_rad = 1.0F;
  params.assist.drag_most_nm = 2e-3F + params.shaft.middle().brake_side.countered_nm;
  auto scene = std::make_unique<core::Scene>();
  scene->effect[0] = core::Constant{0.02F, {}};
  scene->active = 1;
  const core::Plan plan = core::plan_of(params, {}, {scene.get()});
  for (const double trust : {1.0, 0.25}) {
    core::ControllerState state;
    state.bound.trust = static_cast<float>(trust);
    double most_nm = 0.0;
    for (int i = 0; i < 200; ++i) {
      const int count = 30 * std::min(i, 20);
      const auto out = core::control(state, params, plan, static_cast<std::uint32_t>(count));
      const double spring_nm = static_cast<double>(out.spring_torque_nm);
      most_nm = std::max(most_nm, std::abs(spring_nm));
      const double most_of_it_nm = trust * (2e-3 + 1.5 * 6e-3);  // drag and friction
      const double countered_nm = std::clamp(spring_nm, -most_of_it_nm, most_of_it_nm);
      CHECK(out.motor_command_nm == Approx(0.02 - countered_nm).scale(0.01).epsilon(1e-4));
    }
    CHECK(most_nm > 0.05);
  }
}

TEST_CASE("without a scene nothing is commanded while motion and sensor go on") {
  core::ControllerState state;
  const core::ControllerParams params = reference_actuator();
  (void)core::control(state, params, {}, 0);
  const auto out = core::control(state, params, {}, 1);
  CHECK(out.motor_command_nm == 0.0F);
  CHECK(out.brake_command_nm == 0.0F);
  CHECK(out.motion.position_counts == 1);
  CHECK(out.spring_torque_nm == Approx(-2.873 * 2.0 * M_PI / 8192.0).scale(0).epsilon(1e-5));
}

TEST_CASE("a torque that is not finite is told, commands nothing and leaves no trace") {
  const core::ControllerParams params = reference_actuator();
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    core::ControllerState state;
    auto scene = std::make_unique<core::Scene>();
    scene->effect[0] = core::Constant{bad, {}};
    scene->active = 1;
    const core::Plan plan = core::plan_of(params, state.bound, {scene.get()});
    const auto out = core::control(state, params, plan, 5);
    CHECK(out.numeric_error);
    CHECK(out.motor_command_nm == 0.0F);
    CHECK(out.brake_command_nm == 0.0F);
    scene->effect[0] = core::Constant{0.01F, {}};
    const auto next = core::control(state, params, plan, 5);
    CHECK_FALSE(next.numeric_error);
    CHECK(next.motor_command_nm == Approx(0.01));
  }
}

TEST_CASE("the gain scales what the scene and the local model ask for") {
  const core::ControllerParams params = reference_actuator();
  core::ControllerState state;
  const core::LocalModel local{0.04F, {}, 0.0F, 0.0F};
  const core::Plan plan = core::plan_of(params, state.bound, {nullptr, &local, 0.25F});
  CHECK(core::control(state, params, plan, 0).desired_torque_nm == Approx(0.01));
}

TEST_CASE("each plan takes the pipeline that does no more than the plan needs") {
  using core::Pipeline;
  core::ControllerParams params = reference_actuator();
  const auto wall = wall_at_zero(1.0F);
  core::BoundState bound;
  core::Scene knocks;
  knocks.effect[0] = core::Impact{};
  knocks.active = 1;
  const auto chosen = [&](const core::Play& play, bool once = false) {
    const core::Plan plan = core::plan_of(params, bound, play);
    CHECK(plan.once == once);
    return plan.pipeline;
  };
  const core::LocalModel local;
  struct Push final : core::ForceSource {
    float torque_nm(const core::Motion&, const core::Resolution&, std::uint64_t) override {
      return 0.0F;
    }
  } push;
  CHECK(chosen({wall.get()}) == Pipeline::plain);
  CHECK(chosen({&knocks}) == Pipeline::full);
  CHECK(chosen({wall.get(), &local}, true) == Pipeline::full);
  CHECK(chosen({wall.get(), nullptr, 0.5F}, true) == Pipeline::full);
  CHECK(chosen({wall.get(), nullptr, 1.0F, &push}, true) == Pipeline::full);
  core::ExcitationState excitation;
  CHECK(core::plan_of(excitation).pipeline == Pipeline::full);
  CHECK(core::plan_of(excitation).once);
  CHECK(core::idle_plan(params).pipeline == Pipeline::plain);
  params.shaft.pieces = 2;
  CHECK(chosen({wall.get()}) == Pipeline::full);
  CHECK(core::idle_plan(params).pipeline == Pipeline::full);

  params = reference_actuator();
  params.partition.law = core::Law::calibrated;
  CHECK(chosen({wall.get()}, true) == Pipeline::full);  // the scene is new
  bound.new_scene = false;
  CHECK(chosen({wall.get()}) == Pipeline::bounded);
  CHECK(core::idle_plan(params).pipeline == Pipeline::full);
  CHECK(chosen({&knocks}) == Pipeline::full);
  bound.in_time_nm = 0.01F;
  CHECK(chosen({wall.get()}, true) == Pipeline::full);
  knocks.effect[0] = core::Constant{};
  CHECK(chosen({&knocks}) == Pipeline::full);
  bound.in_time_nm = 0.0F;
  params.shaft.pieces = 2;
  CHECK(chosen({wall.get()}) == Pipeline::bent);
}
