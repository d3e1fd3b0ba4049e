// The host's reports and the device's answers.
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <random>

#include "boards/pico/board.hpp"
#include "boards/pico2/board.hpp"
#include "boards/reference.hpp"
#include "device/played.hpp"
#include "protocol/axis_samples.hpp"

using namespace torsio::protocol;
using doctest::Approx;
using torsio::test::arm_at_once;
using torsio::test::Rig;

TEST_CASE("every refused report says why and leaves the scene as it was") {
  Rig rig;
  rig.arm_with_constant(0.03F);
  const float held = rig.outputs.motor_command_nm;

  Wall bad;
  bad.stiffness_nm_per_rad = std::numeric_limits<float>::quiet_NaN();
  const Acknowledgement nan = rig.send(bad);
  CHECK(nan.status == static_cast<std::uint8_t>(Status::not_finite));
  CHECK(nan.field == field_index<Wall>("stiffness_nm_per_rad"));
  CHECK(nan.report == Layout<Wall>::id);

  Wall other_axis;
  other_axis.target.axis = 1;
  CHECK(rig.send_status(other_axis) == Status::bad_axis);
  Ramp endless;
  CHECK(rig.send_status(endless) == Status::inconsistent);
  EndStops crossed;
  crossed.lower_turns_q32 = 1;
  CHECK(rig.send_status(crossed) == Status::inconsistent);
  Periodic fast;
  fast.frequency_hz = 501.0F;  // above half the rate
  CHECK(rig.send_status(fast) == Status::out_of_range);
  Detents fine;
  fine.per_turn_q32 = (std::uint64_t{4096} << 32) + 1;
  CHECK(rig.send_status(fine) == Status::out_of_range);
  Texture grainy;
  grainy.grains_per_turn = 4097;
  CHECK(rig.send_status(grainy) == Status::out_of_range);
  Impact shrill;
  shrill.frequency_hz = 501.0F;
  CHECK(rig.send_status(shrill) == Status::out_of_range);
  Curve beyond;
  beyond.first_point = 1000;
  beyond.points = 25;
  CHECK(rig.send_status(beyond) == Status::inconsistent);
  CurvePoints points;
  points.first_point = 1020;
  points.points = 5;
  CHECK(rig.send_status(points) == Status::inconsistent);
  Constant fading;
  fading.timing.fade_s = 1.0F;
  CHECK(rig.send_status(fading) == Status::inconsistent);
  fading.timing.duration_s = 1.5F;
  fading.timing.attack_s = 1.0F;
  CHECK(rig.send_status(fading) == Status::inconsistent);
  CHECK(rig.send_status(Commit{5, 0, 0x8001}) == Status::empty_slot);

  const ReportBytes wall = encode(Wall{});
  CHECK(rig.status(rig.send_bytes(std::span(wall).first(20))) == Status::bad_length);
  CHECK(rig.status(rig.send_bytes(std::array<std::uint8_t, 100>{Layout<Wall>::id})) ==
        Status::bad_length);
  CHECK(rig.status(rig.send_bytes(std::array<std::uint8_t, 64>{0x77})) == Status::unknown_report);
  // A feature report on the output pipe, and an input report.
  CHECK(rig.send_status(ActuatorConfig{}) == Status::unknown_report);
  CHECK(rig.status(rig.send_bytes(encode(Event{}))) == Status::unknown_report);

  CHECK(rig.state() == State::armed);
  CHECK(rig.outputs.motor_command_nm == held);
}

TEST_CASE("acknowledgements carry the sequence number, even of what cannot be read") {
  Rig rig;
  Wall wall;
  wall.target.sequence = 0xBEEF;
  CHECK(rig.send(wall).sequence == 0xBEEF);
  const ReportBytes bytes = encode(wall);
  CHECK(rig.send_bytes(std::span(bytes).first(30)).sequence == 0xBEEF);
}

TEST_CASE("a commit changes the whole scene between two ticks") {
  Rig rig;
  ControlConfig config;
  config.law = Law::motor_only;
  config.passive_ramp_s = 0.0F;
  REQUIRE(rig.set(config).ok());
  const auto put = [&](std::uint8_t slot, float torque_nm) {
    Constant constant;
    constant.target = {1, 0, slot};
    constant.torque_nm = torque_nm;
    REQUIRE(rig.send_status(constant) == Status::ok);
  };
  put(0, 0.01F);
  put(1, 0.02F);
  REQUIRE(rig.send_status(Commit{2, 0, 3}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == Approx(0.03));
  put(0, -0.04F);
  put(1, -0.02F);
  CHECK(rig.outputs.motor_command_nm == Approx(0.03));  // written, not committed
  REQUIRE(rig.device->receive(encode(Commit{3, 0, 3})));
  while (rig.outputs.motor_command_nm > 0.0F) rig.tick();
  CHECK(rig.outputs.motor_command_nm == Approx(-0.06));  // never -0.02 or -0.01
  // A change of one effect keeps the other.
  put(1, 0.0F);
  REQUIRE(rig.send_status(Commit{4, 0, 3}) == Status::ok);
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == Approx(-0.04));
  REQUIRE(rig.send_status(Commit{5, 0, 0}) == Status::ok);
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("effects that were not written again go on, those that were begin anew") {
  Rig rig;
  arm_at_once(rig);
  Ramp ramp;
  ramp.end_torque_nm = 0.05F;
  ramp.timing.duration_s = 0.1F;
  Constant constant;
  constant.target.slot = 1;
  REQUIRE(rig.send_status(ramp) == Status::ok);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  rig.tick(50);
  const float middle = rig.outputs.motor_command_nm;
  CHECK(middle == Approx(0.025).scale(0).epsilon(0.05));
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(Commit{2, 0, 3}) == Status::ok);
  CHECK(rig.outputs.motor_command_nm > middle);  // went on
  REQUIRE(rig.send_status(ramp) == Status::ok);
  REQUIRE(rig.send_status(Commit{3, 0, 3}) == Status::ok);
  CHECK(rig.outputs.motor_command_nm < 0.2F * middle);  // began anew
}

TEST_CASE("zero and relax act only while disarmed") {
  Rig rig;
  rig.tick();
  rig.inputs.encoder_count = 100;
  rig.tick();
  CHECK(rig.get<Clock>().position_counts == 100);
  CHECK(rig.command(Op::zero) == Status::ok);
  CHECK(rig.get<Clock>().position_counts == 0);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  CHECK(rig.command(Op::zero) == Status::not_disarmed);
  CHECK(rig.command(Op::relax) == Status::not_disarmed);
  CHECK(rig.command(Op::load_defaults) == Status::not_disarmed);
  CHECK(rig.command(Op::save) == Status::not_disarmed);
  CHECK(rig.command(Op::bootloader) == Status::unsupported);
}

TEST_CASE("configuration is set while disarmed, read back and refused when it makes no sense") {
  Rig rig;
  ActuatorConfig config;
  config.sequence = 77;
  config.counts_per_rev = 4000;
  CHECK(rig.set(config).ok());
  CHECK(rig.acknowledgements.back().sequence == 77);
  CHECK(rig.acknowledgements.back().report == Layout<ActuatorConfig>::id);
  CHECK(rig.get<ActuatorConfig>().counts_per_rev == 4000);
  CHECK(rig.get<Identity>().counts_per_rev == 4000);

  config.brake_torque_min_nm = 0.2F;  // above the maximum
  CHECK(rig.set(config) ==
        Verdict{Status::inconsistent, field_index<ActuatorConfig>("brake_torque_min_nm")});
  config.brake_torque_min_nm = -1.0F;
  CHECK(rig.set(config).status == Status::out_of_range);
  CHECK(rig.set(Identity{}).status == Status::unknown_report);
  CHECK(rig.device->set_feature(std::array<std::uint8_t, 10>{}).status == Status::bad_length);
  ReportBytes bytes;
  CHECK(rig.device->get_feature(Layout<Wall>::id, bytes) == Status::unknown_report);

  REQUIRE(rig.command(Op::arm) == Status::ok);
  CHECK(rig.set(ControlConfig{}).status == Status::not_disarmed);
  CHECK(rig.get<ActuatorConfig>().brake_torque_min_nm == 3.3e-3F);
}

TEST_CASE("a shaft's curve is read back as it was set, and refused unless its torque grows") {
  Rig rig;
  ShaftConfig shaft;
  shaft.knee_1_rad = 0.015F;
  shaft.knee_1_nm_per_rad = 6;
  shaft.knee_2_rad = 0.03F;
  shaft.knee_2_nm_per_rad = 1.5F;
  REQUIRE(rig.set(shaft).ok());
  CHECK(rig.get<ShaftConfig>().knee_2_rad == 0.03F);

  const auto refused = [&](auto change) {
    ShaftConfig bad = shaft;
    change(bad);
    const Verdict verdict = rig.set(bad);
    CHECK(verdict.status == Status::inconsistent);
    CHECK(rig.get<ShaftConfig>().knee_1_rad == 0.015F);
    return field_name<ShaftConfig>(verdict.field);
  };
  CHECK(refused([](ShaftConfig& c) { c.knee_2_rad = 0.015F; }) == "knee_2_rad");
  CHECK(refused([](ShaftConfig& c) { c.knee_1_rad = 0.04F; }) == "knee_2_rad");
  CHECK(refused([](ShaftConfig& c) { c.knee_1_rad = 0; }) == "knee_2_rad");
  CHECK(refused([](ShaftConfig& c) { c.knee_4_rad = 0.05F; }) == "knee_4_rad");
  CHECK(refused([](ShaftConfig& c) { c.knee_1_nm_per_rad = 0; }) == "knee_1_nm_per_rad");
  CHECK(refused([](ShaftConfig& c) { c.knee_2_nm_per_rad = 0; }) == "knee_2_nm_per_rad");
}

TEST_CASE("a calibration is about the values that the device has as it takes it") {
  using torsio::protocol::Basis;
  using torsio::protocol::CalibrationConfig;
  Rig rig;
  CHECK(rig.get<CalibrationConfig>().values_are == Basis::assumed);
  ActuatorConfig actuator;
  actuator.spring_stiffness_nm_per_rad = 2.5F;
  REQUIRE(rig.set(actuator).ok());
  CalibrationConfig known;
  known.values_are = Basis::measured;
  known.calibrated_unix_s = 1'800'000'000;
  known.sigma_spring_stiffness_nm_per_rad = 0.002F;
  REQUIRE(rig.set(known).ok());
  CHECK(rig.get<CalibrationConfig>().values_are == Basis::measured);
  CHECK(rig.get<CalibrationConfig>().calibrated_unix_s == 1'800'000'000);

  // Other parts, or the same values from another host, do not matter.
  REQUIRE(rig.set(ControlConfig{}).ok());
  actuator.sequence = 77;
  REQUIRE(rig.set(actuator).ok());
  CHECK(rig.get<CalibrationConfig>().values_are == Basis::measured);

  ActuatorConfig other = actuator;
  other.spring_stiffness_nm_per_rad = 2.6F;
  REQUIRE(rig.set(other).ok());
  CHECK(rig.get<CalibrationConfig>().values_are == Basis::assumed);
  CHECK(rig.get<CalibrationConfig>().sigma_spring_stiffness_nm_per_rad == 0.002F);
  REQUIRE(rig.set(actuator).ok());
  CHECK(rig.get<CalibrationConfig>().values_are == Basis::measured);

  ShaftConfig shaft;
  shaft.knee_1_rad = 0.015F;
  shaft.knee_1_nm_per_rad = 6;
  REQUIRE(rig.set(shaft).ok());
  CHECK(rig.get<CalibrationConfig>().values_are == Basis::assumed);
  known.values_are = Basis::stated;
  REQUIRE(rig.set(known).ok());
  CHECK(rig.get<CalibrationConfig>().values_are == Basis::stated);
}

TEST_CASE("GP15 is the RP2040's own, whatever stands in its flash, and free on the RP2350") {
  namespace pico = torsio::boards::pico;
  namespace pico2 = torsio::boards::pico2;
  torsio::device::BoardInfo board;
  BoardConfig first;
  first.light_pin = 15;
  BoardConfig second;
  second.motor_pin = 14;
  for (const bool free : {false, true}) {
    board.wiring_rule = (free ? pico2::kBoard : pico::kBoard).wiring_rule;
    Rig rig(board);
    CHECK(rig.set(first).ok() == free);
    CHECK(rig.set(second).ok() == free);
    CHECK(rig.get<BoardConfig>().motor_pin == (free ? 14 : 6));
  }
  torsio::device::Config config;
  config.board = second;
  torsio::device::StoredSlots slots = torsio::device::empty_slots();
  slots.slot[0] = torsio::device::ConfigStore(slots).prepare(config).bytes;
  CHECK(Rig(board, slots).get<BoardConfig>().motor_pin == 14);
  board.wiring_rule = pico::kBoard.wiring_rule;
  CHECK(Rig(board, slots).get<BoardConfig>().motor_pin == 6);
}

TEST_CASE("a setting behind an arm command in the same frame is refused, not half taken") {
  Rig rig;
  ControlConfig config;
  config.beta = 0.125F;
  REQUIRE(rig.device->receive(encode(Command{1, 0, Op::arm})));
  CHECK(rig.device->set_feature(encode(config)).ok());  // still disarmed
  rig.tick(4);
  CHECK(rig.status(rig.acknowledgements.back()) == Status::not_disarmed);
  CHECK(rig.get<ControlConfig>().beta == 0.5F);
}

TEST_CASE("a pin that a setting in the same frame has taken is refused, not driven twice") {
  torsio::device::BoardInfo board;
  board.wiring_rule = torsio::boards::pico2::kBoard.wiring_rule;
  Rig rig(board);
  BoardConfig first;
  first.motor_pin = 14;
  ActuatorConfig second;
  const std::uint8_t no_pin = second.encoder_index_pin;
  second.encoder_index_pin = 14;
  CHECK(rig.device->set_feature(encode(first)).ok());
  CHECK(rig.device->set_feature(encode(second)).ok());  // free until the first is carried out
  rig.tick(4);
  CHECK(rig.status(rig.acknowledgements.back()) == Status::inconsistent);
  CHECK(rig.get<BoardConfig>().motor_pin == 14);
  CHECK(rig.get<ActuatorConfig>().encoder_index_pin == no_pin);
}

TEST_CASE("telemetry tells desired, motor, brake and spring torque with their signs") {
  Rig rig;
  ControlConfig config;
  config.passive_ramp_s = 0.0F;
  config.watchdog_s = 10.0F;
  REQUIRE(rig.set(config).ok());
  Spring spring;
  spring.stiffness_nm_per_rad = 1.0F;
  REQUIRE(rig.send_status(spring) == Status::ok);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  REQUIRE(rig.send_status(Stream{1, 0, 1}) == Status::ok);
  const float step = rig.get<Identity>().torque_step_nm;
  for (const int direction : {1, -1}) {
    CAPTURE(direction);
    for (int i = 0; i < 40; ++i) {
      rig.inputs.encoder_count += static_cast<std::uint32_t>(direction);
      rig.tick();
    }
    rig.tick(500);  // the brake has settled
    const Sample sample = rig.telemetry.back().sample[0];
    // The brake may hold its share; the motor gives the rest.
    const double desired = -40 * direction * 2.0 * M_PI / 8192;
    CHECK(sample.desired_torque * step == Approx(desired).scale(0).epsilon(1e-3));
    CHECK(sample.brake_capacity * step == Approx(0.5 * std::abs(desired)).scale(0).epsilon(2e-3));
    CHECK(sample.spring_torque * desired > 0);
    CHECK((sample.spring_torque + sample.motor_command) * step ==
          Approx(desired).scale(0).epsilon(1e-3));
    rig.inputs.encoder_count -= static_cast<std::uint32_t>(40 * direction);
    rig.tick(500);
  }
}

TEST_CASE("a slot that plays again after a pause begins anew") {
  Rig rig;
  arm_at_once(rig);
  Ramp ramp;
  ramp.end_torque_nm = 0.05F;
  ramp.timing.duration_s = 0.1F;
  REQUIRE(rig.send_status(ramp) == Status::ok);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  rig.tick(80);
  REQUIRE(rig.send_status(Commit{2, 0, 0}) == Status::ok);
  rig.tick(10);
  REQUIRE(rig.send_status(Commit{3, 0, 1}) == Status::ok);
  CHECK(rig.outputs.motor_command_nm < 0.005F);
}

TEST_CASE("a host that does not read loses samples, which are counted, and no acknowledgement") {
  Rig rig;
  REQUIRE(rig.send_status(Stream{1, 0, 1}) == Status::ok);
  for (int i = 0; i < 500; ++i) {
    rig.device->service();
    rig.outputs = rig.device->tick(rig.inputs);
  }
  CHECK(rig.get<Health>().samples_dropped > 400);
  rig.telemetry.clear();
  CHECK(rig.command(Op::arm) == Status::ok);
  rig.tick(20);
  bool gap = false;
  for (std::size_t i = 1; i < rig.telemetry.size(); ++i) {
    gap |= rig.telemetry[i].tick >
           rig.telemetry[i - 1].tick + samples_of(rig.telemetry[i - 1].axis_samples);
  }
  CHECK(gap);
}

TEST_CASE("the clock counts on past 32 bits") {
  torsio::device::BoardInfo board;
  board.control_period_ns = 50'000;
  Rig rig(board);
  for (int i = 0; i < 3; ++i) {
    rig.inputs.missed_ticks = 0xFFFFFFF0U;
    rig.tick();
  }
  CHECK(rig.get<Clock>().tick == 3 * (std::uint64_t{0xFFFFFFF0U} + 1));
  CHECK(rig.get<Clock>().time_ns == 3 * (std::uint64_t{0xFFFFFFF0U} + 1) * 50'000);
}

TEST_CASE("random reports never arm, never move and never stop the device") {
  Rig rig;
  std::mt19937_64 random(6);
  for (int i = 0; i < 20'000; ++i) {
    ReportBytes bytes;
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (i % 2 == 0) bytes[0] = static_cast<std::uint8_t>(0x10 + random() % 0x20);
    const auto length = static_cast<std::size_t>(i % 3 == 0 ? random() % 65 : report_size);
    (void)rig.device->receive(std::span(bytes).first(length));
    (void)rig.device->set_feature(std::span(bytes).first(length));
    rig.tick();
    REQUIRE_FALSE(rig.outputs.enabled);
  }
  CHECK(rig.get<Clock>().tick == 20'000);
  CHECK(rig.get<Health>().reports_accepted == 0);
}

TEST_CASE("a stream has a sample in every so many ticks as it was asked for") {
  Rig rig;
  for (const std::uint8_t every : {std::uint8_t{1}, std::uint8_t{5}}) {
    REQUIRE(rig.send_status(Stream{1, 0, every}) == Status::ok);
    rig.telemetry.clear();
    rig.tick(200);
    REQUIRE(rig.telemetry.size() > 3);
    CHECK((rig.telemetry[3].tick - rig.telemetry[2].tick) % every == 0);
  }
}
