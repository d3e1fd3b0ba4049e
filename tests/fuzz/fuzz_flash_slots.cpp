// Any bytes in the two slots of the flash. The first byte says which slots get a right checksum and
// layout, as after damage that the checksum cannot see, or a firmware with another rule.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "boards/reference.hpp"
#include "device/config_store.hpp"
#include "device/device.hpp"
#include "fuzz.hpp"
#include "reports.hpp"

namespace {

using namespace torsio;

constexpr std::size_t kChecksumAt = device::kSlotSize - 4;

void put_u32(device::SlotBytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

void make_right(device::SlotBytes& bytes) {
  put_u32(bytes, 0, 0x53524F54);
  put_u32(bytes, 4, protocol::fingerprint());
  put_u32(bytes, kChecksumAt, device::crc32(std::span(bytes).first(kChecksumAt)));
}

/// Every field within its range, and the fields in agreement with each other.
void check(const device::Config& config) {
  fuzz::require(protocol::check(config.actuator).ok(), "actuator_config is in range");
  fuzz::require(protocol::check(config.control).ok(), "control_config is in range");
  fuzz::require(protocol::check(config.board).ok(), "board_config is in range");
  fuzz::require(protocol::check(config.game).ok(), "game_config is in range");
  fuzz::require(config.actuator.brake_torque_min_nm <= config.actuator.brake_torque_max_nm,
                "the brake's floor is below its limit");
  fuzz::require(!boards::kReference.wiring_rule(config.board, config.actuator.encoder_index_pin),
                "no pin has two jobs");
}

}  // namespace

std::span<const std::string_view> fuzz::dictionary() {
  // The begin of a slot, of this layout and of another.
  static const device::SlotBytes slot = [] {
    device::SlotBytes bytes{};
    make_right(bytes);
    return bytes;
  }();
  static const std::string_view words[] = {{reinterpret_cast<const char*>(slot.data()), 8},
                                           "TORS",
                                           bytes("\0\0\0\0"),
                                           bytes("\xFF\xFF\xFF\xFF"),
                                           bytes("\0\0\xC0\x7F"),
                                           bytes("\0\0\x80\x7F")};  // NaN, infinity
  return words;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  // Two whole slots of reports from the field lists.
  fuzz::FieldMaker make(seed);
  const std::size_t all = 1 + 2 * device::kSlotSize;
  if (max_size < all) return size;
  if (size < all) std::fill(data + size, data + all, std::uint8_t{0});
  data[0] = static_cast<std::uint8_t>(make.bits());
  device::Config config;
  if (make.below(2) == 0) make.fill(config.actuator);
  if (make.below(2) == 0) make.fill(config.control);
  if (make.below(2) == 0) make.fill(config.board);
  if (make.below(2) == 0) make.fill(config.game);
  const device::SlotWrite write = device::ConfigStore(device::empty_slots()).prepare(config);
  std::memcpy(data + 1 + make.below(2) * device::kSlotSize, write.bytes.data(), device::kSlotSize);
  return all;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Reader input(data, size);
  const std::uint8_t right = input.byte();
  device::StoredSlots slots = device::empty_slots();
  for (std::size_t slot = 0; slot < 2; ++slot) {
    const auto bytes = input.bytes(device::kSlotSize);
    std::copy(bytes.begin(), bytes.end(), slots.slot[slot].begin());
    if ((right >> slot & 1U) != 0) make_right(slots.slot[slot]);
  }
  const device::ConfigStore store(slots, boards::kReference.wiring_rule);
  const device::Config config = store.loaded().value_or(device::Config{});
  check(config);

  // A loaded configuration is saved to one slot and loads again, whatever the other held.
  const device::SlotWrite write = store.prepare(config);
  slots.slot[write.slot] = write.bytes;
  const device::ConfigStore again(slots, boards::kReference.wiring_rule);
  if (store.saves() != 0xFFFFFFFFU) {  // the count of saves starts anew in 4 thousand million
    fuzz::require(again.loaded().has_value(), "what was saved loads");
    fuzz::require(protocol::encode(again.loaded()->control) == protocol::encode(config.control),
                  "what was saved is what loads");
  }

  // A device that starts with it is disarmed and gives nothing.
  device::BoardInfo board;
  board.wiring_rule = boards::kReference.wiring_rule;
  const auto device = std::make_unique<device::Device>(board, slots);
  device->service();
  const device::TickOutputs out = device->tick({});
  fuzz::require(!out.enabled && out.motor_command_nm == 0.0F, "it boots disarmed");
  return 0;
}
