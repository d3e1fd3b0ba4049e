// Bytes against those that the kernel's documentation of USB/IP shows as an example.
#include <doctest/doctest.h>

#include "client.hpp"
#include "emulator/usbip/messages.hpp"

using namespace torsio::emulator::usbip;
using usbip_test::text;
using usbip_test::words;
using Raw = usbip_test::Bytes;

namespace {

// "CmdIntrIN", "CmdIntrOUT" and their replies, without the data.
const Raw kInRequest = words({1, 0xd05, 0x0001000f, 1, 1, 0x200, 0x40, 0xffffffff, 0, 4, 0, 0});
const Raw kOutRequest = words({1, 0xd06, 0x0001000f, 0, 1, 0, 0x40, 0xffffffff, 0, 4, 0, 0});
const Raw kOutReply = words({3, 0xd06, 0, 0, 0, 0, 0x40, 0, 0xffffffff, 0, 0, 0});

}  // namespace

TEST_CASE("codec reads the documented IN request") {
  const auto [submit, unlink] = read_request(kInRequest);
  REQUIRE(submit);
  CHECK_FALSE(unlink);
  CHECK(submit->sequence == 0xd05);
  CHECK(submit->device_id == 0x0001000f);
  CHECK(submit->direction == Direction::in);
  CHECK(submit->endpoint == 1);
  CHECK(submit->length == 64);
}

TEST_CASE("codec reads the documented OUT request") {
  const auto submit = read_request(kOutRequest).submit;
  REQUIRE(submit);
  CHECK(submit->sequence == 0xd06);
  CHECK(submit->direction == Direction::out);
}

TEST_CASE("codec writes the documented reply to an OUT request") {
  Submit submit = read_request(kOutRequest).submit.value();
  submit.packets = 0xFFFFFFFF;
  Raw out;
  write_submit_reply(out, submit, kOk, 64, {});
  CHECK(out == kOutReply);
}

TEST_CASE("codec reads and answers an unlink request at the documented places") {
  const Raw request = usbip_test::unlink_request(0xd07, 0xd05);
  const auto [submit, unlink] = read_request(request);
  CHECK_FALSE(submit);
  REQUIRE(unlink);
  CHECK(unlink->sequence == 0xd07);
  CHECK(unlink->target == 0xd05);
  Raw out;
  write_unlink_reply(out, 0xd07, kUnlinked);
  CHECK(out == words({4, 0xd07, 0, 0, 0, 0xFFFFFF98, 0, 0, 0, 0, 0, 0}));
}

TEST_CASE("codec knows no other command and no third direction") {
  for (const std::uint32_t command : {0U, 3U, 4U, 5U, 0xFFFFFFFFU}) {
    Raw bytes = kInRequest;
    const Raw first = words({command});
    std::copy(first.begin(), first.end(), bytes.begin());
    const auto [submit, unlink] = read_request(bytes);
    CHECK_FALSE(submit);
    CHECK_FALSE(unlink);
  }
  Raw bytes = kInRequest;
  bytes[15] = 2;
  CHECK_FALSE(read_request(bytes).submit);
}

TEST_CASE("codec reads a bus id that fills its field without a zero") {
  CHECK(read_bus_id(Raw(32, 'x')) == std::string_view("xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"));
  CHECK(read_bus_id(usbip_test::padded(text("1-1"), 32)) == "1-1");
}
