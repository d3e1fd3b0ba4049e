// Values just beyond a limit, and a host that reads nothing.
#include <cstdint>
#include <vector>

#include "device/rig.hpp"

using namespace torsio::protocol;
using torsio::test::Rig;

TEST_CASE("a counter of one turn and no more is refused: half a turn would be half a turn back") {
  Rig rig;
  ActuatorConfig config;
  config.counter_bits = 16;
  config.counts_per_rev = 65'536;
  CHECK(rig.set(config) ==
        Verdict{Status::inconsistent, field_index<ActuatorConfig>("counter_bits")});
  config.counts_per_rev = 65'534;
  CHECK(rig.set(config).ok());
}

TEST_CASE("a curve of less than two counts is refused") {
  Rig rig;
  Curve curve;
  curve.points = 2;
  curve.span_turns_q32 = (std::uint64_t{1} << 33) / 8192;  // two of 8192 counts
  CHECK(rig.send_status(curve) == Status::ok);
  --curve.span_turns_q32;
  const Acknowledgement answer = rig.send(curve);
  CHECK(rig.status(answer) == Status::out_of_range);
  CHECK(answer.field == field_index<Curve>("span_turns_q32"));
}

TEST_CASE("only the compensated law counts the drag of a brake without current") {
  // docs/explanation/theory.md, table of laws: bound of the sensor.
  for (const Law law : {Law::paper, Law::compensated, Law::parallel, Law::motor_only}) {
    CAPTURE(static_cast<int>(law));
    Rig rig;
    ActuatorConfig actuator;
    actuator.brake_drag_nm = 0.02F;
    actuator.brake_torque_min_nm = 0.001F;
    REQUIRE(rig.set(actuator).ok());
    ControlConfig control;
    control.law = law;
    REQUIRE(rig.set(control).ok());
    REQUIRE(rig.send_status(Stream{1, 0, 1}) == Status::ok);
    for (int i = 0; i < 400; ++i) {
      rig.inputs.encoder_count += 50;  // far beyond what the shaft's spring can be wound up
      rig.tick();
    }
    REQUIRE_FALSE(rig.telemetry.empty());
    const double slips_at = -rig.telemetry.back().sample[0].spring_torque *
                            static_cast<double>(rig.get<Identity>().torque_step_nm);
    CHECK(slips_at ==
          doctest::Approx(law == Law::compensated ? 0.02 : 0.001).scale(0).epsilon(0.02));
  }
}

TEST_CASE("a host that reads nothing for long gets an answer to each report once it reads") {
  for (const int first : {0, 1, 2, 3}) {
    Rig rig;
    std::vector<std::uint16_t> answered;
    const auto read = [&](int ticks) {
      for (int i = 0; i < ticks; ++i) {
        rig.device->service();
        (void)rig.device->tick(rig.inputs);
        ReportBytes bytes;
        Acknowledgement answer;
        while (rig.device->next_input(bytes)) {
          if (decode(bytes, answer).ok()) answered.push_back(answer.sequence);
        }
      }
    };
    std::uint16_t sent = 0;
    const auto send = [&](Op op) {
      if (rig.device->receive(encode(Command{static_cast<std::uint16_t>(sent + 1), 0, op}))) {
        ++sent;
      }
      rig.device->service();
      (void)rig.device->tick(rig.inputs);
    };
    // Some with one answer, then such with an event as well.
    for (int i = 0; i < first; ++i) send(Op::disarm);
    for (int i = 0; i < 100; ++i) send(i % 2 == 0 ? Op::arm : Op::disarm);
    read(300);
    REQUIRE(answered.size() == sent);
    for (std::size_t i = 0; i < answered.size(); ++i) CHECK(answered[i] == i + 1);
  }
}
