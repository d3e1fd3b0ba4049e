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

using namespace torsio;
using device::ControlLoop;
using device::Order;
using device::Phase;

namespace {

const std::vector<std::string> kNames{"disarmed", "fault",   "rising",
                                      "playing",  "passive", "letting go"};

/// A knob for games or a dial.
struct PhasedLoop {
  explicit PhasedLoop(bool dial) {
    device::Config config;
    config.control.law = protocol::Law::motor_only;
    config.control.passive_ramp_s = 0.02F;
    detents.on = dial;
    game.idle_ticks = 1000;
    settings = device::make_loop_config(config, 1'000'000);
    loop = std::make_unique<ControlLoop>(settings, game, detents);
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

  /// By the SDK, or by the game or dial.
  void bring_into(Phase phase, bool by_sdk) {
    if (phase == Phase::fault) fail();
    if (phase >= Phase::rising && by_sdk) give(Order::Kind::arm);
    if (phase >= Phase::rising && !by_sdk) play();
    if (phase >= Phase::playing) tick(25);
    if (phase == Phase::passive) pull_the_cable();
    if (phase == Phase::letting_go) give(Order::Kind::disarm);
    REQUIRE(loop->phase() == phase);
  }
  void play() {
    if (detents.on) {
      loop->want_dial(true);
    } else {
      device::game::ForceOrder start;
      start.play = device::game::ForceOrder::Play::start;
      REQUIRE(loop->game.give(start));
    }
    tick();
  }
  void pull_the_cable() {
    loop->set_connected(false);
    tick();
    loop->set_connected(true);
  }

  device::LoopConfig settings;
  device::game::ForceParams game;
  device::dial::DetentParams detents;
  std::unique_ptr<ControlLoop> loop;
  device::TickInputs in;
};

const std::map<std::string, std::function<void(PhasedLoop&)>> kEvents{
    {"the SDK arms", [](PhasedLoop& loop) { loop.give(Order::Kind::arm); }},
    {"a game plays, or somebody turns the dial", [](PhasedLoop& loop) { loop.play(); }},
    {"`disarm` or `stop`", [](PhasedLoop& loop) { loop.give(Order::Kind::stop); }},
    {"the host is silent or gone", [](PhasedLoop& loop) { loop.pull_the_cable(); }},
    {"a local model is late",
     [](PhasedLoop& loop) {
       Order order;
       order.kind = Order::Kind::local_model;
       order.sequence = 1;
       order.deadline_ticks = 1;
       loop.give(order);
       loop.tick(1);
     }},
    {"an experiment ends",
     [](PhasedLoop& loop) {
       Order order;
       order.kind = Order::Kind::excite;
       order.excitation.duration_ticks = 1;
       order.excitation.travel_counts = 1000;
       order.excitation.speed_limit_rad_s = 1000;
       order.excitation.torque_limit_nm = 1;
       loop.give(order);
       loop.tick(2);
     }},
    {"the ramp is over", [](PhasedLoop& loop) { loop.tick(21); }},
    {"a fault's cause appears", [](PhasedLoop& loop) { loop.fail(); }},
    {"`clear_fault`", [](PhasedLoop& loop) { loop.give(Order::Kind::clear_fault); }},
};

/// What these do while a game or the dial plays.
const std::map<std::string, std::string> kOfSdk{
    {"the SDK arms", "rising"}, {"a local model is late", "="}, {"an experiment ends", "="}};

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
  for (const auto& [event, happen] : kEvents) {
    REQUIRE(rows.contains(event));
    for (std::size_t i = 0; i < 4 * kNames.size(); ++i) {
      const auto phase = static_cast<Phase>(i / 4);
      const bool dial = i % 2 != 0;
      const bool by_sdk = i % 4 < 2;
      // A game and the dial begin at once.
      if (!by_sdk && phase < Phase::playing) continue;
      PhasedLoop loop{dial};
      loop.bring_into(phase, by_sdk);
      happen(loop);
      std::string told = rows.at(event)[i / 4];
      if (!by_sdk && kOfSdk.contains(event))
        told = phase == Phase::playing ? kOfSdk.at(event) : "=";
      CAPTURE(event);
      CAPTURE(kNames[i / 4]);
      CAPTURE(dial);
      CAPTURE(by_sdk);
      CHECK(kNames[static_cast<std::size_t>(loop.loop->phase())] ==
            (told == "=" ? kNames[i / 4] : told));
    }
  }
}
