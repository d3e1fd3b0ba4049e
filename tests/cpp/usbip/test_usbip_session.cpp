// A client's conversation, from its first byte to its last.
#include <doctest/doctest.h>

#include "device/usb_descriptors.hpp"
#include "protocol/usb_ids.hpp"
#include "rig.hpp"

using namespace usbip_test;
using torsio::emulator::usbip::Session;
using torsio::emulator::usbip::UsbKnob;

namespace {

/// Arms the knob and takes its answer. @returns the number of a transfer IN that waits
std::uint32_t arm_and_wait(Rig& rig) {
  rig.client.submit_out(1, command(1, kArm));
  (void)rig.client.wait();
  std::uint32_t waiting = rig.client.submit_in(1, 64);
  for (int i = 0; i < 20; ++i) {
    rig.client.frame();
    if (rig.client.reply()) waiting = rig.client.submit_in(1, 64);
  }
  REQUIRE(rig.knob.device().device().state() == torsio::protocol::State::armed);
  return waiting;
}

}  // namespace

// Before the import ------------------------------------------------------------------------------

TEST_CASE("import of another bus id is refused") {
  UsbKnob knob({});
  Client client(knob);
  client.send(import_request("1-2"));
  CHECK(client.take() == words({0x01110003, 4}));
  CHECK(client.session().finished());
  CHECK_FALSE(client.session().attached());
}

TEST_CASE("second import is refused as busy and the first client does not notice") {
  Rig rig;
  Client second(rig.knob);
  second.send(import_request());
  CHECK(second.take() == words({0x01110003, 2}));
  CHECK(second.session().finished());
  CHECK(rig.client.get_feature(1).status == 0);
}

TEST_CASE("import is refused while the cable is out") {
  UsbKnob knob({});
  knob.exported().available = false;
  Client client(knob);
  client.send(import_request());
  CHECK(client.take() == words({0x01110003, 1}));
}

TEST_CASE("what is no USB/IP ends the conversation without an answer") {
  for (const Bytes& bytes : {text("GET / HTTP/1.1\r\n\r\n"), words({0x01108005, 0}),
                             words({0x01118006, 0}), Bytes(64)}) {
    UsbKnob knob({});
    Client client(knob);
    client.send(bytes);
    CHECK(client.session().finished());
    CHECK_FALSE(client.session().problem().empty());
    CHECK(client.take().empty());
  }
}

TEST_CASE("requests may come byte by byte") {
  UsbKnob knob({});
  Client client(knob);
  for (const std::uint8_t byte : import_request()) client.send({byte});
  CHECK(client.take().size() == 320);
  for (const std::uint8_t byte : submit_header(7, 1, 0, 18, setup_packet(0x80, 6, 0x0100, 0, 18))) {
    client.send({byte});
  }
  CHECK(client.take().size() == 48 + 18);
}

// After it ---------------------------------------------------------------------------------------

TEST_CASE("requests that break the protocol end the conversation and the next client is served") {
  const Bytes device_7 = words({1, 9, 7, 1, 0, 0, 18, 0, 0, 0, 0, 0});
  const Bytes unlink_of_device_7 = words({2, 9, 7, 0, 0, 1, 0, 0, 0, 0, 0, 0});
  for (const Bytes& bytes :
       {words({9, 1, kDeviceId, 0, 0, 0, 0, 0, 0, 0, 0, 0}),           // no such command
        words({1, 1, kDeviceId, 2, 0, 0, 0, 0, 0, 0, 0, 0}),           // no such direction
        words({1, 1, kDeviceId, 0, 1, 0, 0x7FFFFFFF, 0, 0, 0, 0, 0}),  // 2 GiB
        words({1, 1, kDeviceId, 0, 1, 0, 0xFFFFFFFF, 0, 0, 0, 0, 0}),  // -1 byte
        words({1, 1, kDeviceId, 1, 1, 0, 64, 0, 3, 0, 0, 0}),          // isochronous
        device_7, unlink_of_device_7, Bytes(48, 0xFF)}) {
    Rig rig;
    rig.client.send(bytes);
    CHECK(rig.client.session().finished());
    CHECK_FALSE(rig.client.session().problem().empty());
  }
}

TEST_CASE("too many transfers under way end the conversation") {
  Rig rig;
  for (std::size_t i = 0; i < Session::kMostPending; ++i) rig.client.submit_in(1, 64);
  CHECK_FALSE(rig.client.session().finished());
  rig.client.submit_in(1, 64);
  CHECK(rig.client.session().finished());
}

TEST_CASE("a knob that a host has configured stays armed, and none is before there is a host") {
  using torsio::protocol::State;
  {
    UsbKnob knob({});
    auto& device = knob.device().device();
    // A game's push: create, set effect, set constant, start.
    CHECK(device.game().set_feature(Bytes{0x21, 1, 0, 0}));
    device.game().receive(
        Bytes{0x11, 1, 1, 0xFF, 0xFF, 0, 0, 0, 0, 0xFF, 0x7F, 0, 2, 0xFF, 0x5F, 0, 0});
    device.game().receive(Bytes{0x15, 1, 0xFF, 0x7F});
    device.game().receive(Bytes{0x1A, 1, 1, 1});
    for (int i = 0; i < 5; ++i) knob.advance();
    CHECK(device.state() == State::disarmed);
  }
  Rig rig;
  const auto state = [&] { return rig.knob.device().device().state(); };
  (void)arm_and_wait(rig);
  for (int i = 0; i < 80; ++i) rig.client.frame();  // longer than a fade, less than the watchdog
  CHECK(state() == State::armed);
}

TEST_CASE("configuration that is taken back ends what waits and disarms, and may be set again") {
  Rig rig;
  const auto state = [&] { return rig.knob.device().device().state(); };
  const std::uint32_t waiting = arm_and_wait(rig);

  CHECK(rig.client.control_out(setup_packet(0x00, 9, 0, 0, 0)).status == 0);
  const Reply ended = rig.client.wait();
  CHECK(ended.sequence == waiting);
  CHECK(ended.status == kStall);  // silicon says nothing at all there, which ends it as well
  CHECK(ended.length == 0);
  CHECK_FALSE(rig.knob.has_host());
  for (int i = 0; i < 100; ++i) rig.client.frame();  // less than the watchdog's time
  CHECK(state() == torsio::protocol::State::disarmed);
  CHECK_FALSE(rig.client.reply());

  rig.client.configure();
  CHECK(rig.knob.has_host());
  rig.client.submit_out(1, command(7, kArm));
  (void)rig.client.wait();
  Bytes answer;
  do {  // behind the events that came meanwhile
    rig.client.submit_in(1, 64);
    answer = rig.client.wait().data;
  } while (answer.at(0) == 0x42);
  REQUIRE(answer.size() == 64);
  CHECK(Bytes(answer.begin(), answer.begin() + 5) == Bytes{0x41, 7, 0, 0x10, 0});
  CHECK(state() == torsio::protocol::State::armed);
}

TEST_CASE("bus reset in the middle of transfers ends them and the knob may be configured again") {
  Rig rig;
  const auto state = [&] { return rig.knob.device().device().state(); };
  const std::uint32_t waiting = arm_and_wait(rig);
  // The device waits for 64 bytes, and none come.
  CHECK(rig.client.control_out(setup_packet(0x21, 9, 0x0305, 0, 64)).status == kStall);

  rig.knob.host().plug();  // the device sees a reset of the bus
  const Reply ended = rig.client.wait();
  CHECK(ended.sequence == waiting);
  CHECK(ended.status == kStall);  // silicon says nothing at all there, which ends it as well
  CHECK_FALSE(rig.knob.has_host());
  CHECK(rig.client.get_feature(1).status == kStall);
  for (int i = 0; i < 100; ++i) rig.client.frame();  // less than the watchdog's time
  CHECK(state() == torsio::protocol::State::disarmed);

  rig.client.configure();
  CHECK(rig.knob.has_host());
  CHECK(rig.client.get_feature(1).status == 0);
}

TEST_CASE("client that goes is a pulled plug: the armed knob disarms and the next one is served") {
  UsbKnob knob({});
  {
    Client client(knob);
    client.attach();
    client.configure();
    client.submit_out(1, command(1, kArm));
    (void)client.wait();
    for (int i = 0; i < 5; ++i) client.frame();
    REQUIRE(knob.device().device().state() == torsio::protocol::State::armed);
    client.submit_in(1, 64);
  }
  CHECK_FALSE(knob.has_host());
  for (int i = 0; i < 100; ++i) knob.advance();
  CHECK(knob.device().device().state() == torsio::protocol::State::disarmed);
  Client next(knob);
  next.attach();
  CHECK(next.get_feature(1).status == kStall);  // not configured yet
  next.configure();
  CHECK(next.get_feature(1).status == 0);
  for (int i = 0; i < 10; ++i) next.frame();
  CHECK_FALSE(next.reply());  // nothing is left of the first client's transfers
}

TEST_CASE("client that goes in the middle of a message leaves the knob as it was") {
  const Bytes feature =
      submit_header(5, 0, 0, 64, setup_packet(0x21, 9, 0x0305, 0, 64)) + Bytes(64, 0x05);
  const Bytes output = submit_header(6, 0, 1, 64) + command(1, kArm);
  for (const Bytes& message : {feature, output, import_request()}) {
    for (std::size_t cut = 1; cut < message.size(); cut += 7) {
      UsbKnob knob({});
      Bytes before;
      {
        Client client(knob);
        client.attach();
        client.configure();
        before = client.get_feature(0x05).data;
        client.send(Bytes(message.begin(), message.begin() + static_cast<std::ptrdiff_t>(cut)));
      }
      Client next(knob);
      next.attach();
      next.configure();
      for (int i = 0; i < 5; ++i) next.frame();
      CHECK(next.get_feature(0x05).data == before);
      CHECK(knob.device().device().state() == torsio::protocol::State::disarmed);
    }
  }
}

TEST_CASE("client that goes in a control transfer's data stage leaves a stack that works") {
  UsbKnob knob({});
  {
    Client client(knob);
    client.attach();
    client.configure();
    // The device waits for 64 bytes, and none come.
    CHECK(client.control_out(setup_packet(0x21, 9, 0x0305, 0, 64)).status == kStall);
  }
  Client next(knob);
  next.attach();
  next.configure();
  CHECK(next.get_feature(1).status == 0);
}
