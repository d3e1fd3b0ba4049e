// Interrupt transfers: output reports, the answers to them, and what endpoints refuse.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <optional>

#include "rig.hpp"
#include "usb/usb_device.hpp"

using namespace usbip_test;

TEST_CASE("an endpoint moves one report in a frame") {
  Rig rig;
  for (std::uint8_t n = 0; n < 4; ++n) rig.client.submit_out(1, command(n, kDisarm));
  for (int frame = 0; frame < 4; ++frame) {
    CHECK_FALSE(rig.client.reply());
    rig.client.frame();
    CHECK(rig.client.reply());
  }
  for (int i = 0; i < 10; ++i) rig.client.frame();
  for (int n = 0; n < 4; ++n) rig.client.submit_in(1, 64);
  for (int frame = 0; frame < 4; ++frame) {
    CHECK_FALSE(rig.client.reply());
    rig.client.frame();
    CHECK(rig.client.reply());
  }
}

TEST_CASE("polls that a late IN transfer has missed are made up for, and no more") {
  Rig rig;
  for (std::uint8_t n = 0; n < 6; ++n) rig.client.submit_out(1, command(n, kDisarm));
  const auto pass = [&](int frames) {
    for (int i = 0; i < frames; ++i) rig.client.frame();
  };
  pass(30);
  while (rig.client.reply()) {
  }
  rig.client.submit_in(1, 64);
  CHECK_FALSE(rig.client.reply());  // nobody listened, so nothing to make up for
  pass(1);
  CHECK(rig.client.reply());

  pass(2);
  for (int n = 0; n < 4; ++n) rig.client.submit_in(1, 64);
  for (int n = 0; n < 2; ++n) CHECK(rig.client.reply());
  for (int n = 0; n < 2; ++n) {
    CHECK_FALSE(rig.client.reply());
    pass(1);
    CHECK(rig.client.reply());
  }

  pass(25);  // this is not late any more, it has stopped
  rig.client.submit_in(1, 64);
  CHECK_FALSE(rig.client.reply());
  pass(1);
  CHECK(rig.client.reply());
}

TEST_CASE("IN transfer with too little room overflows and loses no report") {
  Rig rig;
  rig.client.submit_out(1, command(3, kDisarm));
  (void)rig.client.wait();
  rig.client.submit_in(1, 10);
  const Reply cut = rig.client.wait();
  CHECK(cut.status == -75);
  CHECK(cut.length == 0);
  rig.client.submit_in(1, 64);
  CHECK(rig.client.wait().data.at(1) == 3);
}

TEST_CASE("host that reads nothing is made to wait and loses no command") {
  Rig rig;
  constexpr int kCommands = 100;
  for (std::uint8_t n = 0; n < kCommands; ++n) rig.client.submit_out(1, command(n, kDisarm));
  int taken = 0;
  for (int frame = 0; frame < 300; ++frame) {
    rig.client.frame();
    while (rig.client.reply()) ++taken;
  }
  CHECK(taken > 4);
  CHECK(taken < kCommands);
  std::vector<int> answered;
  for (int i = 0; i < 400 && answered.size() < kCommands; ++i) {
    if (rig.client.session().output().empty()) rig.client.submit_in(1, 64);
    rig.client.frame();
    while (const auto reply = rig.client.reply()) {
      if (!reply->data.empty()) answered.push_back(reply->data.at(1));
    }
  }
  REQUIRE(answered.size() == kCommands);
  for (int n = 0; n < kCommands; ++n) CHECK(answered[static_cast<std::size_t>(n)] == n);
}

// Refusals ---------------------------------------------------------------------------------------

TEST_CASE("bad output report is taken by the bus and refused by the device") {
  Rig rig;
  for (const Bytes& report : {Bytes{0x10, 5}, Bytes{}, Bytes(64, 0xFF), command(1, 200)}) {
    rig.client.submit_out(1, report);
    CHECK(rig.client.wait().status == 0);
    rig.client.submit_in(1, 64);
    const Bytes answer = rig.client.wait().data;
    CHECK(answer.at(0) == 0x41);
    CHECK(answer.at(4) != 0);
  }
}

TEST_CASE("transfer to an endpoint that does not exist stalls") {
  Rig rig;
  for (const std::uint32_t endpoint : {5U, 7U, 8U, 15U, 16U, 0xFFFFFFFFU}) {
    rig.client.submit_in(endpoint, 64);
    CHECK(rig.client.wait().status == kStall);
    rig.client.submit_out(endpoint, Bytes(3));
    CHECK(rig.client.wait().status == kStall);
  }
}

TEST_CASE("before a host is there no game has the actuator, whatever has been said") {
  using namespace torsio;
  const device::BoardInfo board;
  for (const bool on_usb : {true, false}) {  // the other is one on a bench, always connected
    CAPTURE(on_usb);
    device::Device device(board, device::empty_slots());
    std::optional<usb::UsbDevice> stack;
    if (on_usb) stack.emplace(device, board);
    const auto say = [&](const Bytes& report) { device.game().receive(report); };
    REQUIRE(device.game().set_feature(Bytes{0x21, 1, 0, 0}));  // Create New Effect: a constant
    std::array<std::uint8_t, 64> loaded{};
    REQUIRE(device.game().get_feature(0x22, loaded) == 5);
    const std::uint8_t block = loaded[1];
    say({0x11, block, 1, 0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0x7F, 0, 2, 0xFF, 0x5F, 0, 0});
    say({0x15, block, 0x00, 0x20});
    say({0x1A, block, 1, 1});
    for (int i = 0; i < 10; ++i) {
      device.service();
      const device::TickOutputs given = device.tick({});
      CHECK((on_usb ? given.motor_command_nm == 0.0F : true));
    }
    CHECK((device.state() == protocol::State::armed) == !on_usb);
  }
}
