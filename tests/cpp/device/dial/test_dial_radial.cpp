// The knob as Windows' radial controller, and what a button does to a dial.
//
// What is asked of it: Microsoft's "Windows radial controller protocol implementation", and chapter
// 14 of the HID Usage Tables 1.4.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "dial_rig.hpp"

namespace {

using namespace torsio;
using namespace torsio::test;
using protocol::DialUse;
using protocol::Op;
using protocol::Owner;
using protocol::State;

constexpr std::uint8_t kNone = 1, kStop = 2, kClick = 3, kBuzz = 4;  // ordinals
using Request = std::array<std::uint8_t, 6>;

Request request(std::uint8_t waveform, std::uint8_t percent = 100, std::uint8_t repeats = 0,
                std::uint16_t period_ms = 0) {
  return {5,
          waveform,
          percent,
          repeats,
          static_cast<std::uint8_t>(period_ms),
          static_cast<std::uint8_t>(period_ms >> 8)};
}

/// The motor's torque in so many ticks of 1 ms.
std::vector<float> felt(DialRig& rig, int ticks) {
  std::vector<float> nm;
  for (int i = 0; i < ticks; ++i) {
    rig.tick();
    nm.push_back(rig.outputs.motor_command_nm);
  }
  return nm;
}

/// The ticks at which a pulse begins.
std::vector<int> begins(const std::vector<float>& nm) {
  std::vector<int> found;
  for (std::size_t i = 0; i < nm.size(); ++i) {
    const bool quiet =
        std::all_of(nm.begin() + static_cast<long>(i > 3 ? i - 3 : 0),
                    nm.begin() + static_cast<long>(i), [](float x) { return x == 0; });
    if (nm[i] != 0 && quiet) found.push_back(static_cast<int>(i));
  }
  return found;
}

float most(const std::vector<float>& nm) {
  return std::abs(*std::max_element(nm.begin(), nm.end(),
                                    [](float a, float b) { return std::abs(a) < std::abs(b); }));
}

}  // namespace

TEST_CASE("radial: it tells the angle in tenths of a degree, without an error that adds up") {
  for (const std::uint8_t detents : std::initializer_list<std::uint8_t>{7, 24, 240}) {
    for (const protocol::Toggle coarse : {protocol::Toggle::off, protocol::Toggle::on}) {
      CAPTURE(static_cast<int>(detents));
      DialRig rig({.use = DialUse::radial, .detents = detents, .torque_nm = 0, .coarse = coarse});
      for (const int number : {1, 2, 100, 99, -3, -4}) {
        rig.turn_to(std::llround(number * 8192.0 / detents), 150);
        rig.listen(3);
        CHECK(rig.heard.tenths == std::floor(number * 3600.0 / detents));
      }
      CHECK(rig.heard.news == 0);  // the mouse stands still
      const int before = rig.heard.tenths;
      rig.turn_to(std::llround(-3.6 * 8192.0 / detents), 150);
      rig.listen(3);
      CHECK((rig.heard.tenths == before) == (coarse == protocol::Toggle::on));
    }
  }
}

TEST_CASE("radial: what the host was not there to hear comes in turns of one, the SDK's not") {
  DialRig rig({.use = DialUse::radial, .torque_nm = 0});
  rig.turn_to(100, 1);
  const int before = rig.heard.tenths;
  REQUIRE(rig.command(Op::arm) == protocol::Status::ok);
  rig.inputs.encoder_count += 500;
  rig.tick();
  REQUIRE(rig.command(Op::disarm) == protocol::Status::ok);
  rig.listen(130);
  CHECK(rig.heard.tenths == before);
  rig.inputs.encoder_count += 5 * 8192;
  rig.listen(20);
  CHECK(rig.heard.tenths == before + 5 * 3600);
}

TEST_CASE("dial: buttons are the mouse's, and the first one the radial controller's if it is one") {
  for (const bool radial : {false, true}) {
    DialRig rig({.use = radial ? DialUse::radial : DialUse::wheel});
    std::array<std::uint8_t, 64> report{};
    for (const int pressed : {1, 3, 2, 0}) {
      rig.device->set_buttons(static_cast<std::uint8_t>(pressed));
      rig.listen(3);
      CHECK(rig.heard.puck == (radial ? pressed & 1 : 0));
      CHECK(rig.heard.buttons == (radial ? pressed & 2 : pressed));
      REQUIRE(rig.device->dial().get_input(4, report) == 4);
      CHECK(report[1] == rig.heard.puck);
    }
    rig.listen(100);  // a change is told twice
    const int reports = rig.heard.reports;
    rig.listen(500);
    CHECK(rig.heard.reports == reports);  // a mouse that says nothing new keeps some systems awake
  }
}

TEST_CASE("radial: a click is one period of a sine as strong as the detents, at rest too") {
  DialRig rig({.use = DialUse::radial});
  for (const int percent : {100, 50, 0}) {
    rig.device->dial().receive(request(kClick, static_cast<std::uint8_t>(percent)));
    const std::vector<float> nm = felt(rig, 40);
    CHECK(rig.owner() == Owner::dial);
    CHECK(most(nm) == doctest::Approx(0.005 * percent / 100).scale(0.005).epsilon(0.01));
    CHECK(std::count_if(nm.begin(), nm.end(), [](float x) { return std::abs(x) > 1e-4F; }) ==
          (percent == 0 ? 0 : 6));  // of 8 ms, with zeros at the ends and in the middle
  }
  rig.tick(1200);
  CHECK(rig.state() == State::disarmed);
  // Beyond their ranges the values do not count. The host's settings do.
  REQUIRE(rig.device->dial().set_feature(request(kClick, 50, 0, 100)));
  rig.device->dial().receive(request(kClick, 255, 2, 0xFFFF));
  const std::vector<float> nm = felt(rig, 400);
  CHECK(most(nm) == near_nm(0.0025, 0.02));
  const std::vector<int> at = begins(nm);
  REQUIRE(at.size() == 3);
  CHECK(at[1] - at[0] == 100);
  CHECK(at[2] - at[1] == 100);
}

TEST_CASE("radial: a buzz goes on until it is stopped, or for five seconds") {
  DialRig rig({.use = DialUse::radial});
  for (const bool stopped : {true, false}) {
    rig.device->dial().receive(request(kBuzz, 100, 9, 50));
    CHECK(most(felt(rig, 4900)) == near_nm(0.005, 0.01));
    rig.device->dial().receive(request(stopped ? kStop : kNone));
    CHECK((most(felt(rig, 60)) > 0.004F) == true);
    CHECK((most(felt(rig, 20)) > 0.0F) == !stopped);
    CHECK(most(felt(rig, 1200)) == (stopped ? 0.0F : near_nm(0.005, 0.01)));
    CHECK(rig.state() == State::disarmed);
  }
  // The SDK's scene is not shaken, nor what comes after it.
  REQUIRE(rig.command(Op::arm) == protocol::Status::ok);
  rig.device->dial().receive(request(kBuzz));
  CHECK(most(felt(rig, 100)) == 0.0F);
  REQUIRE(rig.command(Op::disarm) == protocol::Status::ok);
  CHECK(most(felt(rig, 100)) == 0.0F);
}

TEST_CASE("radial: the host makes its detents weaker, or takes them away, until it begins anew") {
  DialRig rig({.use = DialUse::radial});
  std::array<std::uint8_t, 64> report{};
  const auto detent_nm = [&rig] {
    rig.turn_to(0, 9);
    rig.turn_to(85, 9);
    rig.listen(120);
    return std::abs(rig.outputs.motor_command_nm);
  };
  CHECK(detent_nm() == near_nm(0.005));
  REQUIRE(rig.device->dial().set_feature(request(kClick, 50)));
  CHECK(detent_nm() == near_nm(0.0025));
  for (const int off : {0, 1, 2}) {
    REQUIRE(rig.device->dial().set_feature(request(static_cast<std::uint8_t>(off))));
    CHECK(detent_nm() == 0.0F);
    REQUIRE(rig.device->dial().get_feature(5, report) == 6);
    CHECK(report[1] == off);
  }
  for (const Request& wrong : {request(5), request(3, 101), request(3, 100, 0, 2001)}) {
    CHECK_FALSE(rig.device->dial().set_feature(wrong));
  }
  CHECK_FALSE(rig.device->dial().set_feature(std::array<std::uint8_t, 3>{5, 3, 100}));
  CHECK(detent_nm() == 0.0F);
  // What a desktop's host says of the radial controller is not for a wheel.
  protocol::GameConfig wheel = rig.get<protocol::GameConfig>();
  rig.listen(1200);
  wheel.dial_use = DialUse::wheel;
  REQUIRE(rig.set(wheel).ok());
  const int tenths = rig.heard.tenths;
  CHECK(detent_nm() == near_nm(0.005));
  CHECK(rig.heard.tenths == tenths);
  rig.device->dial().begin_anew();
  REQUIRE(rig.device->dial().get_feature(5, report) == 6);
  CHECK(std::equal(report.begin(), report.begin() + 6, request(kClick).begin()));
}

TEST_CASE("dial: pressed and turned it does the other thing, and a press alone is a click") {
  struct Row {
    DialUse use;
    long wheel, pan;
    int louder;
  };
  for (const Row& row :
       {Row{DialUse::wheel_or_pan, 0, 3, 0}, Row{DialUse::wheel_or_volume, 0, 0, 3},
        Row{DialUse::volume_or_wheel, -3, 0, 0}}) {
    DialRig rig({.use = row.use, .torque_nm = 0});
    const auto place = [](int number) { return std::llround(number * 8192.0 / 24.0); };
    rig.turn_to(place(2), 20);
    rig.listen(10);
    rig.heard = {};
    rig.device->set_buttons(1);
    rig.turn_to(place(5), 20);
    rig.listen(10);
    CHECK(rig.heard.wheel == row.wheel);
    CHECK(rig.heard.pan == row.pan);
    CHECK(rig.heard.louder == row.louder);
    rig.device->set_buttons(0);
    rig.listen(10);
    CHECK(rig.heard.news == std::abs(row.wheel) + row.pan);  // no click
    rig.heard = {};
    rig.turn_to(place(4), 20);
    rig.listen(10);
    CHECK((row.use == DialUse::volume_or_wheel ? rig.heard.quieter : rig.heard.downs) == 1);
    rig.heard = {};
    rig.device->set_buttons(3);
    rig.listen(50);
    CHECK(rig.heard.buttons == 2);
    rig.device->set_buttons(0);
    rig.listen(1);
    CHECK(rig.heard.buttons == 1);
    rig.listen(1);
    CHECK(rig.heard.buttons == 0);
  }
}

TEST_CASE("dial: pressed between two notches, it fills up what it has told, and that is no turn") {
  DialRig rig({.use = DialUse::wheel_or_pan, .torque_nm = 0});
  rig.ask_for_fine();
  rig.turn_to(180, 20);  // of 341
  rig.listen(10);
  REQUIRE(rig.heard.wheel % 120 != 0);
  rig.device->set_buttons(1);
  rig.listen(10);
  CHECK(rig.heard.wheel == -120);
  CHECK(rig.heard.pan == 0);
  rig.device->set_buttons(0);
  rig.listen(1);
  CHECK(rig.heard.buttons == 1);
}
