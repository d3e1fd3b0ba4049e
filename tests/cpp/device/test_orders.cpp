// Scenes and orders: a refused one changes nothing, and each is answered once.
// Each of these lines was once
// deleted without any other test noticing; tests/mutation has the list.
#include <cstdint>

#include "device/played.hpp"

using namespace torsio::protocol;
using torsio::test::at_once;
using torsio::test::count;
using torsio::test::play;
using torsio::test::Rig;

TEST_CASE("a refused commit does not touch what plays, whatever was written before it") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only)).ok());
  play(rig, 0.03F);
  Constant other;
  other.torque_nm = 0.01F;
  REQUIRE(rig.send_status(other) == Status::ok);
  const Acknowledgement refused = rig.send(Commit{2, 0, 0x8001});
  CHECK(rig.status(refused) == Status::empty_slot);
  CHECK(refused.field == field_index<Commit>("active"));
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == 0.03F);
  CHECK(rig.send_status(Commit{3, 0, 1}) == Status::ok);
  rig.tick(2);
  CHECK(rig.outputs.motor_command_nm == 0.01F);
}

TEST_CASE("a deadline shorter than a tick is still one") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only)).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  LocalModel model;
  model.sequence = 1;
  model.deadline_s = 1e-4F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick(5);
  CHECK(count(rig, EventKind::deadline_missed) == 1);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("a duration shorter than a tick is not without end") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only)).ok());
  REQUIRE(rig.command(Op::arm) == Status::ok);
  Constant constant;
  constant.torque_nm = 0.03F;
  constant.timing.duration_s = 1e-4F;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
  rig.tick(5);
  CHECK(rig.outputs.motor_command_nm == 0.0F);
}

TEST_CASE("every order is answered once and in order, however seldom the interrupt comes") {
  Rig rig;
  for (std::uint16_t i = 1; i <= 6; ++i) {
    REQUIRE(rig.device->receive(encode(Command{i, 0, Op::disarm})));
    for (int round = 0; round < 5; ++round) rig.device->service();
  }
  rig.tick(20);
  REQUIRE(rig.acknowledgements.size() == 6);
  for (std::uint16_t i = 1; i <= 6; ++i) CHECK(rig.acknowledgements[i - 1U].sequence == i);
}

TEST_CASE("what comes behind a save waits for it") {
  Rig rig;
  REQUIRE(rig.device->receive(encode(Command{1, 0, Op::save})));
  REQUIRE(rig.device->receive(encode(Command{2, 0, Op::arm})));
  rig.tick(20);
  CHECK(rig.acknowledgements.empty());
  REQUIRE(rig.device->take_slot_write());
  rig.device->storage_written();
  rig.tick(5);
  REQUIRE(rig.acknowledgements.size() == 2);
  CHECK(rig.acknowledgements[0].sequence == 1);
  CHECK(rig.status(rig.acknowledgements[1]) == Status::ok);
  CHECK(rig.state() == State::armed);
}

TEST_CASE("a setting that finds no room is refused as busy, and counted") {
  Rig rig;
  while (rig.device->receive(encode(Command{1, 0, Op::keep_alive}))) {
  }
  const std::uint32_t before = rig.get<Health>().reports_refused;
  CHECK(rig.device->set_feature(encode(ControlConfig{})).status == Status::busy);
  CHECK(rig.get<Health>().reports_refused == before + 1);
}

TEST_CASE("the way to the bootloader is asked for once") {
  torsio::device::BoardInfo board;
  board.has_bootloader = true;
  Rig rig(board);
  REQUIRE(rig.command(Op::bootloader) == Status::ok);
  CHECK(rig.device->take_bootloader_request());
  CHECK_FALSE(rig.device->take_bootloader_request());
}

TEST_CASE("a fault whose cause lasted for some ticks can be cleared at once when it is over") {
  Rig rig;
  for (int i = 0; i < 4; ++i) {
    rig.inputs.encoder_count += 4000;
    rig.tick();
  }
  REQUIRE(rig.state() == State::fault);
  rig.tick(5);
  CHECK(rig.command(Op::clear_fault) == Status::ok);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("a counter that becomes narrower is no jump") {
  Rig rig;
  for (int i = 0; i < 100; ++i) {
    rig.inputs.encoder_count += 1000;
    rig.tick();
  }
  const auto position = rig.get<Clock>().position_counts;
  ActuatorConfig actuator;
  actuator.counter_bits = 16;
  REQUIRE(rig.set(actuator).ok());
  rig.tick(3);
  CHECK(rig.get<Health>().faults == 0);
  CHECK(rig.get<Clock>().position_counts == position);
}

TEST_CASE("a wall pushes out of the side that is solid") {
  for (const Side side : {Side::above, Side::below}) {
    Rig rig;
    REQUIRE(rig.set(at_once(Law::motor_only)).ok());
    Wall wall;
    wall.side = side;
    wall.stiffness_nm_per_rad = 0.5F;
    REQUIRE(rig.send_status(wall) == Status::ok);
    REQUIRE(rig.send_status(Commit{1, 0, 1}) == Status::ok);
    REQUIRE(rig.command(Op::arm) == Status::ok);
    rig.inputs.encoder_count += static_cast<std::uint32_t>(side == Side::above ? 50 : -50);
    rig.tick(2);
    CHECK(rig.outputs.motor_command_nm * (side == Side::above ? -1.0F : 1.0F) > 0.01F);
    rig.inputs.encoder_count -= static_cast<std::uint32_t>(side == Side::above ? 100 : -100);
    rig.tick(2);
    CHECK(rig.outputs.motor_command_nm == 0.0F);
  }
}

TEST_CASE("telemetry tells a local model, and a torque that fades") {
  Rig rig;
  REQUIRE(rig.set(at_once(Law::motor_only, 0.05F)).ok());
  REQUIRE(rig.send_status(Stream{1, 0, 1}) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  rig.tick(60);
  CHECK((rig.telemetry.back().flags & (flag::local_model | flag::passive)) == 0);
  LocalModel model;
  model.sequence = 1;
  model.deadline_s = 0.05F;
  REQUIRE(rig.device->receive(encode(model)));
  rig.tick(20);
  CHECK((rig.telemetry.back().flags & flag::local_model) != 0);
  rig.tick(60);
  CHECK((rig.telemetry.back().flags & flag::passive) != 0);
}
