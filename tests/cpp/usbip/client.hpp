/// @file
/// A USB/IP client made of bytes, after the kernel's documentation and without the server's codec.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "emulator/usbip/session.hpp"
#include "emulator/usbip/usb_knob.hpp"

namespace usbip_test {

using Bytes = std::vector<std::uint8_t>;

/// 32-bit numbers, big endian.
inline Bytes words(std::initializer_list<std::uint32_t> values) {
  Bytes bytes;
  for (const std::uint32_t value : values) {
    for (const int shift : {24, 16, 8, 0}) {
      bytes.push_back(static_cast<std::uint8_t>(value >> shift));
    }
  }
  return bytes;
}

inline Bytes operator+(Bytes left, const Bytes& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

inline std::uint32_t word(const Bytes& bytes, std::size_t at) {
  return (std::uint32_t{bytes.at(at)} << 24) | (std::uint32_t{bytes.at(at + 1)} << 16) |
         (std::uint32_t{bytes.at(at + 2)} << 8) | bytes.at(at + 3);
}

inline Bytes padded(Bytes bytes, std::size_t size) {
  bytes.resize(size, 0);
  return bytes;
}

inline Bytes text(std::string_view text) { return {text.begin(), text.end()}; }

inline const Bytes kListRequest = words({0x01118005, 0});
inline Bytes import_request(std::string_view bus_id = "1-1") {
  return words({0x01118003, 0}) + padded(text(bus_id), 32);
}

constexpr std::uint32_t kDeviceId = 0x00010002;

inline Bytes submit_header(std::uint32_t sequence, std::uint32_t direction, std::uint32_t endpoint,
                           std::uint32_t length, const Bytes& setup = Bytes(8)) {
  return words({1, sequence, kDeviceId, direction, endpoint, 0, length, 0, 0xFFFFFFFF, 0}) + setup;
}

inline Bytes unlink_request(std::uint32_t sequence, std::uint32_t target) {
  return padded(words({2, sequence, kDeviceId, 0, 0, target}), 48);
}

/// A setup packet: its numbers are little endian.
inline Bytes setup_packet(std::uint8_t kind, std::uint8_t request, std::uint16_t value,
                          std::uint16_t index, std::uint16_t length) {
  const auto low = [](std::uint16_t number) { return static_cast<std::uint8_t>(number); };
  const auto high = [](std::uint16_t number) { return static_cast<std::uint8_t>(number >> 8); };
  return {kind,       request,     low(value),  high(value),
          low(index), high(index), low(length), high(length)};
}

struct Reply {
  std::uint32_t command = 0;
  std::uint32_t sequence = 0;
  std::int32_t status = 0;
  std::uint32_t length = 0;
  Bytes data;
};

/// A knob and one client of it, without sockets.
class Client {
 public:
  explicit Client(torsio::emulator::usbip::UsbKnob& knob)
      : knob_(knob), session_(knob.exported()) {}

  torsio::emulator::usbip::Session& session() { return session_; }

  void send(const Bytes& bytes) { session_.receive(bytes); }

  /// Everything that has come.
  Bytes take() { return std::exchange(session_.output(), {}); }

  /// 1 ms of bus and world.
  void frame() {
    session_.frame();
    knob_.advance();
  }

  void attach() {
    send(import_request());
    const Bytes answer = take();
    if (answer.size() != 320 || word(answer, 4) != 0) throw std::runtime_error("not attached");
  }

  void configure() {
    if (control_out(setup_packet(0x00, 9, 1, 0, 0)).status != 0) {
      throw std::runtime_error("not configured");
    }
  }

  std::uint32_t submit_in(std::uint32_t endpoint, std::uint32_t length) {
    send(submit_header(number_in(), 1, endpoint, length));
    return sequence_;
  }
  std::uint32_t submit_out(std::uint32_t endpoint, const Bytes& data) {
    const auto size = static_cast<std::uint32_t>(data.size());
    send(submit_header(++sequence_, 0, endpoint, size) + data);
    return sequence_;
  }

  /// The oldest reply, if there is one.
  std::optional<Reply> reply() {
    const Bytes fresh = take();
    received_.insert(received_.end(), fresh.begin(), fresh.end());
    if (received_.size() < 48) return std::nullopt;
    Reply reply{word(received_, 0),
                word(received_, 4),
                static_cast<std::int32_t>(word(received_, 20)),
                0,
                {}};
    const bool is_submit = reply.command == 3;
    if (is_submit) reply.length = word(received_, 24);
    const bool is_in = is_submit && in_.contains(reply.sequence);
    const std::size_t size = 48 + (is_in ? reply.length : 0);
    reply.data.assign(received_.begin() + 48,
                      received_.begin() + static_cast<std::ptrdiff_t>(size));
    received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
    return reply;
  }

  /// The next reply within so many frames.
  Reply wait(int frames = 20) {
    for (int i = 0; i < frames; ++i) {
      if (auto found = reply()) return *found;
      frame();
    }
    throw std::runtime_error("no reply");
  }

  Reply control_in(const Bytes& setup, std::uint32_t room) {
    send(submit_header(number_in(), 1, 0, room, setup));
    return reply().value();
  }
  Reply control_out(const Bytes& setup, const Bytes& data = {}) {
    const auto size = static_cast<std::uint32_t>(data.size());
    send(submit_header(++sequence_, 0, 0, size, setup) + data);
    return reply().value();
  }

  Reply get_feature(std::uint8_t id) {
    return control_in(setup_packet(0xA1, 1, static_cast<std::uint16_t>(0x0300 | id), 0, 64), 64);
  }
  Reply set_feature(const Bytes& report, std::uint16_t announced = 64) {
    const auto value = static_cast<std::uint16_t>(0x0300 | report.at(0));
    return control_out(setup_packet(0x21, 9, value, 0, announced), report);
  }

 private:
  /// A number for an IN transfer: only who sent it knows that its reply carries data.
  std::uint32_t number_in() {
    in_.insert(++sequence_);
    return sequence_;
  }

  torsio::emulator::usbip::UsbKnob& knob_;
  torsio::emulator::usbip::Session session_;
  std::uint32_t sequence_ = 100;
  std::set<std::uint32_t> in_;
  Bytes received_;
};

}  // namespace usbip_test
