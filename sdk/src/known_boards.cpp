#include "known_boards.hpp"

#include <algorithm>
#include <cstdint>

#include "boards/all.hpp"
#include "boards/reference.hpp"
#include "emulated.hpp"

namespace torsio {
namespace {

constexpr std::uint8_t kEmulatedNumber = 0;

consteval bool numbers_differ() {
  for (const boards::Board& board : boards::kAll) {
    for (const boards::Board& other : boards::kAll) {
      if (board.number == kEmulatedNumber) return false;
      if (board.name != other.name && board.number == other.number) return false;
    }
  }
  return true;
}
static_assert(numbers_differ(), "each board has a number of its own, and 0 is the emulated one's");

const boards::Board* find(std::uint8_t number) {
  const auto* const found = std::ranges::find(boards::kAll, number, &boards::Board::number);
  return found == boards::kAll.end() ? nullptr : found;
}

}  // namespace

std::string board_name(std::uint8_t number) {
  if (number == kEmulatedNumber) return std::string(kEmulated);
  const boards::Board* const found = find(number);
  return found != nullptr ? std::string(found->name) : "board " + std::to_string(number);
}

bool moves_parts(std::uint8_t number) { return number != kEmulatedNumber; }

device::WiringRule wiring_rule(std::uint8_t number) {
  if (number == kEmulatedNumber) return boards::kReference.wiring_rule;
  const boards::Board* const found = find(number);
  return found != nullptr ? found->wiring_rule : nullptr;
}

}  // namespace torsio
