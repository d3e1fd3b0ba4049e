// The byte stream of a USB/IP client, hostile or only confused. The first byte of an input says how
// the rest is cut into pieces, and whether the device is imported before it.
#include <algorithm>
#include <array>
#include <span>

#include "emulator/usbip/session.hpp"
#include "emulator/usbip/usb_knob.hpp"
#include "fuzz.hpp"
#include "usbip_messages.hpp"

namespace {

using namespace torsio::emulator::usbip;
using Raw = std::span<const std::uint8_t>;

constexpr std::array<std::uint8_t, 40> kImport{0x01, 0x11, 0x80, 0x03, 0, 0, 0, 0, '1', '-', '1'};

/// GET_DESCRIPTOR of the device, as a whole message.
constexpr std::array<std::uint8_t, 48> kAskDevice{
    0, 0, 0, 1,  0, 0, 0, 9, 0, 1, 0, 2, 0, 0, 0, 1, 0,    0, 0, 0, 0, 0, 0,  0,
    0, 0, 0, 18, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 6, 0, 1, 0, 0, 18, 0};

}  // namespace

std::span<const std::string_view> fuzz::dictionary() { return fuzz::kUsbipWords; }

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  fuzz::FieldMaker make(seed);
  // Imported, and in pieces of any size.
  if (size == 0) data[size++] = static_cast<std::uint8_t>(0x80U | make.bits());
  return 1 + fuzz::put(fuzz::message(make), std::span(data, max_size).subspan(1), size - 1, make);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  UsbKnob knob({});
  const std::size_t piece = 1 + (data[0] & 0x7FU);
  {
    Session session(knob.exported());
    if ((data[0] & 0x80U) != 0) session.receive(kImport);
    Raw rest(data + 1, size - 1);
    std::size_t since_frame = 0;
    while (!rest.empty()) {
      const Raw now = rest.first(std::min(piece, rest.size()));
      session.receive(now);
      rest = rest.subspan(now.size());
      // About a frame for each message: frames take long.
      since_frame += now.size();
      if (since_frame < kAskDevice.size() && !rest.empty()) continue;
      since_frame = 0;
      session.frame();
      knob.advance();
    }
    fuzz::require(session.problem().empty() || session.finished(), "a problem ends a session");
  }
  // Whatever that was, the next client finds a knob that works.
  Session next(knob.exported());
  next.receive(kImport);
  fuzz::require(next.attached(), "the next client gets the device");
  next.output().clear();
  next.receive(kAskDevice);
  fuzz::require(next.output().size() == 48 + 18, "the next client gets the descriptor");
  fuzz::require(next.output()[48] == 18 && next.output()[49] == 1, "it is a device descriptor");
  return 0;
}
