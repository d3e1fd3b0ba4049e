// Does over again what a board's program did: reads from standard input, a line each, what its main
// loop and its control interrupt gave the device, and prints what the device puts out.
//
//   retrace BOARD          by its name
//   receive|feature HEX   a report from the host
//   connected 0|1
//   service
//   tick HEX              -> "tick HEX", inputs and outputs as they lie in memory
//   next                  -> "input HEX", if there is a report for the host
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <iostream>
#include <string>
#include <type_traits>
#include <vector>

#include "boards/all.hpp"
#include "device/config_store.hpp"
#include "device/device.hpp"

namespace {

using namespace torsio;

// Also on the boards' processors.
static_assert(sizeof(device::TickInputs) == 20 && std::is_trivially_copyable_v<device::TickInputs>);
static_assert(sizeof(device::TickOutputs) == 12 && std::endian::native == std::endian::little);

std::vector<std::uint8_t> from_hex(const std::string& text) {
  std::vector<std::uint8_t> bytes(text.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    (void)std::from_chars(&text[2 * i], &text[2 * i] + 2, bytes[i], 16);
  }
  return bytes;
}

void print(const char* what, const void* bytes, std::size_t size) {
  constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint8_t byte = static_cast<const std::uint8_t*>(bytes)[i];
    text += {digits[byte >> 4], digits[byte & 15]};
  }
  std::cout << what << ' ' << text << '\n';
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const auto board_of = std::ranges::find(boards::kAll, arguments[1], &boards::Board::name);
  if (board_of == boards::kAll.end()) return 2;
  device::BoardInfo info;
  info.board = board_of->number;
  info.control_period_ns = board_of->control_period_ns;
  info.wiring_rule = board_of->wiring_rule;
  info.motor_lag_s = board_of->motor_lag_s;
  info.has_bootloader = true;
  info.moves_parts = true;
  device::Device board(info, device::empty_slots());

  std::string what;
  std::string details;
  while (std::cin >> what) {
    if (what == "service") {
      board.service();
    } else if (what == "next") {
      protocol::ReportBytes report;
      if (board.next_input(report)) print("input", report.data(), report.size());
    } else if (std::cin >> details; what == "receive") {
      if (!board.receive(from_hex(details))) return 1;
    } else if (what == "feature") {
      (void)board.set_feature(from_hex(details));
    } else if (what == "connected") {
      board.set_connected(details == "1");
    } else if (what == "tick") {
      device::TickInputs in;
      const std::vector<std::uint8_t> bytes = from_hex(details);
      if (bytes.size() != sizeof in) return 1;
      std::memcpy(&in, bytes.data(), sizeof in);
      device::TickOutputs out = board.tick(in);
      std::array<std::uint8_t, 9> shown;  // and no padding
      std::memcpy(shown.data(), &out, shown.size());
      print("tick", shown.data(), shown.size());
    } else {
      return 1;
    }
  }
}
