#include "device/config_store.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>
#include <type_traits>

#include "protocol/codec.hpp"
#include "protocol/registry.hpp"

namespace torsio::device {
namespace {

// A slot: magic, layout, number of the save, checksum of the calibrated values, the index's place,
// the configuration's reports as on the wire without padding, checksum of all before it.
constexpr std::uint32_t kMagic = 0x53524F54;  // "TORS"
constexpr std::size_t kLayoutAt = 4;
constexpr std::size_t kSavesAt = 8;
constexpr std::size_t kCalibratedAt = 12;
constexpr std::size_t kIndexAt = 16;
constexpr std::size_t kReportsAt = 20;
constexpr std::size_t kChecksumAt = kSlotSize - 4;

template <class Report>
constexpr std::size_t kStored = 1 + protocol::wire_size<Report>();
static_assert([]<class... Report>(std::type_identity<std::tuple<Report...>>) {
  return kReportsAt + (kStored<Report> + ...) <= kChecksumAt;
}(std::type_identity<protocol::AllConfigurations>{}));

/// Reads or writes the reports of a slot one after the other.
template <class Config, class Visit>
void for_each_part(Config& config, Visit&& visit) {
  std::size_t at = kReportsAt;
  protocol::for_each_configuration(config, [&]<class Report>(Report& report) {
    visit(report, at);
    at += kStored<std::remove_const_t<Report>>;
  });
}

void put_u32(SlotBytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint32_t get_u32(SlotView bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

std::uint32_t checksum(SlotView bytes) { return crc32(std::span(bytes).first(kChecksumAt)); }

std::optional<Config> read_slot(SlotView bytes, WiringRule rule) {
  if (get_u32(bytes, 0) != kMagic || get_u32(bytes, kLayoutAt) != protocol::fingerprint() ||
      get_u32(bytes, kChecksumAt) != checksum(bytes)) {
    return std::nullopt;
  }
  Config config;
  config.calibrated_values = get_u32(bytes, kCalibratedAt);
  config.index_counts = static_cast<std::int32_t>(get_u32(bytes, kIndexAt));
  bool good = true;
  for_each_part(config, [&]<class Report>(Report& report, std::size_t at) {
    protocol::ReportBytes padded{};
    std::copy_n(bytes.begin() + at, kStored<Report>, padded.begin());
    good = good && protocol::decode(padded, report).ok();
  });
  protocol::for_each_configuration(
      config, [&](const auto& report) { good = good && check_rules(report, config, rule).ok(); });
  return good ? std::optional(config) : std::nullopt;
}

std::uint32_t follow(std::uint32_t crc, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return crc;
}

/// The last sender and the number are no values. One report at a time, for the stack's sake.
template <class Report>
[[gnu::noinline]] std::uint32_t follow_values(std::uint32_t crc, const Report& report) {
  const protocol::ReportBytes bytes = protocol::encode(report);
  return follow(crc, std::span(bytes).subspan(1 + sizeof report.sequence));
}

bool are_assumed(const Config& config) {
  return config.calibration.values_are == protocol::Basis::assumed ||
         config.calibrated_values != values_checksum(config);
}

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes) { return ~follow(0xFFFFFFFFU, bytes); }

std::uint32_t values_checksum(const Config& config) {
  protocol::ActuatorConfig actuator = config.actuator;
  actuator.encoder_index_pin = 0;  // a pin, too
  std::uint32_t crc = follow_values(follow_values(0xFFFFFFFFU, actuator), config.shaft);
  // Values that every torque is measured by; pins and limits may change.
  const protocol::BoardConfig& board = config.board;
  for (const float value : {board.supply_v, board.motor_torque_constant_nm_per_a,
                            board.motor_resistance_ohm, board.motor_inductance_h,
                            board.brake_torque_constant_nm_per_a, board.current_sense_v_per_a}) {
    crc = follow(crc, std::bit_cast<std::array<std::uint8_t, sizeof value>>(value));
  }
  return ~crc;
}

protocol::CalibrationConfig calibration_now(const Config& config) {
  protocol::CalibrationConfig calibration = config.calibration;
  if (are_assumed(config)) calibration.values_are = protocol::Basis::assumed;
  return calibration;
}

Trust trust_in(const Config& config, bool moves_parts) {
  return trust_in(moves_parts, config.board.confirmed, are_assumed(config));
}

ConfigStore::ConfigStore(const SlotViews& slots, WiringRule rule) {
  for (std::uint8_t slot = 0; slot < 2; ++slot) {
    const SlotView bytes = slots.slot[slot];
    const std::optional<Config> config = read_slot(bytes, rule);
    const std::uint32_t saves = get_u32(bytes, kSavesAt);
    if (!config || (loaded_ && saves < saves_)) continue;
    loaded_ = config;
    saves_ = saves;
    newest_slot_ = slot;
  }
}

void ConfigStore::prepare(const Config& config, SlotWrite& write) const {
  write.slot = static_cast<std::uint8_t>(1 - newest_slot_);
  put_u32(write.bytes, 0, kMagic);
  put_u32(write.bytes, kLayoutAt, protocol::fingerprint());
  put_u32(write.bytes, kSavesAt, saves_ + 1);
  put_u32(write.bytes, kCalibratedAt, config.calibrated_values);
  put_u32(write.bytes, kIndexAt, static_cast<std::uint32_t>(config.index_counts));
  for_each_part(config, [&]<class Report>(const Report& report, std::size_t at) {
    const protocol::ReportBytes bytes = protocol::encode(report);
    std::copy_n(bytes.begin(), kStored<Report>, write.bytes.begin() + at);
  });
  put_u32(write.bytes, kChecksumAt, checksum(write.bytes));
}

void ConfigStore::written() {
  ++saves_;
  newest_slot_ = static_cast<std::uint8_t>(1 - newest_slot_);
}

}  // namespace torsio::device
