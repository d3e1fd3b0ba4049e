// Control transfers of any content. An input is a row of them: eight bytes of setup packet, one
// byte, the client's room or the size of its data, and that data if the request goes to the device.
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "emulator/usbip/host_controller.hpp"
#include "emulator/usbip/usb_knob.hpp"
#include "fuzz.hpp"

namespace {

using namespace torsio::emulator::usbip;

Completion transfer(HostController& host, const Submit& submit, Bytes data) {
  std::vector<Completion> done;
  host.submit(submit, std::move(data), done);
  fuzz::require(done.size() == 1, "a control transfer is over at once");
  const Completion& found = done.front();
  fuzz::require(found.status == kOk || found.status == kStalled, "it works or stalls");
  fuzz::require(found.actual_length <= submit.length, "nobody gets more than there is room for");
  fuzz::require(submit.direction == Direction::out || found.data.size() == found.actual_length,
                "the length is that of the data");
  return found;
}

Submit request(std::span<const std::uint8_t> setup, std::uint32_t length) {
  Submit submit{.sequence = 1,
                .direction = (setup[0] & 0x80U) != 0 ? Direction::in : Direction::out,
                .length = length};
  std::copy_n(setup.begin(), submit.setup.size(), submit.setup.begin());
  return submit;
}

// A setup packet, and the client's room or the size of its data behind it.
constexpr std::string_view kWords[] = {
    fuzz::bytes("\x80\6\0\1\0\0\x12\0\x12"),      // the device's descriptor
    fuzz::bytes("\x80\6\0\2\0\0\xFF\0\xFF"),      // the configuration's
    fuzz::bytes("\x80\6\1\3\x09\4\xFF\0\xFF"),    // a text
    fuzz::bytes("\x81\6\0\x22\0\0\xFF\0\xFF"),    // a report descriptor
    fuzz::bytes("\0\5\1\0\0\0\0\0\0"),            // an address
    fuzz::bytes("\0\x09\1\0\0\0\0\0\0"),          // configured
    fuzz::bytes("\0\x09\0\0\0\0\0\0\0"),          // and not
    fuzz::bytes("\x02\3\0\0\x81\0\0\0\0"),        // an endpoint halts
    fuzz::bytes("\x02\1\0\0\x81\0\0\0\0"),        // and goes on
    fuzz::bytes("\x81\0\0\0\0\0\2\0\2"),          // an interface's status
    fuzz::bytes("\x21\x0A\0\0\0\0\0\0\0"),        // no repeats while idle
    fuzz::bytes("\xA1\1\1\3\0\0\x40\0\x40"),      // the identity
    fuzz::bytes("\x21\x09\5\3\0\0\x40\0\x40\5"),  // a configuration, and its id
    fuzz::bytes("\x21\x09\x11\3\1\0\5\0\5\x11"),  // a game's new effect
    fuzz::bytes("\xA1\1\x12\3\1\0\5\0\5"),        // and where it is
};

}  // namespace

std::span<const std::string_view> fuzz::dictionary() { return kWords; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::array<std::uint8_t, 8> kConfigure{0x00, 9, 1, 0, 0, 0, 0, 0};
  constexpr std::array<std::uint8_t, 8> kIdentity{0xA1, 1, 0x01, 0x03, 0, 0, 64, 0};
  UsbKnob knob({.serial = "FUZZ"});
  knob.host().plug();
  (void)transfer(knob.host(), request(kConfigure, 0), {});

  std::span<const std::uint8_t> rest(data, size);
  std::vector<Completion> ignored;
  while (rest.size() >= 9) {
    const Submit submit = request(rest, rest[8]);
    rest = rest.subspan(9);
    const std::size_t payload =
        submit.direction == Direction::out ? std::min<std::size_t>(submit.length, rest.size()) : 0;
    (void)transfer(knob.host(), submit,
                   Bytes(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(payload)));
    rest = rest.subspan(payload);
    knob.host().frame(ignored);
    // An input with effect waits for a tick; the others need no physics.
    if (payload != 0) knob.advance();
  }
  knob.advance();

  // A new bus reset, and the knob is itself again.
  knob.host().unplug();
  knob.host().plug();
  fuzz::require(transfer(knob.host(), request(kConfigure, 0), {}).status == kOk,
                "it can be configured");
  const Completion identity = transfer(knob.host(), request(kIdentity, 64), {});
  fuzz::require(identity.status == kOk && identity.data.size() == 64, "it says who it is");
  const std::string_view serial = "FUZZ";
  fuzz::require(!std::ranges::search(identity.data, serial).empty(), "it is the same knob");
  return 0;
}
