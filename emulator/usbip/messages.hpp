/// @file
/// The messages of USB/IP 1.1.1 as they travel over TCP, big endian; nothing but bytes. The
/// protocol is described in the Linux kernel's documentation, "USB/IP protocol".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace torsio::emulator::usbip {

using Bytes = std::vector<std::uint8_t>;

inline constexpr std::uint16_t kVersion = 0x0111;

// Before a device is imported -----------------------------------------------------------------

enum class Operation : std::uint16_t { import_device = 0x8003, list_devices = 0x8005 };
/// In the order of the numbers that Linux's usbip knows.
enum class OperationStatus : std::uint32_t { ok, not_available, busy, device_error, no_device };

inline constexpr std::size_t kOperationSize = 8;
inline constexpr std::size_t kBusIdSize = 32;

struct OperationHeader {
  std::uint16_t version;
  std::uint16_t code;
};

/// @param bytes at least kOperationSize
OperationHeader read_operation(std::span<const std::uint8_t> bytes);

/// @param bytes at least kBusIdSize
/// @returns the text before the first zero, all of the field if there is none
std::string_view read_bus_id(std::span<const std::uint8_t> bytes);

/// A device's description before a client asks the device itself.
struct DeviceRecord {
  std::string_view path;    // shorter than 256 characters
  std::string_view bus_id;  // shorter than 32
  std::uint32_t bus = 1;
  std::uint32_t device = 1;
  std::uint32_t speed = 2;  // enum usb_device_speed of Linux: full speed
  std::span<const std::uint8_t> device_descriptor;
  std::span<const std::uint8_t> configuration_descriptor;

  /// The client's name of the device in its requests.
  [[nodiscard]] std::uint32_t id() const { return (bus << 16) | device; }
};

void write_device_list(Bytes& out, const DeviceRecord& device);
void write_import(Bytes& out, const DeviceRecord& device);
void write_refusal(Bytes& out, OperationStatus status);

// Once it is imported -------------------------------------------------------------------------

inline constexpr std::size_t kHeaderSize = 48;

enum class Direction : std::uint8_t { out, in };

/// Asks for one transfer (a URB).
struct Submit {
  std::uint32_t sequence = 0;
  std::uint32_t device_id = 0;
  Direction direction = Direction::out;
  std::uint32_t endpoint = 0;
  std::uint32_t length = 0;   // of the client's buffer; OUT: of the data behind the header
  std::uint32_t packets = 0;  // of an isochronous transfer; 0 or 0xFFFFFFFF for all others
  std::array<std::uint8_t, 8> setup{};
};

/// Takes a transfer back.
struct Unlink {
  std::uint32_t sequence = 0;
  std::uint32_t device_id = 0;
  std::uint32_t target = 0;  // sequence number of the transfer
};

struct Request {
  std::optional<Submit> submit;
  std::optional<Unlink> unlink;
};

/// @param bytes at least kHeaderSize
/// @returns neither, for a command or a direction that does not exist
Request read_request(std::span<const std::uint8_t> bytes);

// Negative errno numbers of Linux.
inline constexpr std::int32_t kOk = 0;
inline constexpr std::int32_t kStalled = -32;    // EPIPE
inline constexpr std::int32_t kOverflow = -75;   // EOVERFLOW
inline constexpr std::int32_t kUnlinked = -104;  // ECONNRESET

/// @param data what an IN transfer brought; nothing for OUT
/// @param actual_length bytes that went either way
void write_submit_reply(Bytes& out, const Submit& submit, std::int32_t status,
                        std::uint32_t actual_length, std::span<const std::uint8_t> data);
void write_unlink_reply(Bytes& out, std::uint32_t sequence, std::int32_t status);

}  // namespace torsio::emulator::usbip
