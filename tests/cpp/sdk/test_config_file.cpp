// A knob's configuration as JSON, read by another library's parser and written by hand.
// tests/python/test_config_file.py has bad texts.
#include <doctest/doctest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "protocol/reports.hpp"
#include "sdk/errors.hpp"
#include "sdk/wrapped_transport.hpp"
#include "torsio/config_file.hpp"

using namespace torsio;
using nlohmann::json;
using test::contains;
using test::message_of;

TEST_CASE("a configuration is dumped with all its fields, as JSON") {
  Knob knob = Knob::open("emulated");
  knob.update([](ControlConfig& config) {
    config.law = Law::calibrated;
    config.motor_torque_cap_nm = 0.1 + 0.2;
    config.autonomous = true;
  });
  knob.update([](BoardConfig& config) { config.motor_resistance_ohm = 1e3; });
  const json found = json::parse(dump_config(knob));
  CHECK(found.size() == 6);
  CHECK(found.at("actuator_config").size() == 17);
  CHECK(found.at("control_config").size() == 12);
  CHECK(found.at("board_config").size() == 26);
  CHECK(found.at("actuator_config").at("counts_per_rev").is_number_integer());
  CHECK(found.at("actuator_config").at("counts_per_rev") == 8192);
  CHECK(found.at("control_config").at("law") == "calibrated");
  CHECK(found.at("control_config").at("autonomous") == true);
  // As the device has it, which keeps single precision.
  CHECK(found.at("control_config").at("motor_torque_cap_nm").get<double>() ==
        knob.control_config().motor_torque_cap_nm);
  CHECK(found.at("control_config").at("brake_torque_cap_nm").is_number_float());
  CHECK(found.at("board_config").at("motor_resistance_ohm") == 1e3);
  CHECK(found.at("game_config").at("dial_use") == "wheel");
}

TEST_CASE("what a text names is set and saved, and the rest stays") {
  Knob knob = Knob::open("emulated:config-file");
  knob.update([](ControlConfig& config) { config.beta = 0.25; });
  load_config(knob, R"( {"control_config" : {"law":"compensated","watchdog_s":2e-1},
    "board_config": {"confirmed": true, "light_pin": 22, "supply_v": 24},
    "game_config": {} }
  )");
  CHECK(knob.control_config().law == Law::compensated);
  CHECK(knob.control_config().watchdog_s == doctest::Approx(0.2));
  CHECK(knob.control_config().beta == 0.25);
  CHECK(knob.board_config().confirmed);
  CHECK(knob.board_config().light_pin == 22);
  CHECK(knob.board_config().supply_v == 24.0);
  CHECK(knob.health().saves == 1);
  load_config(knob, "\xEF\xBB\xBF{}");  // as Notepad begins
  Knob other = Knob::open("emulated");
  load_config(other, dump_config(knob));
  CHECK(dump_config(other) == dump_config(knob));
}

TEST_CASE(
    "what is known of values is loaded behind them, wherever it stands, and undone with them") {
  Knob knob = Knob::open("emulated");
  load_config(knob, R"({"calibration_config": {"values_are": "stated"},
    "actuator_config": {"knob_inertia_kg_m2": 7e-5}})");
  CHECK(knob.calibration_config().values_are == Basis::stated);
  // Each value is in range, but no pin may have two jobs.
  CHECK_THROWS_AS(load_config(knob, R"({"actuator_config": {"knob_inertia_kg_m2": 9e-5},
    "board_config": {"light_pin": 10, "enable_pin": 10}})"),
                  Error);
  CHECK(knob.actuator_config().knob_inertia_kg_m2 == doctest::Approx(7e-5));
  CHECK(knob.calibration_config().values_are == Basis::stated);
}

TEST_CASE("the index's pin and a pin of the board change places in one text, or neither moves") {
  Knob knob = Knob::open("emulated");
  const int light = knob.board_config().light_pin;
  load_config(knob, R"({"actuator_config": {"encoder_index_pin": 4}})");
  const std::string swapped = R"({"actuator_config": {"encoder_index_pin": )" +
                              std::to_string(light) + R"(}, "board_config": {"light_pin": 4)";
  const std::string before = dump_config(knob);
  CHECK(contains(message_of<InvalidArgument>([&] {
                   load_config(knob, swapped + R"(}, "shaft_config": {"knee_2_rad": 1.0}})");
                 }),
                 "no knee before it"));
  CHECK(dump_config(knob) == before);
  load_config(knob, swapped + "}}");
  CHECK(knob.actuator_config().encoder_index_pin == light);
  CHECK(knob.board_config().light_pin == 4);
  CHECK(contains(message_of<InvalidArgument>([&] {
                   load_config(knob, R"({"actuator_config": {"encoder_index_pin": 4}})");
                 }),
                 "encoder_index_pin is 4: this pin has another job"));
  CHECK(knob.actuator_config().encoder_index_pin == light);
}

namespace {

/// An interruption of the program, such as KeyboardInterrupt: no error of the library.
struct Ended {};

/// Interrupts the program once the device has taken a board's configuration, and again at the next
/// configuration.
class Interrupting final : public test::WrappedTransport {
 public:
  using WrappedTransport::WrappedTransport;

  bool set_feature(const ReportBytes& report) override {
    const bool taken = WrappedTransport::set_feature(report);
    if (report[0] == protocol::Layout<protocol::BoardConfig>::id) left_ = 2;
    if (left_ == 0) return taken;
    --left_;
    throw Ended{};
  }

 private:
  int left_ = 0;
};

}  // namespace

TEST_CASE("whatever ends a loading, and its undoing again, everything is as before") {
  Knob knob = Knob::open(std::make_unique<Interrupting>(open_transport("emulated")));
  const std::string before = dump_config(knob);
  CHECK_THROWS_AS(load_config(knob, R"({"actuator_config": {"knob_inertia_kg_m2": 9e-5},
    "control_config": {"beta": 0.75}, "board_config": {"light_pin": 22}})"),
                  Ended);
  knob.sleep(0.01);  // the last order was not waited for either
  CHECK(dump_config(knob) == before);
  CHECK(knob.health().saves == 0);
}

TEST_CASE("a text that is cut off or damaged anywhere is told, or is another one") {
  Knob knob = Knob::open("emulated");
  const std::string good = dump_config(knob);
  for (std::size_t size = 0; size + 2 < good.size(); ++size) {
    CAPTURE(size);
    CHECK_THROWS_AS(load_config(knob, good.substr(0, size)), InvalidArgument);
  }
  CHECK(dump_config(knob) == good);
  for (const char other : {'"', '\\', '{', '}', ',', '9', 'e', '\0', '\xFF'}) {
    for (std::size_t at = 0; at < good.size(); at += 7) {
      std::string text = good;
      text[at] = other;
      try {
        load_config(knob, text);
      } catch (const InvalidArgument&) {
        continue;
      }
      CHECK(json::parse(dump_config(knob)).size() == 6);
    }
  }
}

TEST_CASE("a text that says what cannot be is told as what it is, and changes nothing") {
  Knob knob = Knob::open("emulated");
  const std::string before = dump_config(knob);
  const auto refused = [&](const std::string& text, const std::string& why) {
    CAPTURE(text);
    CHECK(contains(message_of<InvalidArgument>([&] { load_config(knob, text); }), why));
    CHECK(dump_config(knob) == before);
  };
  refused("{\"control_config\": {\"beta\": 0.75}}\n x", "line 2 is no text of");
  refused(R"({"control_config": {"law": "calibrated\}})", "no text of");
  refused(R"({"control_config": {"beta": -}})", "no text of");
  refused(R"({"control_config": {"beta": inf}})", "no text of");
  refused(R"({"control_config": {"beta": -nan}})", "no text of");
  refused(R"({"control_config": {"beta": 1e999}})", "no text of");
  refused(R"({"control_config": {"betta": 0.75}})", "no field 'betta'");
  refused(R"({"knob_config": {}})", "no configuration 'knob_config'");
  refused(R"({"board_config": {"light_pin": 1.5}})", "whole number");
  refused(R"({"board_config": {"light_pin": 1e20}})", "whole number");
  refused(R"({"board_config": {"light_pin": -1e20}})", "whole number");
  // Also the parts that were set before the refused one.
  refused(R"({"control_config": {"beta": 0.75}, "board_config": {"light_pin": 200}})", "light_pin");
  CHECK(knob.health().saves == 0);
}

TEST_CASE("nothing is loaded while somebody has the actuator") {
  Knob knob = Knob::open("emulated");
  knob.arm();
  CHECK_THROWS_AS(load_config(knob, R"({"control_config": {"beta": 0.75}})"), Refused);
  CHECK(knob.control_config().beta == 0.5);
}
