// The knob as a wheel of the desktop.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <string>
#include <vector>

#include "dial_rig.hpp"

namespace {

using namespace torsio;
using namespace torsio::test;
using protocol::DialUse;
using protocol::Op;
using protocol::Owner;
using protocol::State;
using protocol::Status;

/// Where a notch is, to the nearest count.
std::int64_t notch(int number) { return std::llround(number * 8192.0 / 24.0); }

}  // namespace

TEST_CASE("dial: a detent is 120 units whatever way and however fast it is turned") {
  DialRig rig;
  rig.ask_for_fine();
  long expected = 0;
  int at = 0;
  for (const auto& [detents, counts_a_tick] :
       {std::pair{5, 1}, {-12, 7}, {30, 60}, {-100, 200}, {77, 13}, {1, 3}, {-1, 200}}) {
    at += detents;
    rig.turn_to(notch(at) + (at % 3) * 20, counts_a_tick);  // friction lets it rest near by
    rig.listen(3);
    expected -= 120L * detents;  // larger angles are down, which is negative
    CHECK(rig.heard.wheel == expected);
    CHECK(rig.heard.pan == 0);
  }
}

TEST_CASE("dial: a host that has not asked for the fine resolution hears whole detents") {
  DialRig rig;
  rig.turn_to(notch(1) - 60, 5);
  rig.listen(3);
  CHECK(rig.heard.reports == 0);
  rig.turn_to(notch(1), 5);
  rig.listen(3);
  CHECK(rig.heard.news == 1);
  CHECK(rig.heard.wheel == -1);
  rig.turn_to(notch(-40), 150);
  rig.listen(3);
  CHECK(rig.heard.wheel == 40);
}

TEST_CASE("dial: coarse, it tells whole detents to a host that has asked for fine ones") {
  DialRig rig({.coarse = protocol::Toggle::on});
  rig.ask_for_fine();
  for (int at = 1; at <= 30; ++at) {
    rig.turn_to(notch(at) - 100, 3);
    CHECK(rig.heard.wheel == -120L * (at - 1));
    rig.turn_to(notch(at), 3);
    rig.listen(3);
    CHECK(rig.heard.wheel == -120L * at);
  }
}

TEST_CASE("dial: reversed, it scrolls the other way") {
  DialRig rig({.reversed = protocol::Toggle::on});
  rig.ask_for_fine();
  rig.turn_to(notch(7), 5);
  rig.listen(3);
  CHECK(rig.heard.wheel == 7 * 120);
}

TEST_CASE("dial: a detent that comes fast counts for more steps, and the host's sum stays full") {
  // 2.9 turns a second are fast, 1.0 is half as fast, 0.1 is slow.
  for (const auto& [counts_a_tick, steps] : {std::pair{24, 5}, {8, 2}, {1, 1}}) {
    for (const protocol::Toggle coarse : {protocol::Toggle::off, protocol::Toggle::on}) {
      CAPTURE(counts_a_tick);
      DialRig rig({.coarse = coarse, .fast_steps = 5});
      rig.listen(2000);
      rig.ask_for_fine();
      rig.turn_to(notch(24), counts_a_tick);
      rig.listen(3);
      CHECK(rig.heard.wheel == -120L * (1 + 23 * steps));  // the first has rested before
      rig.turn_to(notch(23), 1);
      rig.listen(3);
      CHECK(rig.heard.ups - rig.heard.downs == 23 * steps);
      CHECK(rig.heard.downs == 1);
    }
  }
}

TEST_CASE("dial: steps that no report has room for are not multiplied") {
  DialRig rig({.torque_nm = 0, .fast_steps = 5});
  rig.ask_for_fine();
  rig.inputs.encoder_count += 5 * 8192;
  rig.listen(20);
  CHECK(rig.heard.wheel == -120L * 5 * 24);
}

TEST_CASE("dial: what the host has asked for is read back, and is forgotten when it begins anew") {
  DialRig rig;
  std::array<std::uint8_t, 64> report{};
  REQUIRE(rig.device->dial().get_feature(3, report) == 2);
  CHECK(report[1] == 0);
  rig.ask_for_fine();
  REQUIRE(rig.device->dial().get_feature(3, report) == 2);
  CHECK(report[1] == 0x05);
  rig.device->dial().begin_anew();
  REQUIRE(rig.device->dial().get_feature(3, report) == 2);
  CHECK(report[1] == 0);
  CHECK(rig.device->dial().get_feature(1, report) == 0);
  CHECK(rig.device->dial().get_feature(3, std::span(report).first(1)) == 0);
  using Short = std::array<std::uint8_t, 2>;
  CHECK_FALSE(rig.device->dial().set_feature(Short{3, 0x02}));  // no value of the field
  CHECK_FALSE(rig.device->dial().set_feature(Short{3, 0x10}));
  CHECK_FALSE(rig.device->dial().set_feature(Short{4, 0x01}));
  CHECK_FALSE(rig.device->dial().set_feature(std::array<std::uint8_t, 3>{3, 1, 0}));
  CHECK_FALSE(rig.device->dial().set_feature({}));
}

TEST_CASE("dial: the volume gets a press of a key for each detent") {
  DialRig rig({.use = DialUse::volume});
  rig.turn_to(notch(9), 200);  // faster than keys can be pressed
  rig.listen(30);
  CHECK(rig.heard.louder == 9);
  CHECK(rig.heard.quieter == 0);
  rig.turn_to(notch(4), 10);
  rig.listen(30);
  CHECK(rig.heard.louder == 9);
  CHECK(rig.heard.quieter == 5);
  CHECK_FALSE(rig.key_down());
  CHECK(rig.heard.wheel == 0);
}

TEST_CASE("dial: its detents are a sine in phase with the units, once they have come up") {
  DialRig rig;
  rig.turn_to(2, 1);
  rig.turn_to(1, 1);
  rig.listen(60);  // past the soft start of 50 ms
  REQUIRE(rig.owner() == Owner::dial);
  for (std::int64_t at = -2000; at < 2000; at += 31) {
    rig.turn_to(at, 200);
    rig.tick();
    const double angle_rad = 2 * std::numbers::pi * static_cast<double>(at) / 8192.0;
    const double nm = -0.005 * std::sin(24 * angle_rad);
    CHECK(rig.outputs.motor_command_nm == doctest::Approx(nm).scale(0.005).epsilon(1e-5));
  }
}

TEST_CASE("dial: nothing is felt before it is turned, and what comes then comes in a line") {
  DialRig rig;
  rig.listen(100);
  CHECK_FALSE(rig.outputs.enabled);
  CHECK(rig.events.empty());
  // A quarter of a pitch in one tick, where the torque is largest: then it is held there.
  rig.turn_to(85, 85);
  int up = 0;
  for (int i = 0; i < 60; ++i) {
    const float last = rig.outputs.motor_command_nm;
    rig.listen();
    CHECK(rig.outputs.motor_command_nm <= last);
    CHECK(last - rig.outputs.motor_command_nm < 1.01F * 0.005F / 50);
    up += rig.outputs.motor_command_nm < last ? 1 : 0;
  }
  CHECK(up >= 48);
  CHECK(rig.outputs.motor_command_nm == near_nm(-0.005));
}

TEST_CASE("dial: it lets go of the actuator a second after the last turn, in a line") {
  DialRig rig;
  rig.turn_to(85, 5);
  rig.listen(990);
  CHECK(rig.owner() == Owner::dial);
  CHECK(rig.outputs.motor_command_nm == near_nm(-0.005));
  rig.events.clear();
  float last = rig.outputs.motor_command_nm;
  for (int i = 0; i < 100; ++i) {
    rig.inputs.encoder_count += i % 2 == 0 ? 1U : static_cast<std::uint32_t>(-1);  // flicker
    rig.tick();
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.05F * 0.005F / 50);
    last = rig.outputs.motor_command_nm;
  }
  CHECK_FALSE(rig.outputs.enabled);
  CHECK(rig.state() == State::disarmed);
  CHECK(rig.set(protocol::GameConfig{}).ok());  // so it can be configured
}

TEST_CASE("dial: turned again while it lets go it comes back, and plays no scene of the SDK") {
  DialRig rig;
  protocol::Constant constant;
  constant.torque_nm = 0.02F;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(protocol::Commit{1, 0, 1}) == Status::ok);
  rig.turn_to(85, 5);
  rig.listen(1020);
  rig.turn_to(82, 3);
  rig.listen(100);
  CHECK(rig.outputs.motor_command_nm == near_nm(-0.005 * std::sin(24 * 82 * 6.283185307 / 8192)));
}

TEST_CASE("dial: a torque that would buzz is not given, nor more than the motor has") {
  DialRig stiff({.detents = 100, .torque_nm = 1.0F});
  stiff.turn_to(20, 5);
  stiff.listen(60);
  float most = 0;
  for (int at = 0; at < 100; ++at) {
    stiff.turn_to(at, 1);
    most = std::max(most, std::abs(stiff.outputs.motor_command_nm));
  }
  // docs/reference/games.md: 0.236 N m/rad at 1 kHz, which a sine reaches in its notch with the
  // n-th part.
  CHECK(most == near_nm(0.236 / 100, 0.02));
  DialRig slow({.detents = 1, .torque_nm = 1.0F});
  // The torque that it has, and not a sine cut off there.
  slow.turn_to(683, 50);
  slow.listen(60);
  CHECK(slow.outputs.motor_command_nm == near_nm(-0.085 * std::sin(683 * 6.283185307 / 8192)));
  slow.turn_to(2048, 50);
  slow.listen(60);
  CHECK(slow.outputs.motor_command_nm == near_nm(-0.085));
}

TEST_CASE("dial: without a soft start it is there at once") {
  DialRig rig;
  REQUIRE(rig.set(protocol::ControlConfig{.law = protocol::Law::motor_only, .passive_ramp_s = 0.0F})
              .ok());
  rig.turn_to(85, 5);
  rig.listen(2);
  CHECK(rig.state() == State::armed);
  CHECK(rig.outputs.motor_command_nm == near_nm(-0.005 * std::sin(24 * 85 * 6.283185307 / 8192)));
}

TEST_CASE("dial: the SDK takes over as from a game, and the desktop hears nothing meanwhile") {
  DialRig rig;
  rig.ask_for_fine();
  rig.turn_to(85, 5);
  rig.listen(60);
  const long before = rig.heard.wheel;
  protocol::Constant constant;
  constant.torque_nm = 0.02F;
  REQUIRE(rig.send_status(constant) == Status::ok);
  REQUIRE(rig.send_status(protocol::Commit{1, 0, 1}) == Status::ok);
  float last = rig.outputs.motor_command_nm;
  REQUIRE(rig.device->receive(protocol::encode(protocol::Command{9, 0, Op::arm})));
  for (int i = 0; i < 80; ++i) {
    rig.listen();
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.05F * 0.025F / 50);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(last == near_nm(0.02));
  CHECK(rig.owner() == Owner::sdk);
  rig.turn_to(notch(10), 200);  // sooner than the host's silence would count
  rig.listen(5);
  CHECK(rig.heard.wheel == before);
  // And back: 4 ms down, and up with the next turn.
  REQUIRE(rig.command(Op::disarm) == Status::ok);
  rig.listen(20);
  CHECK(rig.heard.wheel == before);
  rig.turn_to(notch(11), 10);
  rig.listen(5);
  CHECK(rig.heard.wheel == -120);  // with the reports that it missed of the first
  CHECK(rig.owner() == Owner::dial);
}

TEST_CASE("dial: the SDK's disarm lets go along a line of 4 ms until it is turned again") {
  DialRig rig;
  rig.turn_to(85, 5);
  rig.listen(60);
  const float held = rig.outputs.motor_command_nm;
  REQUIRE(rig.device->receive(protocol::encode(protocol::Command{9, 0, Op::disarm})));
  for (int i = 1; i <= 4; ++i) {
    rig.tick();
    CHECK(rig.outputs.motor_command_nm ==
          doctest::Approx(held * static_cast<float>(4 - i) / 4).scale(0.005).epsilon(1e-5));
  }
  rig.tick(50);
  CHECK(rig.state() == State::disarmed);
  rig.turn_to(60, 5);
  rig.tick(2);
  CHECK(rig.owner() == Owner::dial);
  CHECK(std::abs(rig.outputs.motor_command_nm) < 0.2F * 0.005F);  // from zero again
}

TEST_CASE("dial: zeroing the knob or pulling the plug scrolls nothing") {
  DialRig rig;
  rig.ask_for_fine();
  rig.turn_to(notch(5), 9);
  rig.listen(1100);  // it has let go
  const long before = rig.heard.wheel;
  REQUIRE(rig.command(Op::zero) == Status::ok);
  rig.listen(5);
  CHECK(rig.heard.wheel == before);
  CHECK(rig.state() == State::disarmed);
  rig.turn_to(notch(5) + notch(2), 9);
  rig.listen(3);
  CHECK(rig.heard.wheel == before - 240);
  rig.device->set_connected(false);
  for (int i = 0; i < 100; ++i) {
    rig.inputs.encoder_count += 30;
    rig.tick();
  }
  rig.tick(2);
  rig.device->set_connected(true);
  rig.listen(3);
  CHECK(rig.heard.wheel == before - 240);
}

TEST_CASE("dial: no single detent is lost, wherever anything has left it between two notches") {
  using Leave = void (*)(DialRig&, std::int64_t);
  static const auto unheard = [](DialRig& rig, std::int64_t counts) {
    for (std::int64_t i = 0; i < counts; i += 20) {
      rig.inputs.encoder_count +=
          static_cast<std::uint32_t>(std::min<std::int64_t>(20, counts - i));
      rig.tick();
    }
  };
  // Each ends at a place between two notches.
  const std::pair<std::string, Leave> ways[] = {
      {"a program of the SDK",
       [](DialRig& rig, std::int64_t counts) {
         REQUIRE(rig.command(Op::arm) == Status::ok);
         unheard(rig, counts);
         REQUIRE(rig.command(Op::disarm) == Status::ok);
         rig.tick(50);
       }},
      {"a bus that sleeps",
       [](DialRig& rig, std::int64_t counts) {
         rig.device->set_connected(false);
         unheard(rig, counts);
         rig.device->set_connected(true);
       }},
      {"a bus reset with a report under way",
       [](DialRig& rig, std::int64_t counts) {
         rig.turn_to(counts, 7);
         std::array<std::uint8_t, 64> lost{};
         rig.inputs.encoder_count -= 9;
         rig.tick(2);
         (void)rig.device->dial().next_input(lost);
         rig.device->dial().input_over(false);
         rig.device->set_connected(false);
         rig.inputs.encoder_count += 9;
         rig.tick(2);
         rig.device->set_connected(true);
       }},
      {"a report that waits until a program opens the file, and that Linux discards then",
       [](DialRig& rig, std::int64_t counts) {
         rig.turn_to(counts, 7);
         std::array<std::uint8_t, 64> lost{};
         rig.inputs.encoder_count -= 9;
         rig.tick(2);
         const bool waits = rig.device->dial().next_input(lost) != 0;
         rig.inputs.encoder_count += 9;
         rig.tick(1000);
         if (waits) rig.device->dial().input_over(true);
         rig.listen(65);  // longer than Linux discards reports
       }},
      {"a bus that sleeps with a report under way, which the host takes when it wakes",
       [](DialRig& rig, std::int64_t counts) {
         rig.turn_to(counts, 7);
         rig.inputs.encoder_count -= 9;
         rig.tick(2);
         std::array<std::uint8_t, 64> report{};
         const std::size_t size = rig.device->dial().next_input(report);
         rig.device->set_connected(false);
         rig.inputs.encoder_count += 9;
         rig.tick(1000);
         rig.device->set_connected(true);
         rig.tick(2);
         if (size != 0) rig.hear(report, size);
       }},
      {"another number of detents, of which every place is another",
       [](DialRig& rig, std::int64_t counts) {
         rig.turn_to(counts, 7);
         rig.listen(1100);
         for (const std::uint8_t detents : std::initializer_list<std::uint8_t>{31, 24}) {
           protocol::GameConfig config = rig.get<protocol::GameConfig>();
           config.dial_detents = detents;
           REQUIRE(rig.set(config).ok());
           rig.listen(5);
         }
       }},
      {"another use, and the first one again",
       [](DialRig& rig, std::int64_t counts) {
         rig.turn_to(counts, 7);
         rig.listen(1100);
         const protocol::GameConfig config = rig.get<protocol::GameConfig>();
         protocol::GameConfig other = config;
         other.dial_use = DialUse::volume;
         REQUIRE(rig.set(other).ok());
         rig.listen(5);
         REQUIRE(rig.set(config).ok());
       }},
      {"another zero",
       [](DialRig& rig, std::int64_t counts) {
         rig.turn_to(counts, 7);
         rig.listen(1100);
         const long before = rig.heard.wheel;
         REQUIRE(rig.command(Op::zero) == Status::ok);
         rig.listen(5);
         CHECK(rig.heard.wheel == before);
         rig.put_at(0);
         rig.turn_to(counts, 7);
       }},
  };
  for (const auto& [name, leave] : ways) {
    for (const DialUse use : {DialUse::wheel, DialUse::pan, DialUse::volume}) {
      for (const bool fine : {true, false}) {
        for (std::int64_t place = 0; place <= notch(1); place += 17) {
          CAPTURE(name);
          CAPTURE(static_cast<int>(use));
          CAPTURE(fine);
          CAPTURE(place);
          DialRig rig({.use = use});
          if (fine) rig.ask_for_fine();
          leave(rig, place);
          rig.put_at(place);
          rig.turn_to(notch(1), 7);
          rig.listen(5);
          rig.heard = {};
          for (int i = 0; i < 4; ++i) {
            rig.turn_to(notch(2), 40);
            rig.listen(130);  // longer than the host is known to listen
            rig.turn_to(notch(1), 40);
            rig.listen(5);
            const bool keys = use == DialUse::volume;
            REQUIRE((keys ? rig.heard.louder : rig.heard.ups) == i + 1);
            REQUIRE((keys ? rig.heard.quieter : rig.heard.downs) == i + 1);
          }
        }
      }
    }
  }
}

TEST_CASE("dial: who begins to listen late hears what is pressed, and every detent") {
  DialRig rig;
  rig.ask_for_fine();
  rig.listen(200);
  rig.heard = {};
  rig.device->set_buttons(1);
  // Nobody fetches the report for a second, in which the knob is turned.
  std::array<std::uint8_t, 64> waits{};
  rig.inputs.encoder_count += 141;
  rig.tick(2);
  REQUIRE(rig.device->dial().next_input(waits) == 8);
  CHECK(waits[1] == 1);
  CHECK(waits[4] == 0);  // the host may throw it away
  for (int i = 0; i < 1000; ++i) {
    rig.inputs.encoder_count += i < 200 ? 1 : 0;
    rig.tick();
  }
  // Linux discards reports of the first 50 ms after a program has opened the file.
  rig.device->dial().input_over(true);
  rig.listen(50);
  CHECK(rig.heard.reports == 0);
  rig.listen(15);
  CHECK(rig.heard.buttons == 1);
  CHECK(rig.heard.wheel == -120);
}

TEST_CASE("dial: a button that changes in the 50 ms after an open is told once more") {
  for (const DialUse use : {DialUse::wheel, DialUse::radial}) {
    DialRig rig({.use = use});
    for (const std::uint8_t pressed : std::initializer_list<std::uint8_t>{1, 0}) {
      rig.listen(1000);
      rig.device->set_buttons(pressed);
      rig.discard(50);
      rig.listen(45);
      CHECK((use == DialUse::radial ? rig.heard.puck : rig.heard.buttons) == pressed);
      const int reports = rig.heard.reports;
      rig.listen(300);
      CHECK(rig.heard.reports == reports);
    }
  }
}

TEST_CASE("dial: when the bus comes back it tells once what is pressed, changed or not") {
  for (const int pressed : {0, 1}) {
    DialRig rig({.use = DialUse::volume});
    rig.device->set_buttons(1);
    rig.turn_to(notch(1), 341);
    rig.listen();
    REQUIRE(rig.key_down());
    rig.device->set_connected(false);
    rig.device->set_buttons(static_cast<std::uint8_t>(pressed));
    rig.tick(100);
    rig.device->set_connected(true);
    rig.heard.buttons = 0xFF;
    const int reports = rig.heard.reports;
    rig.listen(50);
    CHECK(rig.heard.buttons == pressed);
    CHECK_FALSE(rig.key_down());
    CHECK(rig.heard.reports == reports + 3);
  }
}

TEST_CASE("dial: a request gets what is pressed, and takes no turn away") {
  DialRig rig;
  rig.ask_for_fine();
  rig.device->set_buttons(2);
  rig.turn_to(notch(1) - 40, 20);
  std::array<std::uint8_t, 64> report{};
  REQUIRE(rig.device->dial().get_input(1, report) == 8);
  CHECK(std::vector(report.begin(), report.begin() + 8) ==
        std::vector<std::uint8_t>{1, 2, 0, 0, 0, 0, 0, 0});
  REQUIRE(rig.device->dial().get_input(2, report) == 2);
  CHECK(report[1] == 0);
  CHECK(rig.device->dial().get_input(3, report) == 0);
  CHECK(rig.device->dial().get_input(1, std::span(report).first(7)) == 0);
  rig.turn_to(notch(1), 20);
  rig.listen(3);
  CHECK(rig.heard.wheel == -120);
}

TEST_CASE("dial: without a host it does not pull, and when the host goes it fades") {
  DialRig rig;
  rig.turn_to(85, 5);
  rig.listen(60);
  rig.device->set_connected(false);
  float last = rig.outputs.motor_command_nm;
  for (int i = 0; i < 60; ++i) {
    rig.tick();
    CHECK(std::abs(rig.outputs.motor_command_nm - last) < 1.01F * 0.005F / 50);
    last = rig.outputs.motor_command_nm;
  }
  CHECK(rig.state() == State::disarmed);
  rig.turn_to(300, 5);
  CHECK(rig.state() == State::disarmed);
}

TEST_CASE("dial: what a fault has cut off does not sound in the SDK's scene") {
  DialRig rig;
  rig.turn_to(85, 5);
  rig.listen(60);
  rig.inputs.emergency_stop = true;
  rig.tick();
  rig.inputs.emergency_stop = false;
  rig.tick(2);
  REQUIRE(rig.command(Op::clear_fault) == Status::ok);
  REQUIRE(rig.command(Op::arm) == Status::ok);
  for (int n = 0; n < 100; ++n) {
    rig.tick();
    REQUIRE(rig.outputs.motor_command_nm == 0.0F);
  }
  CHECK(rig.owner() == Owner::sdk);
}

TEST_CASE("dial: games get nothing from it, and a game controller is no dial") {
  DialRig rig;
  REQUIRE(rig.device->personality() == protocol::Personality::dial);
  std::array<std::uint8_t, 4> create{0x21, 1, 0, 0};
  REQUIRE(rig.device->game().set_feature(create));
  rig.device->game().receive(std::array<std::uint8_t, 4>{0x15, 1, 0xFF, 0x7F});
  rig.device->game().receive(std::array<std::uint8_t, 4>{0x1A, 1, 1, 1});
  rig.listen(20);
  CHECK(rig.state() == State::disarmed);

  // The personality at the start counts.
  Rig game;
  protocol::GameConfig config;
  config.personality = protocol::Personality::dial;
  REQUIRE(game.set(config).ok());
  CHECK(game.device->personality() == protocol::Personality::game_controller);
  for (int i = 0; i < 100; ++i) {
    game.inputs.encoder_count += 9;
    game.tick();
  }
  CHECK(game.state() == State::disarmed);
}
