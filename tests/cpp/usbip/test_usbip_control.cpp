// Control transfers: TinyUSB's stack with the firmware's descriptors and feature reports.
#include <doctest/doctest.h>

#include <algorithm>
#include <span>
#include <string_view>

#include "device/usb_descriptors.hpp"
#include "rig.hpp"

using namespace usbip_test;

TEST_CASE("every interface says that it has no status, and no other is there to be asked") {
  Rig rig;
  const auto interfaces = static_cast<std::uint16_t>(torsio::device::usb_interfaces().size());
  for (std::uint16_t number = 0; number < interfaces; ++number) {
    const Reply answer = rig.client.control_in(setup_packet(0x81, 0, 0, number, 2), 2);
    CHECK(answer.status == 0);
    CHECK(answer.data == Bytes{0, 0});
  }
  CHECK(rig.client.control_in(setup_packet(0x81, 0, 0, interfaces, 2), 2).status == kStall);
  // Asked the wrong way round, with data to the knob.
  CHECK(rig.client.control_out(setup_packet(0x01, 0, 0, 0, 2), {1, 2}).status == kStall);
  CHECK(rig.client.control_out(setup_packet(0x01, 0, 0, 0, 0), {}).status == kStall);
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

TEST_CASE("every standard request that has a meaning is answered") {
  struct Request {
    std::uint8_t kind, request;
    std::uint16_t value, index;
    Bytes answer;  // empty: no data stage
  };
  Rig rig;
  for (const auto& [kind, request, value, index, answer] : {
           Request{0x80, 0x00, 0, 0, {0, 0}},  // GET_STATUS: powered by the bus, wakes no host
           Request{0x81, 0x00, 0, 1, {0, 0}},
           Request{0x82, 0x00, 0, 0x00, {0, 0}},
           Request{0x82, 0x00, 0, 0x80, {0, 0}},
           Request{0x82, 0x00, 0, 0x82, {0, 0}},
           Request{0x80, 0x08, 0, 0, {1}},  // GET_CONFIGURATION
           Request{0x81, 0x0A, 0, 0, {0}},  // GET_INTERFACE
           Request{0x81, 0x0A, 0, 1, {0}},
           Request{0x01, 0x0B, 0, 1, {}},     // SET_INTERFACE
           Request{0x00, 0x09, 1, 0, {}},     // SET_CONFIGURATION, as it is
           Request{0x02, 0x03, 0, 0x02, {}},  // SET_FEATURE: halt
           Request{0x82, 0x00, 0, 0x02, {1, 0}},
           Request{0x02, 0x01, 0, 0x02, {}},  // CLEAR_FEATURE
           Request{0x82, 0x00, 0, 0x02, {0, 0}},
           Request{0xA1, 0x02, 0, 1, {0}},  // GET_IDLE
           Request{0x21, 0x0A, 0, 1, {}},   // SET_IDLE
       }) {
    const auto size = static_cast<std::uint16_t>(answer.size());
    const Bytes setup = setup_packet(kind, request, value, index, size);
    const Reply reply =
        size > 0 ? rig.client.control_in(setup, size) : rig.client.control_out(setup);
    CAPTURE(kind);
    CAPTURE(request);
    CHECK(reply.status == 0);
    CHECK(reply.data == answer);
  }
  // Before it is configured it has its control endpoint alone.
  REQUIRE(rig.client.control_out(setup_packet(0x00, 9, 0, 0, 0)).status == 0);
  CHECK(rig.client.control_in(setup_packet(0x82, 0, 0, 0x81, 2), 2).status == kStall);
  CHECK(rig.client.control_in(setup_packet(0x81, 0, 0, 0, 2), 2).status == kStall);
  CHECK(rig.client.control_out(setup_packet(0x01, 11, 0, 0, 0)).status == kStall);
  CHECK(rig.client.control_in(setup_packet(0x82, 0, 0, 0, 2), 2).data == Bytes{0, 0});
  CHECK(rig.client.control_out(setup_packet(0x00, 9, 200, 0, 0)).status == kStall);
  CHECK(rig.client.control_in(setup_packet(0x80, 8, 0, 0, 1), 1).data == Bytes{0});
}

TEST_CASE("input reports can be asked for as they are, and none is lost by that") {
  Rig rig;
  const auto ask = [&](std::uint8_t id, std::uint16_t interface) {
    const auto value = static_cast<std::uint16_t>(0x0100 | id);
    return rig.client.control_in(setup_packet(0xA1, 1, value, interface, 64), 64).data;
  };
  rig.knob.device().set_buttons(3);
  CHECK(ask(1, 1) == Bytes{1, 0, 0, 3, 0, 0});
  CHECK(ask(2, 1) == Bytes{2, 0x06, 0, 1});  // actuators enabled, and the user lets games have them
  CHECK(ask(1, 1) == Bytes{1, 0, 0, 3, 0, 0});
  rig.client.submit_out(1, command(9, kDisarm));
  (void)rig.client.wait();
  rig.client.frame();
  for (const std::uint8_t id : std::initializer_list<std::uint8_t>{0x40, 0x41, 0x42}) {
    const Bytes report = ask(id, 0);
    REQUIRE(report.size() == 64);
    CHECK(report[0] == id);
  }
  CHECK(ask(0x40, 0)[1] == 16);  // one sample, of axis 0
  rig.client.submit_in(2, 64);
  CHECK(rig.client.wait().data.at(3) == 0);  // as before
  rig.client.submit_in(2, 64);
  rig.client.submit_in(2, 64);
  CHECK(rig.client.wait().data.at(0) + rig.client.wait().data.at(0) == 3);  // axis and state
  rig.client.submit_in(1, 64);
  CHECK(rig.client.wait().data.at(1) == 9);
}

TEST_CASE("output reports are taken by the control endpoint as by their own") {
  Rig rig;
  const auto say = [&](std::uint16_t interface, const Bytes& report) {
    const auto value = static_cast<std::uint16_t>(0x0200 | report.at(0));
    const auto size = static_cast<std::uint16_t>(report.size());
    return rig.client.control_out(setup_packet(0x21, 9, value, interface, size), report).status;
  };
  CHECK(say(0, command(7, kDisarm)) == 0);
  rig.client.submit_in(1, 64);
  const Bytes answer = rig.client.wait().data;
  CHECK(Bytes(answer.begin(), answer.begin() + 5) == Bytes{0x41, 7, 0, 0x10, 0});
  // A constant force of a game: made, set and started.
  REQUIRE(rig.client.control_out(setup_packet(0x21, 9, 0x0321, 1, 4), {0x21, 1, 0, 0}).status == 0);
  CHECK(say(1, {0x15, 1, 0x00, 0x20}) == 0);
  CHECK(say(1, {0x1A, 1, 1, 1}) == 0);
  for (int i = 0; i < 5; ++i) rig.client.frame();
  CHECK(rig.knob.device().device().state() == torsio::protocol::State::armed);
  CHECK(rig.client.control_in(setup_packet(0xA1, 1, 0x0102, 1, 64), 64).data ==
        Bytes{2, 0x0E, 1, 1});
  // Without room it is refused, since a control transfer cannot wait.
  int taken = 0;
  while (taken < 100 && say(0, command(8, kDisarm)) == 0) ++taken;
  CHECK(taken > 4);
  CHECK(taken < 100);
}

// Feature reports --------------------------------------------------------------------------------

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
           Request{0xA1, 0x01, 0x0143, 0, 64},  // no such input report
           Request{0xA1, 0x01, 0x0103, 1, 64},  // nor of the game interface
           Request{0xA1, 0x01, 0x0301, 0x0100, 64},
           Request{0xA1, 0x01, 0x0301, 9, 64},  // no such interface
           Request{0xA1, 0x03, 0, 0, 1},        // GET_PROTOCOL: no boot device
           Request{0x21, 0x0B, 0, 0, 0},        // SET_PROTOCOL
           Request{0x21, 0x0A, 0x0400, 0, 0},   // an idle rate
           Request{0x21, 0x09, 0x0310, 0, 0},   // SET_REPORT without data
           Request{0x21, 0x55, 0, 0, 0},        // no such class request
           Request{0xC0, 0x01, 0, 0, 64},       // no vendor requests
           Request{0x60, 0x01, 0, 0, 0},        // no such type
           Request{0x81, 0x06, 0x2300, 0, 64},  // no physical descriptor
           Request{0x81, 0x06, 0x2101, 0, 9},   // there is one HID descriptor
           Request{0x81, 0x06, 0x2201, 1, 64},  // and one report descriptor
           Request{0x80, 0x06, 0x0600, 0, 10},  // full speed only: no qualifier
           Request{0x80, 0x06, 0x03EE, 0, 64},  // no such string
           Request{0x80, 0x06, 0x0100, 0, 0},   // a descriptor of no length
           Request{0x80, 0x06, 0x0101, 0, 18},  // one device descriptor
           Request{0x80, 0x06, 0x0201, 0, 64},  // one configuration, of index 0
           Request{0x80, 0x06, 0x0202, 0, 64},
           Request{0x80, 0x06, 0x02FF, 0, 64},
           Request{0x80, 0x06, 0x0700, 0, 64},  // and none of another speed
           Request{0x80, 0x06, 0x0F00, 0, 64},  // BOS is of USB 2.1
           Request{0x00, 0x07, 0x0100, 0, 0},   // SET_DESCRIPTOR
           Request{0x00, 0x09, 0x0002, 0, 0},   // a configuration that does not exist
           Request{0x00, 0x09, 0x00C8, 0, 0},
           Request{0x00, 0x09, 0x0101, 0, 0},
           Request{0x80, 0x09, 0x0001, 0, 0},  // against its direction
           Request{0x80, 0x09, 0x0001, 0, 1},
           Request{0x01, 0x09, 0x0001, 0, 0},  // for an interface
           Request{0x01, 0x0B, 0x0001, 0, 0},  // SET_INTERFACE: an alternate setting
           Request{0x01, 0x0B, 0x0000, 2, 0},  // no such interface
           Request{0x01, 0x0B, 0x0000, 0x0100, 0},
           Request{0x81, 0x0A, 0, 2, 1},  // GET_INTERFACE
           Request{0x81, 0x0A, 0, 0xFF, 1},
           Request{0x81, 0x00, 0, 2, 2},  // GET_STATUS
           Request{0x82, 0x00, 0, 0x83, 2},
           Request{0x82, 0x00, 0, 0x03, 2},
           Request{0x82, 0x00, 0, 0x0181, 2},
           Request{0x82, 0x0C, 0, 0x81, 2},  // SYNCH_FRAME
           Request{0x80, 0x0A, 0, 0, 1},
           Request{0x00, 0x03, 0x0001, 0, 0},       // SET_FEATURE: it wakes no host
           Request{0x00, 0x01, 0x0001, 0, 0},       // CLEAR_FEATURE
           Request{0x00, 0x03, 0x0002, 0x0100, 0},  // test modes are of high speed
           Request{0x00, 0x03, 0x0007, 0, 0},       // no such feature
           Request{0x01, 0x03, 0, 0, 0},            // interfaces have none
           Request{0x01, 0x01, 0, 0, 0},
           Request{0x02, 0x03, 1, 0x81, 0},  // endpoints have one
           Request{0x02, 0x01, 1, 0x81, 0},
           Request{0x02, 0x03, 0, 0x00, 0},  // but not the control endpoint
           Request{0x02, 0x01, 0, 0x80, 0},
           Request{0x02, 0x03, 0, 0x03, 0},  // no such endpoint
           Request{0x02, 0x01, 0, 0x85, 0},
           Request{0x02, 0x03, 0, 0x8F, 0},
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

TEST_CASE("reports of another kind, interface or recipient stall and change nothing") {
  Rig rig;
  const Bytes good = rig.client.get_feature(0x05).data;
  Bytes other = good;
  other[60] = 0;
  // HID 1.11: the high byte of wValue is the kind, 1 input, 2 output, 3 feature.
  for (const std::uint16_t value :
       std::initializer_list<std::uint16_t>{0x0105, 0x0205, 0x0005, 0x0405}) {
    CAPTURE(value);
    CHECK(rig.client.control_in(setup_packet(0xA1, 1, value, 0, 64), 64).status == kStall);
    // An output report that does not exist is taken, and refused in an acknowledgement.
    const bool is_output = value == 0x0205;
    CHECK(rig.client.control_out(setup_packet(0x21, 9, value, 0, 64), other).status ==
          (is_output ? 0 : kStall));
  }
  // The id in the request differs from the data's.
  CHECK(rig.client.control_out(setup_packet(0x21, 9, 0x0306, 0, 64), good).status == kStall);
  // No interface 2; neither the device nor an endpoint has reports.
  CHECK(rig.client.control_in(setup_packet(0xA1, 1, 0x0305, 2, 64), 64).status == kStall);
  CHECK(rig.client.control_out(setup_packet(0x21, 9, 0x0305, 2, 64), good).status == kStall);
  CHECK(rig.client.control_in(setup_packet(0xA0, 1, 0x0305, 0, 64), 64).status == kStall);
  CHECK(rig.client.control_out(setup_packet(0x22, 9, 0x0305, 0, 64), good).status == kStall);
  // Requests of a vendor.
  CHECK(rig.client.control_in(setup_packet(0xC1, 1, 0x0305, 0, 64), 64).status == kStall);
  CHECK(rig.client.get_feature(0x05).data == good);
}

TEST_CASE("a game's feature report is read as long as it was announced") {
  Rig rig;
  // Create New Effect of type 1, of four bytes and of two.
  CHECK(rig.client.control_out(setup_packet(0x21, 9, 0x0321, 1, 4), {0x21, 1, 0, 0}).status == 0);
  CHECK(rig.client.control_in(setup_packet(0xA1, 1, 0x0322, 1, 5), 5).data[2] == 1);
  CHECK(rig.client.control_out(setup_packet(0x21, 9, 0x0321, 1, 2), {0x21, 1}).status == 0);
  CHECK(rig.client.control_in(setup_packet(0xA1, 1, 0x0322, 1, 5), 5).data[2] == 3);  // an error
}
