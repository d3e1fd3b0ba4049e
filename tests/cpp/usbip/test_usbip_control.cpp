// Control transfers: TinyUSB's stack with the firmware's descriptors and feature reports.
#include <doctest/doctest.h>

#include <algorithm>
#include <span>
#include <string_view>

#include "device/usb_descriptors.hpp"
#include "rig.hpp"

using namespace usbip_test;

namespace {

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

// Feature reports --------------------------------------------------------------------------------

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
    CHECK(rig.client.control_out(setup_packet(0x21, 9, value, 0, 64), other).status == kStall);
  }
  // The id in the request is not that of the data.
  CHECK(rig.client.control_out(setup_packet(0x21, 9, 0x0306, 0, 64), good).status == kStall);
  // No interface 2, and neither the device nor an endpoint has reports.
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
