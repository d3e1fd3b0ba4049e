#include "emulator/usbip/messages.hpp"

#include <algorithm>

namespace torsio::emulator::usbip {
namespace {

constexpr std::uint16_t kListReply = 0x0005;
constexpr std::uint16_t kImportReply = 0x0003;

constexpr std::uint32_t kSubmit = 1;
constexpr std::uint32_t kUnlink = 2;
constexpr std::uint32_t kSubmitReply = 3;
constexpr std::uint32_t kUnlinkReply = 4;

constexpr std::size_t kPathSize = 256;

std::uint16_t read16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>((bytes[at] << 8) | bytes[at + 1]);
}

std::uint32_t read32(std::span<const std::uint8_t> bytes, std::size_t at) {
  return (std::uint32_t{read16(bytes, at)} << 16) | read16(bytes, at + 2);
}

void write8(Bytes& out, std::uint32_t value) { out.push_back(static_cast<std::uint8_t>(value)); }

void write16(Bytes& out, std::uint32_t value) {
  write8(out, value >> 8);
  write8(out, value);
}

void write32(Bytes& out, std::uint32_t value) {
  write16(out, value >> 16);
  write16(out, value);
}

void write_zeros(Bytes& out, std::size_t count) { out.insert(out.end(), count, 0); }

void write_text(Bytes& out, std::string_view text, std::size_t size) {
  const std::string_view kept = text.substr(0, size - 1);
  out.insert(out.end(), kept.begin(), kept.end());
  write_zeros(out, size - kept.size());
}

void write_operation(Bytes& out, std::uint16_t code, OperationStatus status) {
  write16(out, kVersion);
  write16(out, code);
  write32(out, static_cast<std::uint32_t>(status));
}

// Offsets within the device descriptor (USB 2.0, table 9-8), which is little endian.
constexpr std::size_t kClass = 4;
constexpr std::size_t kVendor = 8;
constexpr std::size_t kConfigurations = 17;
// Within the configuration descriptor (table 9-10).
constexpr std::size_t kInterfaces = 4;
constexpr std::size_t kConfigurationValue = 5;

void write_device(Bytes& out, const DeviceRecord& device) {
  write_text(out, device.path, kPathSize);
  write_text(out, device.bus_id, kBusIdSize);
  write32(out, device.bus);
  write32(out, device.device);
  write32(out, device.speed);
  for (std::size_t at = kVendor; at < kVendor + 6; at += 2) {  // vendor, product, release
    write8(out, device.device_descriptor[at + 1]);
    write8(out, device.device_descriptor[at]);
  }
  for (std::size_t at = kClass; at < kClass + 3; ++at) {  // class, subclass, protocol
    write8(out, device.device_descriptor[at]);
  }
  write8(out, device.configuration_descriptor[kConfigurationValue]);
  write8(out, device.device_descriptor[kConfigurations]);
  write8(out, device.configuration_descriptor[kInterfaces]);
}

void write_interfaces(Bytes& out, std::span<const std::uint8_t> configuration) {
  constexpr std::uint8_t kInterfaceType = 4;
  for (std::size_t at = 0; at < configuration.size(); at += configuration[at]) {
    if (configuration[at + 1] != kInterfaceType) continue;
    for (std::size_t i = 5; i < 8; ++i) write8(out, configuration[at + i]);
    write8(out, 0);
  }
}

/// The basic header; the fields that only requests use are zero.
void write_basic(Bytes& out, std::uint32_t command, std::uint32_t sequence) {
  write32(out, command);
  write32(out, sequence);
  write_zeros(out, 12);
}

}  // namespace

OperationHeader read_operation(std::span<const std::uint8_t> bytes) {
  return {read16(bytes, 0), read16(bytes, 2)};
}

std::string_view read_bus_id(std::span<const std::uint8_t> bytes) {
  const auto field = bytes.first(kBusIdSize);
  const auto end = std::ranges::find(field, std::uint8_t{0});
  return {reinterpret_cast<const char*>(field.data()),
          static_cast<std::size_t>(end - field.begin())};
}

void write_device_list(Bytes& out, const DeviceRecord& device) {
  write_operation(out, kListReply, OperationStatus::ok);
  write32(out, 1);
  write_device(out, device);
  write_interfaces(out, device.configuration_descriptor);
}

void write_import(Bytes& out, const DeviceRecord& device) {
  write_operation(out, kImportReply, OperationStatus::ok);
  write_device(out, device);
}

void write_refusal(Bytes& out, OperationStatus status) {
  write_operation(out, kImportReply, status);
}

Request read_request(std::span<const std::uint8_t> bytes) {
  const std::uint32_t command = read32(bytes, 0);
  const std::uint32_t sequence = read32(bytes, 4);
  const std::uint32_t device_id = read32(bytes, 8);
  if (command == kUnlink) {
    return {.submit = {},
            .unlink =
                Unlink{.sequence = sequence, .device_id = device_id, .target = read32(bytes, 20)}};
  }
  const std::uint32_t direction = read32(bytes, 12);
  if (command != kSubmit || direction > 1) return {};
  Submit submit{.sequence = sequence,
                .device_id = device_id,
                .direction = static_cast<Direction>(direction),
                .endpoint = read32(bytes, 16),
                .length = read32(bytes, 24),
                .packets = read32(bytes, 32)};
  std::copy_n(bytes.begin() + 40, submit.setup.size(), submit.setup.begin());
  return {.submit = submit, .unlink = {}};
}

void write_submit_reply(Bytes& out, const Submit& submit, std::int32_t status,
                        std::uint32_t actual_length, std::span<const std::uint8_t> data) {
  write_basic(out, kSubmitReply, submit.sequence);
  write32(out, static_cast<std::uint32_t>(status));
  write32(out, actual_length);
  write32(out, 0);  // start frame
  // As it came: clients differ in how they say that a transfer is not isochronous.
  write32(out, submit.packets);
  write_zeros(out, 4 + 8);
  out.insert(out.end(), data.begin(), data.end());
}

void write_unlink_reply(Bytes& out, std::uint32_t sequence, std::int32_t status) {
  write_basic(out, kUnlinkReply, sequence);
  write32(out, static_cast<std::uint32_t>(status));
  write_zeros(out, 24);
}

}  // namespace torsio::emulator::usbip
