#include "device/config_store.hpp"

#include <algorithm>

#include "protocol/codec.hpp"
#include "protocol/registry.hpp"

namespace torsio::device {
namespace {

using protocol::report_size;

// A slot: magic, layout, number of the save, three reports as on the wire, checksum of all before
// it.
constexpr std::uint32_t kMagic = 0x53524F54;  // "TORS"
constexpr std::size_t kLayoutAt = 4;
constexpr std::size_t kSavesAt = 8;
constexpr std::size_t kActuatorAt = 12;
constexpr std::size_t kControlAt = kActuatorAt + report_size;
constexpr std::size_t kBoardAt = kControlAt + report_size;
constexpr std::size_t kChecksumAt = kBoardAt + report_size;
static_assert(kChecksumAt + 4 <= kSlotSize);

void put_u32(SlotBytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint32_t get_u32(const SlotBytes& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

std::uint32_t checksum(const SlotBytes& bytes) {
  return crc32(std::span(bytes).first(kChecksumAt));
}

std::optional<Config> read_slot(const SlotBytes& bytes) {
  if (get_u32(bytes, 0) != kMagic || get_u32(bytes, kLayoutAt) != protocol::fingerprint() ||
      get_u32(bytes, kChecksumAt) != checksum(bytes)) {
    return std::nullopt;
  }
  Config config;
  const std::span all(bytes);
  if (!protocol::decode(all.subspan(kActuatorAt, report_size), config.actuator).ok() ||
      !protocol::decode(all.subspan(kControlAt, report_size), config.control).ok() ||
      !protocol::decode(all.subspan(kBoardAt, report_size), config.board).ok() ||
      !check_consistent(config.actuator).ok() || !check_consistent(config.board).ok()) {
    return std::nullopt;
  }
  return config;
}

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

ConfigStore::ConfigStore(const StoredSlots& slots) {
  for (std::uint8_t slot = 0; slot < 2; ++slot) {
    const SlotBytes& bytes = slots.slot[slot];
    const std::optional<Config> config = read_slot(bytes);
    const std::uint32_t saves = get_u32(bytes, kSavesAt);
    if (!config || (loaded_ && saves < saves_)) continue;
    loaded_ = config;
    saves_ = saves;
    newest_slot_ = slot;
  }
}

SlotWrite ConfigStore::prepare(const Config& config) const {
  SlotWrite write;
  write.slot = static_cast<std::uint8_t>(1 - newest_slot_);
  put_u32(write.bytes, 0, kMagic);
  put_u32(write.bytes, kLayoutAt, protocol::fingerprint());
  put_u32(write.bytes, kSavesAt, saves_ + 1);
  const protocol::ReportBytes actuator = protocol::encode(config.actuator);
  const protocol::ReportBytes control = protocol::encode(config.control);
  const protocol::ReportBytes board = protocol::encode(config.board);
  std::copy(actuator.begin(), actuator.end(), write.bytes.begin() + kActuatorAt);
  std::copy(control.begin(), control.end(), write.bytes.begin() + kControlAt);
  std::copy(board.begin(), board.end(), write.bytes.begin() + kBoardAt);
  put_u32(write.bytes, kChecksumAt, checksum(write.bytes));
  return write;
}

void ConfigStore::written() {
  ++saves_;
  newest_slot_ = static_cast<std::uint8_t>(1 - newest_slot_);
}

}  // namespace torsio::device
