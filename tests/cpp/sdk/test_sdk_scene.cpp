// Scenes: refusals before anything is sent, what is sent, and that bad scenes change nothing.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "conversion/configuration.hpp"
#include "conversion/scene_encoding.hpp"
#include "protocol/codec.hpp"
#include "protocol/effects.hpp"
#include "protocol/reports.hpp"
#include "sdk/errors.hpp"
#include "torsio/knob.hpp"

using namespace torsio;
using conversion::EncodedScene;
using conversion::to_wire;
using test::contains;
using test::message_of;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kTurn = 2.0 * std::numbers::pi;

EncodedScene encode_scene(const Scene& scene) { return conversion::encode(to_wire(scene, {})); }

template <class Report>
Report wire(const Effect& effect) {
  const EncodedScene scene = encode_scene({effect});
  Report report{};
  REQUIRE(protocol::decode(scene.slots.at(0).report, report).ok());
  return report;
}

}  // namespace

TEST_CASE("angles become 2^-32 turns, exact where a fraction of a turn is") {
  CHECK(wire<protocol::Wall>(Wall{.angle_rad = kTurn / 4, .stiffness_nm_per_rad = 1})
            .angle_turns_q32 == 1LL << 30);
  CHECK(wire<protocol::Wall>(Wall{.angle_rad = -kTurn / 2, .stiffness_nm_per_rad = 1})
            .angle_turns_q32 == -(1LL << 31));
  // 1 rad = 683565275.576... 2^-32 turns.
  CHECK(wire<protocol::Wall>(Wall{.angle_rad = 1.0, .stiffness_nm_per_rad = 1}).angle_turns_q32 ==
        683565276);
}

TEST_CASE("detents by number and by pitch are the same, and whole numbers are exact") {
  for (const double per_turn : {1.0, 24.0, 100.0, 4096.0}) {
    CAPTURE(per_turn);
    const auto exact = static_cast<std::uint64_t>(per_turn) << 32U;
    CHECK(wire<protocol::Detents>(Detents{.per_turn = per_turn, .torque_nm = 0}).per_turn_q32 ==
          exact);
    CHECK(wire<protocol::Detents>(Detents{.pitch_rad = kTurn / per_turn, .torque_nm = 0})
              .per_turn_q32 == exact);
  }
}

TEST_CASE("every field of a local model arrives in its own place") {
  const protocol::LocalModel model = to_wire(LocalModel{.torque_nm = -0.5,
                                                        .angle_rad = kTurn,
                                                        .stiffness_nm_per_rad = 2,
                                                        .damping_nm_s_per_rad = 0.25,
                                                        .deadline_s = 0.125});
  CHECK(model.torque_nm == -0.5F);
  CHECK(model.angle_turns_q32 == 1LL << 32);
  CHECK(model.stiffness_nm_per_rad == 2.0F);
  CHECK(model.damping_nm_s_per_rad == 0.25F);
  CHECK(model.deadline_s == 0.125F);
}

TEST_CASE("what is not given is what the device has by default") {
  CHECK(protocol::encode(to_wire(BoardConfig{})) == protocol::encode(protocol::BoardConfig{}));
  CHECK(protocol::encode(to_wire(ActuatorConfig{})) ==
        protocol::encode(protocol::ActuatorConfig{}));
  CHECK(protocol::encode(to_wire(ControlConfig{})) == protocol::encode(protocol::ControlConfig{}));
  CHECK(protocol::encode(wire<protocol::Wall>(Wall{.stiffness_nm_per_rad = 0})) ==
        protocol::encode(protocol::Wall{}));
  CHECK(protocol::encode(wire<protocol::Spring>(Spring{.stiffness_nm_per_rad = 0})) ==
        protocol::encode(protocol::Spring{}));
  CHECK(protocol::encode(wire<protocol::Friction>(Friction{.torque_nm = 0})) ==
        protocol::encode(protocol::Friction{}));
  CHECK(protocol::encode(wire<protocol::Periodic>(Periodic{
            .amplitude_nm = 0, .frequency_hz = 0})) == protocol::encode(protocol::Periodic{}));
  CHECK(protocol::encode(wire<protocol::Detents>(Detents{.per_turn = 24, .torque_nm = 0})) ==
        protocol::encode(protocol::Detents{}));
  CHECK(protocol::encode(wire<protocol::Texture>(Texture{.grains_per_turn = 1, .torque_nm = 0})) ==
        protocol::encode(protocol::Texture{}));
  CHECK(protocol::encode(wire<protocol::Impact>(Impact{})) == protocol::encode(protocol::Impact{}));
  CHECK(protocol::encode(to_wire(LocalModel{})) == protocol::encode(protocol::LocalModel{}));
}

TEST_CASE("curves of a scene share the pool one after the other") {
  const Curve first{.torque_nm = std::vector<double>(20, 0.25)};
  const Curve second{.torque_nm = {0.5, 0.75}};
  const EncodedScene scene = encode_scene({first, second});
  REQUIRE(scene.pieces.size() == 2);  // 22 points, 13 in a report
  protocol::CurvePoints piece;
  REQUIRE(protocol::decode(scene.pieces[1], piece).ok());
  CHECK(piece.first_point == 13);
  CHECK(piece.points == 9);
  CHECK(piece.torque_nm[6] == 0.25F);
  CHECK(piece.torque_nm[7] == 0.5F);
  CHECK(piece.torque_nm[8] == 0.75F);
  protocol::Curve curve;
  REQUIRE(protocol::decode(scene.slots[1].report, curve).ok());
  CHECK(curve.target.slot == 1);
  CHECK(curve.first_point == 20);
  CHECK(curve.points == 2);
}

TEST_CASE("a bad value is InvalidArgument that names effect, field and range") {
  Knob knob = Knob::open("emulated");
  const Wall good{.stiffness_nm_per_rad = 1.0};
  struct Case {
    Effect effect;
    std::vector<std::string> says;
  };
  const std::vector<Case> cases{
      {Wall{.stiffness_nm_per_rad = -1},
       {"wall", "stiffness_nm_per_rad is -1", "0 to 1000000 N m"}},
      {Wall{.stiffness_nm_per_rad = kNan}, {"stiffness_nm_per_rad is not a number"}},
      {Wall{.angle_rad = 0.1}, {"wall", "stiffness_nm_per_rad", "it must be given"}},
      {EndStops{.stiffness_nm_per_rad = 1.4}, {"end_stops", "lower_rad", "it must be given"}},
      {Texture{.torque_nm = 0.01}, {"texture", "grains_per_turn is 0"}},
      {Wall{.stiffness_nm_per_rad = 1e300}, {"stiffness_nm_per_rad", "1000000"}},
      {Wall{.angle_rad = kInfinite, .stiffness_nm_per_rad = 1}, {"angle_rad is infinite"}},
      {Wall{.angle_rad = 1e9, .stiffness_nm_per_rad = 1}, {"angle_rad is 1e+09", "rad"}},
      {Wall{.side = static_cast<Side>(7), .stiffness_nm_per_rad = 1}, {"side"}},
      {Spring{.stiffness_nm_per_rad = 1, .deadband_rad = -1}, {"spring", "deadband_rad"}},
      {Damper{.damping_nm_s_per_rad = kInfinite}, {"damper", "damping_nm_s_per_rad is infinite"}},
      {Friction{.torque_nm = 0, .stiffness_nm_per_rad = 0},
       {"friction", "stiffness_nm_per_rad is 0"}},
      {Inertia{.inertia_kg_m2 = 11}, {"inertia", "inertia_kg_m2 is 11", "0 to 10 kg m^2"}},
      {Constant{.torque_nm = 101}, {"constant", "torque_nm is 101", "-100 to 100 N m"}},
      {Constant{.torque_nm = 0, .timing = {.attack_level = 2}}, {"attack_level is 2", "0 to 1"}},
      {Constant{.torque_nm = 0, .timing = {.fade_s = 1}}, {"fade_s", "duration"}},
      {Constant{.torque_nm = 0, .timing = {.duration_s = 1, .attack_s = 0.6, .fade_s = 0.6}},
       {"attack_s", "fade_s"}},
      // Each is half a tick of this device, and rounded up.
      {Constant{.torque_nm = 0, .timing = {.duration_s = 1e-3, .attack_s = 5e-4, .fade_s = 5e-4}},
       {"each in whole ticks of 0.001 s", "longer than duration_s"}},
      {Ramp{.start_torque_nm = 0, .end_torque_nm = 0.1}, {"ramp", "duration_s is 0"}},
      {Periodic{.amplitude_nm = 0, .frequency_hz = 501},
       {"periodic", "frequency_hz is 501", "0 to 500 Hz"}},
      {Impact{.frequency_hz = 501}, {"impact", "frequency_hz is 501", "1 to 500 Hz"}},
      {Periodic{.amplitude_nm = 0, .frequency_hz = 20'000}, {"is 20000", "0 to 500 Hz"}},
      {Impact{.decay_s = 0}, {"decay_s is 0"}},
      {Periodic{.amplitude_nm = 0, .frequency_hz = 1, .phase_turns = 1.5}, {"phase_turns is 1.5"}},
      {Detents{}, {"detents", "exactly one of per_turn and pitch_rad"}},
      {Detents{.per_turn = 24, .pitch_rad = 1}, {"exactly one of per_turn and pitch_rad"}},
      {Detents{.per_turn = 0}, {"per_turn is 0"}},
      {Detents{.per_turn = 4097}, {"per_turn is 4097", "4096", "two counts"}},
      {Detents{.pitch_rad = kNan}, {"pitch_rad is not a number"}},
      {Detents{.per_turn = 24, .torque_nm = 0, .width = 0}, {"width is 0"}},
      {EndStops{.lower_rad = 1, .upper_rad = 0, .stiffness_nm_per_rad = 1},
       {"end_stops", "upper_rad is 0", "lower_rad"}},
      {EndStops{.lower_rad = kNan, .upper_rad = 1}, {"lower_rad is not a number"}},
      {Texture{.grains_per_turn = 0}, {"texture", "grains_per_turn is 0", "1 to 4096"}},
      {Texture{.grains_per_turn = -5}, {"grains_per_turn is -5"}},
      {Curve{.torque_nm = {1.0}}, {"curve", "1 points", "2 to 1024"}},
      {Curve{.torque_nm = std::vector<double>(1025)}, {"1025 points", "1024"}},
      {Curve{.torque_nm = {0, kNan, 0}}, {"torque_nm[1] is not a number"}},
      {Curve{.torque_nm = {0, 1}, .span_rad = 0}, {"span_rad is 0"}},
      {Curve{.torque_nm = {0, 1}, .span_rad = 1000}, {"span_rad is 1000"}},
  };
  for (const Case& bad : cases) {
    const std::string message =
        message_of<InvalidArgument>([&] { knob.play(Scene{good, bad.effect}); });
    CAPTURE(message);
    CHECK(contains(message, "effect 1"));
    for (const std::string& part : bad.says) CHECK_MESSAGE(contains(message, part), part);
  }
  CHECK(knob.statistics().reports_sent == 0);
}

TEST_CASE("the whole range of every limit is accepted") {
  const EncodedScene scene = encode_scene(
      {Wall{.angle_rad = 4e8, .stiffness_nm_per_rad = 1e6, .damping_nm_s_per_rad = 1e3},
       Wall{.angle_rad = -4e8, .side = Side::below, .stiffness_nm_per_rad = 0},
       Constant{.torque_nm = -100},
       // 0.1 + 0.2 is above 0.3 in doubles, not in ticks.
       Constant{.torque_nm = 100, .timing = {.duration_s = 0.3, .attack_s = 0.1, .fade_s = 0.2}},
       Friction{.torque_nm = 0, .stiffness_nm_per_rad = 1e-6},
       Detents{.per_turn = 4096, .torque_nm = 100, .width = 0.01},
       Texture{.grains_per_turn = 4096, .torque_nm = 0},
       Periodic{.amplitude_nm = 0, .frequency_hz = 500, .phase_turns = 1},
       Impact{.frequency_hz = 500},
       Curve{.torque_nm = std::vector<double>(1024, 100.0), .span_rad = 800}});
  CHECK(scene.slots.size() == 10);
  CHECK(scene.pieces.size() == 79);
}

TEST_CASE("a seventeenth effect is InvalidArgument and sixteen play") {
  Knob knob = Knob::open("emulated");
  CHECK(
      contains(message_of<InvalidArgument>([&] { knob.play(Scene(17, Constant{.torque_nm = 0})); }),
               "17 effects"));
  CHECK(knob.statistics().reports_sent == 0);
  knob.play(Scene(16, Constant{.torque_nm = 1e-3}));
  knob.arm();
  CHECK(knob.record(0.2).back().desired_torque_nm == doctest::Approx(16e-3).scale(0).epsilon(1e-2));
}

TEST_CASE("the old scene goes on after a bad one") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  knob.play(Constant{.torque_nm = 0.01});
  knob.sleep(0.1);
  CHECK_THROWS_AS(knob.play(Scene{Constant{.torque_nm = 0.02}, Wall{.angle_rad = kNan}}),
                  InvalidArgument);
  for (const TelemetrySample& sample : knob.record(0.05)) {
    CHECK(sample.desired_torque_nm == doctest::Approx(0.01).scale(0).epsilon(1e-2));
  }
}

TEST_CASE("play sends only what changed") {
  Knob knob = Knob::open("emulated");
  const auto reports_for = [&](const Scene& scene) {
    const std::uint64_t before = knob.statistics().reports_sent;
    knob.play(scene);
    return knob.statistics().reports_sent - before;
  };
  const Wall wall{.stiffness_nm_per_rad = 1.0};
  const Constant push{.torque_nm = 0.01};
  const Curve curve{.torque_nm = std::vector<double>(26, 0.01)};
  CHECK(reports_for({wall, push}) == 3);
  CHECK(reports_for({wall, push}) == 1);
  CHECK(reports_for({wall, Constant{.torque_nm = 0.02}}) == 2);
  CHECK(reports_for({wall}) == 1);
  CHECK(reports_for({wall, push, curve}) == 1 + 1 + 1 + 2);
  CHECK(reports_for({wall, push, curve}) == 1);
  Curve other = curve;
  other.torque_nm[0] = 0.02;
  CHECK(reports_for({wall, push, other}) == 1 + 1 + 1);
  CHECK(reports_for({}) == 1);
  knob.stop();
  CHECK(reports_for({wall, push}) == 3);
}

TEST_CASE("a tap begins with the scene that plays, whatever of it was sent when") {
  Knob knob = Knob::open("emulated");
  const auto begin_of_tap = [&] {
    std::vector<std::uint8_t> ids;
    std::uint64_t tick = 0;
    for (const LoggedReport& report : knob.tap(false)->take()) {
      CHECK(report.sent);
      CHECK(report.tick > tick);  // the device takes one in a tick
      tick = report.tick;
      ids.push_back(report.bytes[0]);
    }
    return ids;
  };
  const auto ids = []<class... Reports>(Reports...) {
    return std::vector<std::uint8_t>{protocol::Layout<Reports>::id...};
  };
  const Wall wall{.stiffness_nm_per_rad = 1};
  const auto wall_alone = ids(protocol::Wall{}, protocol::Commit{});
  CHECK(begin_of_tap().empty());
  knob.sleep(0.1);
  knob.play(Scene{wall, Curve{.torque_nm = {0.0, 0.01}}});
  CHECK(begin_of_tap() ==
        ids(protocol::CurvePoints{}, protocol::Wall{}, protocol::Curve{}, protocol::Commit{}));
  knob.play(wall);
  CHECK(begin_of_tap() == wall_alone);
  knob.update([](ControlConfig& control) { control.beta = 0.5; });
  CHECK(begin_of_tap() == wall_alone);
  CHECK_THROWS_AS(knob.play(Scene(17, wall)), InvalidArgument);
  CHECK(begin_of_tap() == wall_alone);
  // The scene is gone where the device has dropped it.
  knob.update([](ActuatorConfig& actuator) { actuator.counts_per_rev = 4096; });
  CHECK(begin_of_tap().empty());
  knob.play(wall);
  knob.stop();
  CHECK(begin_of_tap().empty());
}

TEST_CASE("an effect that stays in its place goes on playing, a changed one starts anew") {
  Knob knob = Knob::open("emulated");
  ControlConfig config = knob.control_config();
  config.passive_ramp_s = 0.0;
  knob.configure(config);
  knob.arm();
  const Ramp ramp{.start_torque_nm = 0, .end_torque_nm = 0.02, .timing = {.duration_s = 1.0}};
  knob.play(Scene{ramp});
  knob.sleep(0.5);
  knob.play(Scene{ramp, Constant{.torque_nm = 0}});
  CHECK(knob.record(0.01).back().desired_torque_nm ==
        doctest::Approx(0.0105).scale(0).epsilon(0.05));
  knob.play(Scene{Ramp{.start_torque_nm = 0, .end_torque_nm = 0.04, .timing = {.duration_s = 1.0}},
                  Constant{.torque_nm = 0}});
  CHECK(knob.record(0.01).back().desired_torque_nm < 0.001F);
}

TEST_CASE("each kind of effect is accepted and makes torque where it should") {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->hand = PrescribedMotion{{{0.0, 0.0}, {1.0, 0.0}, {2.0, 1.0}}};
  Knob knob = Knob::open("emulated", options);
  const std::vector<Effect> effects{
      Wall{.angle_rad = 0.1, .stiffness_nm_per_rad = 1},
      Spring{.stiffness_nm_per_rad = 1},
      Damper{.damping_nm_s_per_rad = 0.01},
      Friction{.torque_nm = 0.02},
      Inertia{.inertia_kg_m2 = 1e-3},
      Constant{.torque_nm = 0.02},
      Ramp{.start_torque_nm = 0, .end_torque_nm = 0.02, .timing = {.duration_s = 100}},
      Periodic{.amplitude_nm = 0.02, .frequency_hz = 10},
      Detents{.per_turn = 24, .torque_nm = 0.02},
      EndStops{.lower_rad = -0.1, .upper_rad = 0.1, .stiffness_nm_per_rad = 1},
      Texture{.grains_per_turn = 100, .torque_nm = 0.02},
      Curve{.torque_nm = {0.0, -0.02}},
      Impact{.angle_rad = 0.1, .strength_nm_s_per_rad = 0.01},
  };
  CHECK(effects.size() == std::variant_size_v<Effect>);
  knob.arm();
  for (const Effect& effect : effects) {
    CAPTURE(effect.index());
    knob.emulator().set_hand(PrescribedMotion{{{0.0, 0.0}, {0.1, 0.0}, {0.6, 1.0}}});
    knob.play(effect);
    float largest = 0.0F;
    for (const TelemetrySample& sample : knob.record(0.6)) {
      largest = std::max(largest, std::abs(sample.desired_torque_nm));
    }
    CHECK(largest > 1e-4F);
    knob.stop();
    knob.arm();
  }
}

TEST_CASE("a bad local model is InvalidArgument, and one for a knob not armed is refused at once") {
  Knob knob = Knob::open("emulated");
  CHECK(contains(
      message_of<InvalidArgument>([&] { knob.stream_local_model({.stiffness_nm_per_rad = -1}); }),
      "local model: stiffness_nm_per_rad is -1"));
  CHECK(contains(message_of<InvalidArgument>([&] { knob.stream_local_model({.angle_rad = kNan}); }),
                 "angle_rad"));
  const auto check_refused = [&] {
    const std::uint64_t sent = knob.statistics().reports_sent;
    try {
      knob.stream_local_model({.torque_nm = 0.01});
      FAIL("no error");
    } catch (const Refused& refused) {
      CHECK(refused.status() == "not_armed");
      CHECK(refused.report() == "local_model");
      CHECK(refused.field().empty());
      CHECK(contains(refused.what(), "arm()"));
    }
    CHECK(knob.statistics().reports_sent == sent);
  };
  check_refused();
  knob.emulator().set_emergency_stop(true);
  REQUIRE(knob.wait_for(State::fault, 0.1));
  check_refused();
  knob.emulator().set_emergency_stop(false);
  knob.sleep(0.05);
  knob.clear_fault();

  knob.arm();
  for (int i = 0; i < 20; ++i) {
    knob.stream_local_model({.torque_nm = 0.01});
    knob.sleep(0.01);
  }
  CHECK((knob.record(0.01).front().flags & flag::local_model) != 0);
  CHECK(knob.wait_for(State::disarmed, 0.2));  // past its deadline the device fails passive
  check_refused();
  CHECK(knob.statistics().local_models_refused == 0);
}

TEST_CASE("a local model for a device that stopped unnoticed is counted as refused") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  knob.emulator().set_link_faults({.drop_input = 1.0});
  knob.emulator().set_emergency_stop(true);
  knob.sleep(0.05);
  knob.emulator().set_link_faults({});
  REQUIRE(knob.state() == State::armed);  // as far as the host has heard
  knob.stream_local_model({.torque_nm = 0.01});
  knob.sleep(0.05);
  CHECK(knob.statistics().local_models_refused == 1);
  CHECK_FALSE(knob.statistics().last_refusal.empty());
}

TEST_CASE("a scene, or a local model, that the knob may swing in plays and returns a warning") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  const Spring soft{.stiffness_nm_per_rad = 1.9};
  CHECK(knob.play(soft).empty());
  CHECK(contains(knob.play(Scene(4, soft)), "may swing"));
  CHECK(contains(knob.play(Damper{.damping_nm_s_per_rad = 0.15}), "calibrated"));
  CHECK(knob.play(Scene{}).empty());
  CHECK(contains(knob.stream_local_model({.stiffness_nm_per_rad = 50.0}), "may swing"));
  CHECK(knob.stream_local_model({.stiffness_nm_per_rad = 50.0}).empty());  // as before
  knob.disarm();
  knob.update([](ControlConfig& control) { control.law = Law::calibrated; });
  CHECK(knob.play(Scene(4, soft)).empty());
  knob.arm();
  CHECK(contains(knob.stream_local_model({.stiffness_nm_per_rad = 50.0}), "no law bounds"));
  std::string told;
  for (int n = 0; n < 5; ++n) {
    CHECK(told.empty());
    told = knob.play(Wall{.angle_rad = 0.01 * n, .stiffness_nm_per_rad = 300.0});
  }
  CHECK(contains(told, "what a host moves"));
}
