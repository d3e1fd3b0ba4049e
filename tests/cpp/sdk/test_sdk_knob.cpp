// Life of a knob on the emulated transport: opening, states, configuration, unplugging, closing.
#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "sdk/errors.hpp"
#include "torsio/knob.hpp"

using namespace torsio;
using test::contains;
using test::message_of;

TEST_CASE("the emulated knob says who it is") {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->control_rate_hz = 10e3;
  options.emulator->serial = "BENCH-7";
  const Knob knob = Knob::open("emulated", options);
  const DeviceInfo info = knob.info();
  CHECK(info.path == "emulated");
  CHECK(info.serial == "BENCH-7");
  CHECK(info.board == "emulated");
  CHECK(info.transport == "emulated");
  CHECK(info.control_rate_hz == 10e3);
  CHECK(info.counts_per_rev == 8192);
  CHECK(info.effects == 16);
  CHECK(info.curve_points == 1024);
  CHECK_FALSE(info.firmware_version.empty());
  CHECK(knob.is_emulated());
}

TEST_CASE("a knob starts disarmed and follows arm, disarm and stop") {
  Knob knob = Knob::open("emulated");
  CHECK(knob.state() == State::disarmed);
  knob.arm();
  CHECK(knob.state() == State::armed);
  knob.arm();  // twice is fine
  knob.disarm();
  CHECK(knob.state() == State::disarmed);
  knob.arm();
  knob.stop();
  CHECK(knob.state() == State::disarmed);
  CHECK(knob.health().state == State::disarmed);
}

TEST_CASE("commands in the wrong state are Refused with the reason, and change nothing") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  const std::vector<void (Knob::*)()> only_disarmed{&Knob::zero, &Knob::relax, &Knob::save,
                                                    &Knob::load_defaults};
  for (const auto command : only_disarmed) {
    try {
      (knob.*command)();
      FAIL("no error");
    } catch (const Refused& refused) {
      CHECK(refused.status() == "not_disarmed");
      CHECK(refused.report() == "command");
      CHECK(contains(refused.what(), "disarm()"));
    }
  }
  CHECK_THROWS_AS(knob.configure(ControlConfig{}), Refused);
  CHECK_THROWS_AS(knob.configure(ActuatorConfig{}), Refused);
  CHECK(knob.state() == State::armed);
}

TEST_CASE("zero makes this position angle 0") {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->hand = PrescribedMotion{{{0.0, 0.0}, {0.1, 1.0}}};
  Knob knob = Knob::open("emulated", options);
  knob.sleep(0.2);
  CHECK(knob.position_rad() == doctest::Approx(1.0).scale(0).epsilon(1e-3));
  knob.zero();
  CHECK(knob.position_rad() == 0.0);
  CHECK(knob.record(0.01).back().angle_rad == 0.0);
}

TEST_CASE("a fault latches, has a name, and is cleared once its cause is gone") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  knob.emulator().set_emergency_stop(true);
  CHECK(knob.wait_for(State::fault, 0.1));
  CHECK(knob.faults() == std::vector<std::string>{"emergency_stop"});
  CHECK(contains(message_of<Refused>([&] { knob.arm(); }), "fault_latched"));
  CHECK(contains(message_of<Refused>([&] { knob.clear_fault(); }), "fault_persists"));
  knob.emulator().set_emergency_stop(false);
  knob.sleep(0.01);
  knob.clear_fault();
  CHECK(knob.faults().empty());
  knob.arm();
  CHECK(knob.state() == State::armed);
}

TEST_CASE(
    "a board's wiring comes back as it was set, and one that cannot work is refused by name") {
  Knob knob = Knob::open("emulated");
  CHECK(knob.board_config().motor_pin == 6);
  BoardConfig board;
  board.motor_pin = 14;
  board.supply_v = 24.0;
  board.motor_reversed = true;
  knob.configure(board);
  CHECK(knob.board_config().motor_pin == 14);
  CHECK(knob.board_config().supply_v == 24.0);
  CHECK(knob.board_config().motor_reversed);

  const auto complaint = [&](auto change) {
    BoardConfig wrong;
    change(wrong);
    return message_of<InvalidArgument>([&] { knob.configure(wrong); });
  };
  CHECK(contains(complaint([](BoardConfig& c) { c.supply_v = 2.0; }),
                 "supply_v is 2, allowed are 3 to 60 V"));
  CHECK(contains(complaint([](BoardConfig& c) { c.motor_pin = 7; }),
                 "motor_pin is 7: a bridge's first pin must be even"));
  CHECK(contains(complaint([](BoardConfig& c) { c.light_pin = -1; }), "light_pin is -1"));
  CHECK(contains(complaint([](BoardConfig& c) { c.light_pin = 266; }), "light_pin is 266"));
  CHECK(contains(complaint([](BoardConfig& c) { c.current_sense_pin = 25; }),
                 "current_sense_pin is 25, allowed are 26 to 28"));
  CHECK(contains(complaint([](BoardConfig& c) { c.brake_pin = 22; }),
                 "brake_pin is 22: the motor has this PWM unit"));
  CHECK(contains(complaint([](BoardConfig& c) { c.motor_pin = 2; }),
                 "motor_pin is 2: this pin has another job"));
  CHECK(contains(complaint([](BoardConfig& c) { c.encoder_pin = 22; }),
                 "encoder_pin is 22: the next pin has another job"));
  CHECK(contains(complaint([](BoardConfig& c) { c.supply_sense_pin = 22; }),
                 "supply_sense_pin is 22: only GP26, GP27 and GP28 can measure"));
  CHECK(contains(complaint([](BoardConfig& c) { c.supply_sense_pin = 26; }),
                 "supply_sense_pin is 26: this pin has another job"));
  CHECK(contains(complaint([](BoardConfig& c) { c.light_pin = 3; }),
                 "light_pin is 3: this pin has another job"));
  CHECK(knob.board_config().motor_pin == 14);

  knob.arm();
  CHECK_THROWS_AS(knob.configure(BoardConfig{}), Refused);
}

TEST_CASE("configuration comes back as it was set, and bad values are refused by name") {
  Knob knob = Knob::open("emulated");
  ControlConfig control = knob.control_config();
  CHECK(control.beta == 0.5);
  CHECK(control.watchdog_s == 0.25);
  control.law = Law::compensated;
  control.beta = 0.1;
  control.autonomous = true;
  knob.configure(control);
  CHECK(knob.control_config().law == Law::compensated);
  CHECK(knob.control_config().beta == 0.1);
  CHECK(knob.control_config().autonomous);

  ActuatorConfig actuator = knob.actuator_config();
  CHECK(actuator.spring_stiffness_nm_per_rad == 2.873);
  actuator.counts_per_rev = 4096;
  actuator.encoder_reversed = true;
  knob.configure(actuator);
  CHECK(knob.actuator_config().counts_per_rev == 4096);
  CHECK(knob.actuator_config().encoder_reversed);
  CHECK(knob.info().counts_per_rev == 4096);

  control.beta = 1.5;
  CHECK(contains(message_of<InvalidArgument>([&] { knob.configure(control); }),
                 "beta is 1.5, allowed are 0 to 1"));
  actuator.counter_bits = 33;
  CHECK(contains(message_of<InvalidArgument>([&] { knob.configure(actuator); }),
                 "counter_bits is 33"));
  actuator.counter_bits = 8;
  CHECK(contains(message_of<InvalidArgument>([&] { knob.configure(actuator); }),
                 "too few for counts_per_rev"));
  CHECK(knob.control_config().beta == 0.1);

  knob.load_defaults();
  CHECK(knob.control_config().beta == 0.5);
  CHECK(knob.info().counts_per_rev == 8192);
}

TEST_CASE("update changes what it is told to and keeps the rest, in each configuration") {
  Knob knob = Knob::open("emulated");
  knob.update([](ControlConfig& config) { config.motor_torque_cap_nm = 0.04; });
  knob.update([](ControlConfig& config) { config.law = Law::compensated; });
  CHECK(knob.control_config().law == Law::compensated);
  CHECK(knob.control_config().motor_torque_cap_nm == 0.04);
  knob.update([](ActuatorConfig& config) { config.counts_per_rev = 4096; });
  CHECK(knob.actuator_config().counts_per_rev == 4096);
  CHECK(knob.info().counts_per_rev == 4096);
  knob.update([](BoardConfig& config) { config.supply_v = 24.0; });
  CHECK(knob.board_config().supply_v == 24.0);
  knob.update([](GameConfig& config) { config.gain = 0.5; });
  CHECK(knob.game_config().gain == 0.5);
  CHECK(knob.game_config().range_deg == 900.0);
  CHECK(contains(message_of<InvalidArgument>(
                     [&] { knob.update([](ControlConfig& config) { config.beta = 1.5; }); }),
                 "beta is 1.5"));
  knob.arm();
  CHECK_THROWS_AS(knob.update([](GameConfig& config) { config.gain = 0.1; }), Refused);
}

TEST_CASE("a named emulated knob keeps what was saved, and only that") {
  const std::string selector = "emulated:keeps";
  const auto set_beta = [](Knob& knob, double beta) {
    knob.update([&](ControlConfig& config) { config.beta = beta; });
  };
  {
    Knob knob = Knob::open(selector);
    CHECK(knob.info().serial == "keeps");
    set_beta(knob, 0.25);
    knob.save();
    set_beta(knob, 0.75);
  }
  {
    Knob knob = Knob::open(selector);
    CHECK(knob.control_config().beta == 0.25);
    CHECK(knob.health().saves == 1);
    set_beta(knob, 0.75);
    knob.emulator().cut_power_in_next_save(100);
    CHECK_THROWS_AS(knob.save(), Disconnected);
  }
  CHECK(Knob::open(selector).control_config().beta == 0.25);
  CHECK(Knob::open("emulated").control_config().beta == 0.5);
}

TEST_CASE("a selector or serial number that cannot be one is InvalidArgument, and not echoed") {
  const std::string longest(255, 'x');
  CHECK_THROWS_AS((void)Knob::open(longest), DeviceNotFound);
  const std::string with_nul("TS\0-1", 5);
  OpenOptions options{.emulator = EmulatorOptions{}};
  for (const std::string& name : {longest + "x", "emulated:" + longest, with_nul}) {
    const std::string message = message_of<InvalidArgument>([&] { (void)Knob::open(name); });
    CHECK(contains(message, "selector"));
    CHECK(message.size() < 100);
    options.emulator->serial = name;
    const std::string about_serial =
        message_of<InvalidArgument>([&] { (void)Knob::open("emulated", options); });
    CHECK(contains(about_serial, "serial"));
    CHECK(about_serial.size() < 100);
  }
}

TEST_CASE("a named emulated knob can be open once, an unnamed one as often as one likes") {
  Knob first = Knob::open("emulated:once");
  CHECK(contains(message_of<DeviceBusy>([] { (void)Knob::open("emulated:once"); }),
                 "emulated:once is open already"));
  const Knob other = Knob::open("emulated:other");
  const Knob one = Knob::open("emulated");
  const Knob two = Knob::open("emulated");
  first.close();
  CHECK(Knob::open("emulated:once").is_open());
}

TEST_CASE("bad options are InvalidArgument, and leave the name free") {
  const auto message = [](auto&& change, const std::string& selector = "emulated:options") {
    OpenOptions options{.emulator = EmulatorOptions{}};
    change(options);
    return message_of<InvalidArgument>([&] { (void)Knob::open(selector, options); });
  };
  const auto nothing = [](OpenOptions&) {};
  CHECK(contains(message(nothing, "emulated:"), "lacks a name"));
  CHECK(contains(message(nothing, "emulated:no spaces"), "no spaces"));
  CHECK(contains(message([](auto& o) { o.emulator->control_rate_hz = 500; }),
                 "control_rate_hz is 500, allowed are 1000 to 20000 Hz"));
  CHECK(contains(message([](auto& o) { o.emulator->plant.knob_inertia_kg_m2 = 0; }),
                 "knob_inertia_kg_m2"));
  CHECK(contains(message([](auto& o) { o.emulator->hand = TorqueHand{{}}; }), "knot"));
  CHECK(contains(message([](auto& o) { o.emulator->serial = "a serial number too long"; }),
                 "serial"));
  CHECK(
      contains(message([](auto& o) { o.emulator->control = ControlConfig{.beta = -1}; }), "beta"));
  CHECK(contains(message([](auto& o) { o.command_timeout_s = -1; }), "command_timeout_s is -1"));
  CHECK(Knob::open("emulated:options").is_open());
}

TEST_CASE("a plant and a configuration can be given, and one made to match the other") {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->plant.counts_per_rev = 32768;
  options.emulator->plant.shaft_stiffness_nm_per_rad = 5.0;
  options.emulator->actuator = matching_config(options.emulator->plant);
  options.emulator->control = ControlConfig{.law = Law::motor_only};
  options.emulator->hand = PrescribedMotion{{{0.0, 0.0}, {0.1, 1.0}}};
  Knob knob = Knob::open("emulated", options);
  CHECK(knob.info().counts_per_rev == 32768);
  CHECK(knob.actuator_config().spring_stiffness_nm_per_rad == 5.0);
  CHECK(knob.control_config().law == Law::motor_only);
  knob.sleep(0.2);
  CHECK(knob.position_rad() == doctest::Approx(1.0).scale(0).epsilon(1e-3));
}

TEST_CASE("an unplug in any state is a state and an exception that says what to do") {
  enum class When { disarmed, armed, playing, faulty, streaming };
  for (const When when :
       {When::disarmed, When::armed, When::playing, When::faulty, When::streaming}) {
    CAPTURE(static_cast<int>(when));
    Knob knob = Knob::open("emulated");
    if (when != When::disarmed) knob.arm();
    if (when == When::playing) knob.play(Wall{.stiffness_nm_per_rad = 1});
    if (when == When::streaming) knob.start_telemetry();
    knob.sleep(0.05);
    if (when == When::faulty) {
      knob.emulator().set_emergency_stop(true);
      knob.sleep(0.05);
    }
    knob.emulator().unplug();
    CHECK(knob.state() == State::disconnected);
    CHECK(knob.is_open());
    CHECK(contains(message_of<Disconnected>([&] { knob.arm(); }), "open it again"));
    CHECK_THROWS_AS(knob.play(Scene{}), Disconnected);
    CHECK_THROWS_AS(knob.stream_local_model({}), Disconnected);
    CHECK_THROWS_AS(knob.sleep(1.0), Disconnected);
    CHECK_THROWS_AS((void)knob.record(1.0), Disconnected);
    CHECK_THROWS_AS((void)knob.clock(), Disconnected);
    CHECK_THROWS_AS(knob.save(), Disconnected);
    CHECK_THROWS_AS((void)knob.wait_for(State::armed, 1.0), Disconnected);
    CHECK(knob.wait_for(State::disconnected, 0.0));
    if (when == When::streaming) {
      CHECK_FALSE(knob.read(1000, 0.0).empty());  // samples that arrived
      CHECK_THROWS_AS((void)knob.read(1000, 0.0), Disconnected);
    }
  }
}

TEST_CASE("closing twice is fine, and everything after it is Closed") {
  Knob knob = Knob::open("emulated");
  Emulator& world = knob.emulator();
  knob.arm();
  knob.close();
  knob.close();
  CHECK_FALSE(knob.is_open());
  CHECK(contains(message_of<Closed>([&] { knob.arm(); }), "open it again"));
  CHECK_THROWS_AS((void)knob.state(), Closed);
  CHECK_THROWS_AS((void)knob.info(), Closed);
  CHECK_THROWS_AS((void)knob.statistics(), Closed);
  CHECK_THROWS_AS(knob.play(Scene{}), Closed);
  CHECK_THROWS_AS(knob.sleep(1.0), Closed);
  CHECK_THROWS_AS(world.unplug(), Closed);
  CHECK_THROWS_AS(world.advance(1.0), Closed);
}

TEST_CASE("a knob can be moved, and the one moved from is Closed") {
  Knob first = Knob::open("emulated");
  first.arm();
  Knob second = std::move(first);
  CHECK(second.state() == State::armed);
  CHECK_THROWS_AS((void)first.state(), Closed);  // NOLINT(bugprone-use-after-move)
  first.close();
  second = Knob::open("emulated");
  CHECK(second.state() == State::disarmed);
}

TEST_CASE("a knob that nobody talks to stays armed, because the library gives signs of life") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  knob.sleep(10.0);
  CHECK(knob.state() == State::armed);
  CHECK(knob.health().state == State::armed);
  // Also one that wants them oftener, since it was told to.
  knob.disarm();
  knob.update([](ControlConfig& config) { config.watchdog_s = 0.05; });
  knob.arm();
  knob.sleep(1.0);
  CHECK(knob.health().state == State::armed);
}

TEST_CASE("reports that are lost or damaged never hang a call") {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->seed = 5;
  options.command_timeout_s = 0.05;
  Knob knob = Knob::open("emulated", options);
  knob.emulator().set_link_faults(
      {.drop_output = 0.2, .corrupt_output = 0.2, .drop_input = 0.2, .corrupt_input = 0.2});
  int done = 0;
  int failed = 0;
  for (int i = 0; i < 200; ++i) {
    try {
      knob.play(Constant{.torque_nm = 1e-4 * i});
      ++done;
    } catch (const Timeout&) {
      ++failed;
    } catch (const Refused&) {
      ++failed;
    }
  }
  CHECK(done > 10);
  CHECK(failed > 10);
  knob.emulator().set_link_faults({});
  knob.sleep(0.1);
  knob.play(Constant{.torque_nm = 0.01});
  CHECK(knob.statistics().reports_undecodable > 0);
}
