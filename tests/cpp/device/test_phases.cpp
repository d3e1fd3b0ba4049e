// Every phase of the control loop meets every event. The results are in the table of
// docs/explanation/architecture.md.
#include <doctest/doctest.h>

#include <array>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "device/control_loop.hpp"
#include "device/dial/detents.hpp"
#include "device/game/forces.hpp"

using namespace torsio;
using device::ControlLoop;
using device::Order;
using device::Phase;

namespace {

/// Columns of the table: each phase, and one for what a game or the dial plays.
const std::vector<std::string> kNames{"disarmed",      "fault",   "rising",    "playing",
                                      "another plays", "passive", "letting go"};

/// A knob for games or a dial. The SDK's host may be silent for 10 ticks, torque rises and fades in
/// 20, and letting go takes 40.
struct PhasedLoop {
  explicit PhasedLoop(bool dial, float ramp_s = 2e-3F) {
    device::Config config;
    config.control.law = protocol::Law::motor_only;
    config.control.passive_ramp_s = ramp_s;
    config.control.watchdog_s = 1e-3F;
    settings = device::make_loop_config(config, 100'000);
    loop =
        std::make_unique<ControlLoop>(settings, dial ? static_cast<device::Guest&>(detents) : game);
    tick();
  }

  void tick(int count = 1) {
    for (; count > 0; --count) loop->tick(in);
  }
  /// Nobody is served while the device lets go: the order before it still waits.
  void give(Order order) {
    if (loop->takes_order()) loop->give(order);
    tick();
  }
  void give(Order::Kind kind) {
    Order order;
    order.kind = kind;
    give(order);
  }
  void fail() {
    in.emergency_stop = true;
    tick();
    in.emergency_stop = false;
    tick();
  }
  void lose_power() {
    in.actuator_fault = true;
    in.power_faults = protocol::fault::supply;
    tick();
    in = {};
    tick(2);
  }

  void live(int ticks) {
    for (; ticks > 0; --ticks) give(Order::Kind::keep_alive);
  }
  void order_game(const device::game::ForceOrder& order) {
    REQUIRE(game.give(order));
    tick();
  }
  std::string name() const {
    const bool another = loop->now().owner > protocol::Owner::sdk;
    const auto phase = static_cast<std::size_t>(loop->phase());
    if (loop->phase() < Phase::playing) return kNames[phase];
    return loop->phase() == Phase::playing && another ? kNames[4]
                                                      : kNames[phase + (phase > 3 ? 1 : 0)];
  }

  void bring_into(const std::string& phase, bool by_sdk) {
    if (phase == "fault") fail();
    if (phase == "disarmed" || phase == "fault") return;
    if (by_sdk) {
      give(Order::Kind::arm);
      if (phase != "rising") live(25);
    } else {
      play();
    }
    if (phase == "passive") pull_the_cable();
    if (phase == "letting go") give(Order::Kind::disarm);
  }
  void play() {
    if (loop->guest.name == protocol::Owner::dial) {
      loop->guest.want(true);
      return tick();
    }
    device::game::ForceOrder start;
    start.play = device::game::ForceOrder::Play::start;
    order_game(start);
  }
  void play_no_more() {
    loop->guest.want(false);
    device::game::ForceOrder off;
    off.kind = device::game::ForceOrder::Kind::settings;
    off.enabled = false;
    order_game(off);
    tick(3);
  }
  void pull_the_cable() {
    loop->set_connected(false);
    tick();
    loop->set_connected(true);
  }

  device::LoopConfig settings;
  device::game::Forces game{{.idle_ticks = 1000}};
  device::dial::Detents detents{{}};
  std::unique_ptr<ControlLoop> loop;
  device::TickInputs in;
};

using Happening = std::function<void(PhasedLoop&)>;

const std::map<std::string, std::vector<Happening>> kEvents{
    {"the SDK arms", {[](PhasedLoop& loop) { loop.give(Order::Kind::arm); }}},
    {"a game or the dial begins", {[](PhasedLoop& loop) { loop.play(); }}},
    {"a game or the dial ends", {[](PhasedLoop& loop) { loop.play_no_more(); }}},
    {"`disarm` or `stop`",
     {[](PhasedLoop& loop) { loop.give(Order::Kind::disarm); },
      [](PhasedLoop& loop) { loop.give(Order::Kind::stop); }}},
    {"host silent", {[](PhasedLoop& loop) { loop.tick(12); }}},
    {"host gone", {[](PhasedLoop& loop) { loop.pull_the_cable(); }}},
    {"a local model is late", {[](PhasedLoop& loop) {
       Order order;
       order.kind = Order::Kind::local_model;
       order.sequence = 1;
       order.deadline_ticks = 1;
       loop.give(order);
       loop.tick(1);
     }}},
    {"an experiment ends", {[](PhasedLoop& loop) {
       Order order;
       order.kind = Order::Kind::excite;
       order.excitation.duration_ticks = 1;
       order.excitation.travel_counts = 1000;
       order.excitation.speed_limit_rad_s = 1000;
       order.excitation.torque_limit_nm = 1;
       loop.give(order);
       loop.tick(2);
     }}},
    {"the ramp is over", {[](PhasedLoop& loop) { loop.live(41); }}},
    {"a fault's cause appears", {[](PhasedLoop& loop) { loop.fail(); }}},
    {"the supply fails and returns", {[](PhasedLoop& loop) { loop.lose_power(); }}},
    {"`clear_fault`", {[](PhasedLoop& loop) { loop.give(Order::Kind::clear_fault); }}},
};

/// The cells of a row of a table in Markdown.
std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> found;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, '|');) {
    const auto begin = cell.find_first_not_of(' ');
    if (begin == std::string::npos) continue;
    found.push_back(cell.substr(begin, cell.find_last_not_of(' ') + 1 - begin));
  }
  return found;
}

/// Event -> the next phase, from each phase.
std::map<std::string, std::vector<std::string>> table() {
  std::ifstream file(TORSIO_TEST_DATA_DIR "/../../docs/explanation/architecture.md");
  REQUIRE(file.good());
  std::map<std::string, std::vector<std::string>> rows;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("| event | disarmed |")) {
      inside = true;
      REQUIRE(cells(line).size() == kNames.size() + 1);
      for (std::size_t i = 0; i < kNames.size(); ++i) REQUIRE(cells(line)[i + 1] == kNames[i]);
    } else if (inside && line.empty()) {
      break;
    } else if (inside && !line.starts_with("|--")) {
      std::vector<std::string> row = cells(line);
      REQUIRE(row.size() == kNames.size() + 1);
      const std::string event = row.front();
      row.erase(row.begin());
      rows[event] = row;
    }
  }
  return rows;
}

}  // namespace

TEST_CASE("every phase does with every event what the table of the architecture says") {
  const auto rows = table();
  REQUIRE(rows.size() == kEvents.size());
  for (const auto& [event, ways] : kEvents) {
    CAPTURE(event);
    REQUIRE(rows.contains(event));
    for (std::size_t i = 0; i < 4 * kNames.size() * ways.size(); ++i) {
      const std::size_t column = i / 4 % kNames.size();
      const std::string& phase = kNames[column];
      const bool dial = i % 2 != 0;
      const bool by_sdk = i % 4 < 2;
      if (by_sdk && phase == "another plays") continue;
      if (!by_sdk && (phase == "rising" || phase == "playing")) continue;
      CAPTURE(phase);
      CAPTURE(dial);
      CAPTURE(by_sdk);
      PhasedLoop loop{dial};
      loop.bring_into(phase, by_sdk);
      REQUIRE(loop.name() == phase);
      ways[i / 4 / kNames.size()](loop);
      const std::string told = rows.at(event)[column];
      CHECK(loop.name() == (told == "=" ? phase : told));
      CHECK(loop.loop->mail.samples.empty());  // nobody streams
    }
  }
}

TEST_CASE("without a ramp the torque is there at once") {
  PhasedLoop loop{false, 0.0F};
  loop.give(Order::Kind::arm);
  CHECK(loop.name() == "playing");
}
