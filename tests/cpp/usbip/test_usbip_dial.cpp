// The device as a dial, through TinyUSB's stack: what it says it is, and what it sends.
#include <doctest/doctest.h>

#include <numbers>
#include <span>
#include <string>
#include <utility>

#include "device/usb_descriptors.hpp"
#include "emulator/usbip/hands.hpp"
#include "rig.hpp"

using namespace usbip_test;
using torsio::device::Personality;
using torsio::protocol::Toggle;

namespace {

struct DialRig {
  torsio::emulator::usbip::UsbKnob knob;
  Client client{knob};
  explicit DialRig(Personality personality = Personality::dial, Toggle wakes = Toggle::off)
      : knob({.hand = torsio::emulator::usbip::still_hand(),
              .serial = "DIAL-1",
              .given = {.game = torsio::protocol::GameConfig{.personality = personality,
                                                             .dial_torque_nm = 0,
                                                             .remote_wakeup = wakes}}}) {
    client.attach();
    client.configure();
  }
  /// Sum of the wheel's reports while a firm hand turns to an angle.
  long turn_to(double angle_rad) {
    REQUIRE(hands.follow("angle " + std::to_string(angle_rad)));
    long sum = 0;
    for (int i = 0; i < 150; ++i) {
      client.frame();
      const auto answer = client.reply();
      if (!answer) continue;
      client.submit_in(2, 64);
      if (answer->data.at(0) != 1) continue;  // keys; none is pressed
      REQUIRE(answer->data.size() == 8);
      sum += static_cast<std::int16_t>(answer->data[4] | (answer->data[5] << 8));
    }
    return sum;
  }
  void listen() { client.submit_in(2, 64); }

  torsio::emulator::usbip::HandCommands hands{knob.device()};
};

}  // namespace

TEST_CASE("a dial keeps its fine resolution when a port is reset behind a suspended bus") {
  // Linux asks for it once, when it finds the device.
  DialRig rig;
  const double detent_rad = 2 * std::numbers::pi / 24;
  REQUIRE(rig.client.control_out(setup_packet(0x21, 9, 0x0303, 1, 2), {3, 5}).status == 0);
  rig.listen();
  CHECK(rig.turn_to(detent_rad) == -120);
  for (const bool sleeps : {true, false}) {
    if (sleeps) rig.knob.host().suspend();
    rig.knob.host().reset();
    for (int i = 0; i < 30; ++i) rig.client.frame();
    rig.client.configure();
    rig.knob.host().resume();
    CHECK(rig.client.control_in(setup_packet(0xA1, 1, 0x0303, 1, 2), 2).data == Bytes{3, 5});
    CHECK(rig.turn_to((sleeps ? 4 : 1) * detent_rad) == (sleeps ? -360 : 360));
  }
}

TEST_CASE("a dial that wakes tells what is pressed, changed or not") {
  DialRig rig;
  for (const std::uint8_t pressed : std::initializer_list<std::uint8_t>{0, 1}) {
    rig.knob.device().set_buttons(pressed);
    for (int reports = 0; reports < (pressed == 0 ? 3 : 1); ++reports) {
      rig.listen();
      CHECK(rig.client.wait().data.at(1) == pressed);
    }
  }
  rig.listen();
  for (int i = 0; i < 5; ++i) rig.client.frame();
  rig.knob.host().suspend();
  rig.knob.device().set_buttons(0);
  for (int i = 0; i < 50; ++i) rig.client.frame();
  CHECK_FALSE(rig.client.reply());
  rig.knob.host().resume();
  CHECK(rig.client.wait().data == Bytes{2, 0});
  rig.listen();
  CHECK(rig.client.wait().data == Bytes{4, 0, 0, 0});
  rig.listen();
  CHECK(rig.client.wait().data == Bytes{1, 0, 0, 0, 0, 0, 0, 0});
}

TEST_CASE("a hand wakes a host that sleeps if the player and the host allow it, and else not") {
  const std::uint8_t allow = 3,
                     forbid = 1;  // SET_FEATURE and CLEAR_FEATURE of DEVICE_REMOTE_WAKEUP
  const std::pair<Personality, bool> cases[] = {{Personality::dial, true},
                                                {Personality::dial, false},
                                                {Personality::game_controller, true},
                                                {Personality::game_controller, false}};
  for (const auto& [personality, wakes] : cases) {
    CAPTURE(personality);
    CAPTURE(wakes);
    DialRig rig(personality, wakes ? Toggle::on : Toggle::off);
    const Bytes told = rig.client.control_in(setup_packet(0x80, 6, 0x0200, 0, 9), 9).data;
    CHECK(told.at(7) == (wakes ? 0xA0 : 0x80));
    CHECK(rig.client.control_out(setup_packet(0x00, allow, 2, 0, 0)).status == kStall);
    const auto status = rig.client.control_out(setup_packet(0x00, allow, 1, 0, 0)).status;
    CHECK(status == (wakes ? 0 : kStall));
    CHECK(rig.client.control_in(setup_packet(0x80, 0, 0, 0, 2), 2).data ==
          Bytes{static_cast<std::uint8_t>(wakes ? 2 : 0), 0});
    double angle_rad = 0;
    const auto hears = [&](double by_rad, std::uint8_t pressed) {
      rig.knob.host().suspend();
      angle_rad += by_rad;
      REQUIRE(rig.hands.follow("angle " + std::to_string(angle_rad)));
      rig.client.frame();
      rig.knob.device().set_buttons(pressed);
      rig.listen();
      for (int i = 0; i < 100; ++i) rig.client.frame();
      const bool heard = rig.client.reply().has_value();
      rig.knob.host().resume();
      while (!heard && !rig.client.reply()) rig.client.frame();
      return heard;
    };
    CHECK_FALSE(hears(0.1, 0));
    CHECK(hears(0.5, 0) == wakes);
    CHECK(hears(-0.5, 0) == wakes);
    CHECK(hears(0, 2) == wakes);
    CHECK_FALSE(hears(0, 2));  // still pressed
    if (!wakes) continue;
    CHECK(rig.client.control_out(setup_packet(0x00, forbid, 1, 0, 0)).status == 0);
    CHECK_FALSE(hears(0.5, 0));
  }
}

TEST_CASE(
    "a dial tells whole detents to a host that has not asked, or not since it was configured "
    "anew") {
  DialRig rig;
  REQUIRE(rig.client.control_out(setup_packet(0x21, 9, 0x0303, 1, 2), {3, 5}).status == 0);
  CHECK(rig.client.control_out(setup_packet(0x21, 9, 0x0303, 1, 2), {3, 0x0A}).status == kStall);
  // Taken out of its configuration and put back.
  REQUIRE(rig.client.control_out(setup_packet(0x00, 9, 0, 0, 0)).status == 0);
  for (int i = 0; i < 3; ++i) rig.client.frame();
  rig.client.configure();
  CHECK(rig.client.control_in(setup_packet(0xA1, 1, 0x0303, 1, 2), 2).data == Bytes{3, 0});
  rig.listen();
  CHECK(rig.turn_to(4 * std::numbers::pi / 24) == -2);
}
