// A client's conversation with the firmware's USB side: TinyUSB's stack, descriptors and reports.
#include <doctest/doctest.h>

#include <algorithm>

#include "client.hpp"
#include "device/usb_descriptors.hpp"

using namespace usbip_test;
using torsio::emulator::usbip::Session;
using torsio::emulator::usbip::UsbKnob;

namespace {

constexpr std::int32_t kStall = -32;

struct Rig {
  UsbKnob knob{{.serial = "RIG-1"}};
  Client client{knob};
  Rig() {
    client.attach();
    client.configure();
  }
};

Bytes command(std::uint8_t sequence, std::uint8_t op) {
  return padded({0x10, sequence, 0, 0, op}, 64);
}
constexpr std::uint8_t kArm = 1;
constexpr std::uint8_t kDisarm = 2;

Bytes string_bytes(std::string_view text) {
  Bytes bytes{static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
  for (const char c : text) {
    bytes.push_back(static_cast<std::uint8_t>(c));
    bytes.push_back(0);
  }
  return bytes;
}

Bytes copy(std::span<const std::uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

// Before the import ------------------------------------------------------------------------------

TEST_CASE("device list shows one knob at the documented places") {
  UsbKnob knob({});
  Client client(knob);
  client.send(kListRequest);
  const Bytes list = client.take();
  REQUIRE(list.size() == 12 + 312 + 4 * torsio::device::usb_interfaces().size());
  CHECK(word(list, 0) == 0x01110005);
  CHECK(word(list, 4) == 0);
  CHECK(word(list, 8) == 1);
  CHECK(std::string_view(reinterpret_cast<const char*>(&list[12])).starts_with("/sys/devices/"));
  CHECK(Bytes(list.begin() + 0x10C, list.begin() + 0x12C) == padded(text("1-1"), 32));
  CHECK(word(list, 0x12C) == 1);  // bus
  CHECK(word(list, 0x130) == 2);  // device
  CHECK(word(list, 0x134) == 2);  // full speed
  CHECK(word(list, 0x138) == 0x12090001);
  // Class 0; configuration 1 of 1; one interface at least, the first of them HID.
  CHECK(Bytes(list.begin() + 0x13E, list.begin() + 0x143) == Bytes{0, 0, 0, 1, 1});
  CHECK(list[0x143] == torsio::device::usb_interfaces().size());
  CHECK(Bytes(list.begin() + 0x144, list.begin() + 0x148) == Bytes{3, 0, 0, 0});
  CHECK(client.session().finished());
}

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

// Enumeration ------------------------------------------------------------------------------------

TEST_CASE("enumeration gives the descriptors of the firmware") {
  Rig rig;
  const Bytes device = rig.client.control_in(setup_packet(0x80, 6, 0x0100, 0, 18), 18).data;
  REQUIRE(device.size() == 18);
  CHECK(Bytes(device.begin(), device.begin() + 12) ==
        Bytes{18, 1, 0, 2, 0, 0, 0, 64, 0x09, 0x12, 0x01, 0x00});
  CHECK(device ==
        copy(torsio::device::device_descriptor(rig.knob.device().board().firmware_version)));
  CHECK(rig.client.control_in(setup_packet(0x80, 6, 0x0200, 0, 1024), 1024).data ==
        copy(torsio::device::configuration_descriptor()));
  const std::size_t interfaces = torsio::device::usb_interfaces().size();
  for (std::uint16_t number = 0; number < interfaces; ++number) {
    const auto size = static_cast<std::uint16_t>(
        torsio::device::usb_interfaces()[number].report_descriptor.size());
    CHECK(rig.client.control_in(setup_packet(0x81, 6, 0x2200, number, size), size).data ==
          copy(torsio::device::usb_interfaces()[number].report_descriptor));
    CHECK(rig.client.control_in(setup_packet(0x81, 6, 0x2100, number, 9), 9).data ==
          copy(torsio::device::hid_descriptor(static_cast<std::uint8_t>(number))));
  }
}

TEST_CASE("strings are maker, product and the serial number that was chosen") {
  Rig rig;
  const auto string = [&](std::uint16_t index) {
    return rig.client
        .control_in(setup_packet(0x80, 6, static_cast<std::uint16_t>(0x0300 | index), 0x0409, 255),
                    255)
        .data;
  };
  CHECK(string(0) == Bytes{4, 3, 0x09, 0x04});
  CHECK(string(1) == string_bytes("Torsio"));
  CHECK(string(2) == string_bytes("Torsio haptic knob"));
  CHECK(string(3) == string_bytes("RIG-1"));
}

TEST_CASE("control transfer returns no more than the client has room for") {
  Rig rig;
  for (const std::uint32_t room : {0U, 1U, 9U, 17U}) {
    const Reply reply = rig.client.control_in(setup_packet(0x80, 6, 0x0100, 0, 18), room);
    CHECK(reply.length == room);
    CHECK(reply.status == 0);
  }
  CHECK(rig.client.control_in(setup_packet(0x80, 6, 0x0100, 0, 18), 4096).length == 18);
  CHECK(rig.client.control_in(setup_packet(0x80, 6, 0x0100, 0, 8), 64).length == 8);
}

TEST_CASE("configuration can be asked for, taken back and set again") {
  Rig rig;
  CHECK(rig.client.control_in(setup_packet(0x80, 8, 0, 0, 1), 1).data == Bytes{1});
  CHECK(rig.knob.has_host());
  CHECK(rig.client.control_out(setup_packet(0x00, 9, 0, 0, 0)).status == 0);
  CHECK_FALSE(rig.knob.has_host());
  CHECK(rig.client.get_feature(1).status == kStall);
  rig.client.configure();
  CHECK(rig.client.get_feature(1).status == 0);
}

TEST_CASE("a set address that a client should have kept is answered") {
  Rig rig;
  CHECK(rig.client.control_out(setup_packet(0x00, 5, 7, 0, 0)).status == 0);
  CHECK(rig.client.get_feature(1).status == 0);
}

// Reports ----------------------------------------------------------------------------------------

TEST_CASE("identity tells serial number and control period") {
  Rig rig;
  const Reply identity = rig.client.get_feature(0x01);
  REQUIRE(identity.data.size() == 64);
  CHECK(identity.data[0] == 1);
  CHECK(std::ranges::search(identity.data, text("RIG-1")).begin() != identity.data.end());
  const Bytes millisecond{0x40, 0x42, 0x0F, 0x00};  // 1,000,000 ns
  CHECK(std::ranges::search(identity.data, millisecond).begin() != identity.data.end());
}

TEST_CASE("configuration can be written and is read back") {
  Rig rig;
  Bytes config = rig.client.get_feature(0x05).data;
  REQUIRE(config.size() == 64);
  const Bytes half{0, 0, 0, 0x3F};
  const Bytes three_quarters{0, 0, 0x40, 0x3F};
  REQUIRE(Bytes(config.begin() + 5, config.begin() + 9) == half);  // beta
  std::ranges::copy(three_quarters, config.begin() + 5);
  CHECK(rig.client.set_feature(config).status == 0);
  rig.client.frame();
  rig.client.frame();
  const Bytes after = rig.client.get_feature(0x05).data;
  CHECK(Bytes(after.begin() + 5, after.begin() + 9) == three_quarters);
}

TEST_CASE("output report is answered by an acknowledgement") {
  Rig rig;
  const std::uint32_t in = rig.client.submit_in(1, 64);
  const std::uint32_t out = rig.client.submit_out(1, command(9, kDisarm));
  const Reply sent = rig.client.wait();
  CHECK(sent.sequence == out);
  CHECK(sent.status == 0);
  CHECK(sent.length == 64);
  const Reply answer = rig.client.wait();
  CHECK(answer.sequence == in);
  CHECK(answer.status == 0);
  REQUIRE(answer.data.size() == 64);
  CHECK(Bytes(answer.data.begin(), answer.data.begin() + 5) == Bytes{0x41, 9, 0, 0x10, 0});
}

TEST_CASE("IN transfer waits until there is data") {
  Rig rig;
  rig.client.submit_in(1, 64);
  for (int i = 0; i < 50; ++i) rig.client.frame();
  CHECK_FALSE(rig.client.reply());
  rig.client.submit_out(1, command(1, kDisarm));
  (void)rig.client.wait();
  CHECK(rig.client.wait().data.at(0) == 0x41);
}

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
  CHECK_FALSE(rig.client.reply());  // nobody had listened, so there is nothing to make up for
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

TEST_CASE("unknown request stalls and the next one works") {
  struct Request {
    std::uint8_t kind, request;
    std::uint16_t value, index, length;
  };
  Rig rig;
  const Bytes identity = rig.client.get_feature(1).data;
  for (const auto& [kind, request, value, index, length] : {
           Request{0xA1, 0x01, 0x037E, 0, 64},  // no such report
           Request{0xA1, 0x01, 0x0310, 0, 64},  // an output report
           Request{0xA1, 0x01, 0x0140, 0, 64},  // input reports come by themselves
           Request{0xA1, 0x01, 0x0301, 9, 64},  // no such interface
           Request{0xA1, 0x03, 0, 0, 1},        // GET_PROTOCOL: no boot device
           Request{0x21, 0x0B, 0, 0, 0},        // SET_PROTOCOL
           Request{0x21, 0x0A, 0x0400, 0, 0},   // an idle rate
           Request{0x21, 0x09, 0x0310, 0, 0},   // SET_REPORT without data
           Request{0x21, 0x55, 0, 0, 0},        // no such class request
           Request{0xC0, 0x01, 0, 0, 64},       // no vendor requests
           Request{0x60, 0x01, 0, 0, 0},        // no such type
           Request{0x81, 0x06, 0x2300, 0, 64},  // no physical descriptor
           Request{0x80, 0x06, 0x0600, 0, 10},  // full speed only: no qualifier
           Request{0x80, 0x06, 0x03EE, 0, 64},  // no such string
           Request{0x80, 0x06, 0x0100, 0, 0},   // a descriptor of no length
           Request{0x00, 0x03, 0x0007, 0, 0},   // no such feature
           Request{0x02, 0x03, 0, 0x8F, 0},     // no such endpoint
           Request{0x80, 0xFF, 0xFFFF, 0xFFFF, 0xFFFF},
       }) {
    const Bytes setup = setup_packet(kind, request, value, index, length);
    const Reply reply = (kind & 0x80) != 0 && length > 0 ? rig.client.control_in(setup, length)
                                                         : rig.client.control_out(setup);
    CAPTURE(kind);
    CAPTURE(request);
    CHECK(reply.status == kStall);
    CHECK(reply.length == 0);
    CHECK(rig.client.get_feature(1).data == identity);
  }
}

TEST_CASE("bad feature report stalls and changes nothing") {
  Rig rig;
  const Bytes good = rig.client.get_feature(0x05).data;
  Bytes nan = good;
  nan[7] = 0xC0;
  nan[8] = 0x7F;
  Bytes padding = good;
  padding[63] = 1;
  CHECK(rig.client.set_feature(nan).status == kStall);
  CHECK(rig.client.set_feature(padding).status == kStall);
  CHECK(rig.client.set_feature(Bytes(good.begin(), good.begin() + 63), 63).status == kStall);
  CHECK(rig.client.set_feature(good + Bytes{0}, 65).status == kStall);
  CHECK(rig.client.get_feature(0x05).data == good);
}

TEST_CASE("less or more data than announced stalls and changes nothing") {
  Rig rig;
  const Bytes good = rig.client.get_feature(0x05).data;
  CHECK(rig.client.set_feature(Bytes(good.begin(), good.begin() + 50)).status == kStall);
  CHECK(rig.client.set_feature({0x05}).status == kStall);
  CHECK(rig.client.control_out(setup_packet(0x21, 9, 0x0305, 0, 64)).status == kStall);
  CHECK(rig.client.set_feature(good + good).status == kStall);
  CHECK(rig.client.get_feature(0x05).data == good);
}

TEST_CASE("data against the direction of its request stalls") {
  Rig rig;
  CHECK(rig.client.control_out(setup_packet(0x80, 6, 0x0100, 0, 18), Bytes(18)).status == kStall);
  CHECK(rig.client.control_in(setup_packet(0x21, 9, 0x0305, 0, 64), 64).status == kStall);
  CHECK(rig.client.control_out(setup_packet(0x00, 0, 0, 0, 2), Bytes(2)).status == kStall);
  CHECK(rig.client.control_out(setup_packet(0x00, 6, 0x0100, 0, 18), Bytes(18)).status == kStall);
  CHECK(rig.client.get_feature(1).status == 0);
}

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

TEST_CASE("halted endpoint stalls until the halt is cleared") {
  Rig rig;
  CHECK(rig.client.control_out(setup_packet(0x02, 3, 0, 0x01, 0)).status == 0);
  CHECK(rig.client.control_in(setup_packet(0x82, 0, 0, 0x01, 2), 2).data == Bytes{1, 0});
  rig.client.submit_out(1, command(1, kDisarm));
  CHECK(rig.client.wait().status == kStall);
  CHECK(rig.client.control_out(setup_packet(0x02, 1, 0, 0x01, 0)).status == 0);
  rig.client.submit_out(1, command(2, kDisarm));
  CHECK(rig.client.wait().status == 0);
}

TEST_CASE("requests that break the protocol end the conversation and the next client is served") {
  const Bytes device_7 = words({1, 9, 7, 1, 0, 0, 18, 0, 0, 0, 0, 0});
  for (const Bytes& bytes :
       {words({9, 1, kDeviceId, 0, 0, 0, 0, 0, 0, 0, 0, 0}),           // no such command
        words({1, 1, kDeviceId, 2, 0, 0, 0, 0, 0, 0, 0, 0}),           // no such direction
        words({1, 1, kDeviceId, 0, 1, 0, 0x7FFFFFFF, 0, 0, 0, 0, 0}),  // 2 GiB
        words({1, 1, kDeviceId, 0, 1, 0, 0xFFFFFFFF, 0, 0, 0, 0, 0}),  // -1 byte
        words({1, 1, kDeviceId, 1, 1, 0, 64, 0, 3, 0, 0, 0}),          // isochronous
        device_7, Bytes(48, 0xFF)}) {
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

// Unlinking, resets and the end ------------------------------------------------------------------

TEST_CASE("unlinked transfer is answered once, as unlinked") {
  Rig rig;
  const std::uint32_t first = rig.client.submit_in(1, 64);
  const std::uint32_t second = rig.client.submit_in(1, 64);
  const std::uint32_t unlink = rig.client.next_sequence();
  rig.client.send(unlink_request(unlink, first));
  const Reply answer = rig.client.wait();
  CHECK(answer.command == 4);
  CHECK(answer.sequence == unlink);
  CHECK(answer.status == -104);
  rig.client.submit_out(1, command(1, kDisarm));
  (void)rig.client.wait();
  CHECK(rig.client.wait().sequence == second);
  for (int i = 0; i < 10; ++i) rig.client.frame();
  CHECK_FALSE(rig.client.reply());
}

TEST_CASE("unlinking what is over is answered with success") {
  Rig rig;
  const std::uint32_t out = rig.client.submit_out(1, command(1, kDisarm));
  (void)rig.client.wait();
  rig.client.send(unlink_request(rig.client.next_sequence(), out));
  const Reply answer = rig.client.wait();
  CHECK(answer.command == 4);
  CHECK(answer.status == 0);
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
    // The device waits for 64 bytes of which none come.
    CHECK(client.control_out(setup_packet(0x21, 9, 0x0305, 0, 64)).status == kStall);
  }
  Client next(knob);
  next.attach();
  next.configure();
  CHECK(next.get_feature(1).status == 0);
}

TEST_CASE("plugging in two hundred times works like the first time") {
  UsbKnob knob({});
  for (int i = 0; i < 200; ++i) {
    Client client(knob);
    client.attach();
    client.configure();
    client.submit_in(1, 64);
    client.submit_out(1, command(static_cast<std::uint8_t>(i), kDisarm));
    CHECK(client.wait().status == 0);
  }
}
